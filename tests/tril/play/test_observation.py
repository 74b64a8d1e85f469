import cv2
import numpy as np
import numpy.typing as npt
import pytest
from ale_py.vector_env import AtariVectorEnv

from tests.tril.conftest import random_actions
from testsupport.space_invaders import grayscale
from tril.games.atari.console import AtariConsole
from tril.games.atari.palette import palette_grayscale
from tril.games.atari.starts import AtariStart
from tril.games.space_invaders import SPACE_INVADERS
from tril.games.space_invaders.ends import EndReason
from tril.games.space_invaders.memory import INTRO_FRAMES, SCORE_PX
from tril.play.agent import AgentGame
from tril.play.episode import Episode
from tril.play.observation import (
    OBSERVATION_SHAPE,
    AgentView,
    Observation,
    agent_views,
)

Image = npt.NDArray[np.uint8]


def reference(first: Image, second: Image) -> Image:
    """Reduce a whole screen at once, as an independent computation."""
    brightest = np.maximum(first, second)
    reduced = cv2.resize(brightest, (84, 84), interpolation=cv2.INTER_AREA)
    reduced[: (SCORE_PX * 84 // 210)] = 0
    return np.asarray(reduced, np.uint8)


def test_observations_equal_those_of_ales_own_vector_environment(console: AtariConsole) -> None:
    start = AtariStart(40)
    vector = AtariVectorEnv(
        "space_invaders", num_envs=1, noop_max=0, use_fire_reset=False, reward_clipping=False
    )
    vector.reset(seed=0)
    for _ in range((INTRO_FRAMES + start.idle_frames) // 4):
        vector.step(np.array([0]))
    game = AgentGame(console)
    game.reset(start)
    compared = 0
    for action in random_actions(seed=0, frames=300, hold=1):
        theirs = vector.step(np.array([action]))[0][0]
        game.step(action)
        if game.end is not None:
            break
        if game.steps >= 4:
            masked = theirs.copy()
            masked[:, : (SCORE_PX * 84 // 210)] = 0
            np.testing.assert_array_equal(game.observation, masked)
            compared += 1
    vector.close()
    assert compared > 50


def test_the_newest_screen_is_the_brighter_of_the_last_two_frames(console: AtariConsole) -> None:
    for seed, start in enumerate((AtariStart(1), AtariStart(94), AtariStart(30, difficulty=1))):
        episode, view = Episode(console, start), AgentView(SPACE_INVADERS)
        view.reset(console)
        expected = [view.observation[0]] * 4
        gray = grayscale(console)
        for action in random_actions(seed=seed, frames=1200):
            before, gray = gray, grayscale(console)
            episode.advance(action)
            view.update(console, episode.frame)
            before, gray = gray, grayscale(console)
            if episode.frame % 4 == 0:
                expected = [*expected[1:], reference(before, gray)]
            np.testing.assert_array_equal(view.observation, expected)
            if episode.end is not None:
                break


def test_the_rows_left_out_hold_the_score_the_bonus_ship_and_missiles(
    console: AtariConsole,
) -> None:
    score, ground, missile, bonus_ship, alien = 196, 246, 6, 82, 20
    masked_rows = SCORE_PX
    masked: set[int] = set()
    below: set[int] = set()
    console.start(AtariStart(40))
    for _ in range(2000):
        console.act(1)
        screen = console.screen()
        masked |= set(np.unique(screen[:masked_rows]).tolist())
        below |= set(np.unique(screen[masked_rows:150]).tolist())
    assert masked == {0, score, ground, missile, bonus_ship}
    assert below == {0, missile, alien}


def test_any_pixels_are_reduced_as_the_whole_screen_is() -> None:
    rng = np.random.default_rng(0)
    for _ in range(20):
        views = agent_views(SPACE_INVADERS)
        frames = rng.integers(256, size=(2, 210, 160), dtype=np.uint8)
        views.frames[0] = frames
        views.reset(0)
        views.flush()
        first, second = palette_grayscale()[frames]
        np.testing.assert_array_equal(views.stacks[0, -1], reference(first, second))


def test_at_a_start_the_stack_holds_the_starts_screen_four_times(console: AtariConsole) -> None:
    game = AgentGame(console)
    game.reset(AtariStart(33))
    gray = grayscale(console)
    assert game.observation.shape == OBSERVATION_SHAPE
    for screen in game.observation:
        np.testing.assert_array_equal(screen, reference(gray, gray))
    first = game.observation[0]
    game.step(0)
    np.testing.assert_array_equal(game.observation[:3], [first] * 3)


def test_a_new_game_does_not_see_the_last_one(console: AtariConsole) -> None:
    game = AgentGame(console)
    game.reset(AtariStart(33))
    fresh = game.observation
    for action in random_actions(seed=3, frames=60, hold=1):
        game.step(action)
    game.reset(AtariStart(33))
    np.testing.assert_array_equal(game.observation, fresh)


def play_to_the_hit(game: AgentGame) -> None:
    game.reset(AtariStart(0))
    while game.end is None:
        game.step(0)


def test_the_step_of_the_hit_is_completed_for_the_observation_only(console: AtariConsole) -> None:
    game = AgentGame(console)
    play_to_the_hit(game)
    assert game.end == EndReason.HIT
    assert (game.episode.frame, game.steps) == (443, 111)
    console.start(AtariStart(0))
    for _ in range(443):
        console.act(0)
    before = grayscale(console)
    console.act(0)
    np.testing.assert_array_equal(game.observation[3], reference(before, grayscale(console)))


def test_demonstrations_and_training_see_equal_observations_for_equal_frames(
    console: AtariConsole,
) -> None:
    trained = AgentGame(console)
    play_to_the_hit(trained)
    episode, view = Episode(SPACE_INVADERS.make_console(), AtariStart(0)), AgentView(SPACE_INVADERS)
    view.reset(episode.console)
    for action in trained.episode.actions:
        episode.advance(action)
        view.update(episode.console, episode.frame)
    view.finish_step(episode.console, episode.frame)
    np.testing.assert_array_equal(view.observation, trained.observation)


@pytest.mark.parametrize("frame", [120, 121, 122, 123])
def test_a_restored_view_goes_on_from_any_frame_of_a_step(
    console: AtariConsole, frame: int
) -> None:
    actions = random_actions(seed=5, frames=200, hold=3)
    episode, view = Episode(console, AtariStart(8)), AgentView(SPACE_INVADERS)
    view.reset(console)

    def advance(actions: list[int]) -> list[Observation]:
        seen = []
        for action in actions:
            episode.advance(action)
            view.update(console, episode.frame)
            seen.append(view.observation)
        return seen

    advance(actions[:frame])
    saved_episode, saved_view = episode.save(), view.save()
    expected = advance(actions[frame:])
    episode.restore(saved_episode)
    view = AgentView(SPACE_INVADERS)
    view.restore(saved_view)
    np.testing.assert_array_equal(advance(actions[frame:]), expected)


def test_batched_views_equal_single_views() -> None:
    """Also where some of them end, begin anew, are restored or stand still."""
    count = 4
    together = [
        AgentGame(SPACE_INVADERS.make_console(), view=view)
        for view in agent_views(SPACE_INVADERS, count)
    ]
    alone = [AgentGame(SPACE_INVADERS.make_console()) for _ in range(count)]
    rng = np.random.default_rng(1)
    saved = None
    for index in range(count):
        together[index].reset(AtariStart(index))
        alone[index].reset(AtariStart(index))
    for step in range(260):
        stepped = [index for index in range(count) if rng.random() < 0.9]
        for index in stepped:
            if alone[index].end is not None:
                start = AtariStart(int(rng.integers(128)))
                together[index].reset(start)
                alone[index].reset(start)
            action = int(rng.integers(6))
            together[index].step(action)
            alone[index].step(action)
        if step == 50:
            saved = together[2].save(), alone[2].save()
        if step in (90, 150) and saved is not None:
            together[2].restore(saved[0])
            alone[2].restore(saved[1])
        for index in range(count) if step % 3 else ():
            np.testing.assert_array_equal(together[index].observation, alone[index].observation)
