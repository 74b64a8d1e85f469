import cv2
import numpy as np
import numpy.typing as npt
import pytest
from ale_py.vector_env import AtariVectorEnv

from tests.tril.conftest import random_actions
from tril.games.atari.console import Console
from tril.games.space_invaders.memory import INTRO_FRAMES, SCORE_ROWS
from tril.play.agent import AgentGame
from tril.play.episode import EndReason, Episode, Start
from tril.play.observation import (
    OBSERVATION_SHAPE,
    AgentView,
    AgentViews,
    Observation,
    preprocess,
)

Image = npt.NDArray[np.uint8]


def reference(first: Image, second: Image) -> Image:
    """Reduce a whole screen at once, as an independent computation."""
    brightest = np.maximum(first, second)
    reduced = cv2.resize(brightest, (84, 84), interpolation=cv2.INTER_AREA)
    reduced[:SCORE_ROWS] = 0
    return np.asarray(reduced, np.uint8)


def test_observations_equal_those_of_ales_own_vector_environment(console: Console) -> None:
    start = Start(40)
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
            masked[:, :SCORE_ROWS] = 0
            np.testing.assert_array_equal(game.observation, masked)
            compared += 1
    vector.close()
    assert compared > 50


def test_the_newest_screen_is_the_brighter_of_the_last_two_frames(console: Console) -> None:
    for seed, start in enumerate((Start(1), Start(94), Start(30, difficulty=1))):
        episode, view = Episode(console, start), AgentView()
        view.reset(console)
        expected = [view.observation[0]] * 4
        gray = console.screen_grayscale()
        for action in random_actions(seed=seed, frames=1200):
            before, gray = gray, console.screen_grayscale()
            episode.advance(action)
            view.update(console, episode.frame)
            before, gray = gray, console.screen_grayscale()
            if episode.frame % 4 == 0:
                np.testing.assert_array_equal(preprocess(before, gray), reference(before, gray))
                expected = [*expected[1:], reference(before, gray)]
            np.testing.assert_array_equal(view.observation, expected)
            if episode.end is not None:
                break


def test_the_rows_left_out_hold_the_score_the_bonus_ship_and_missiles(console: Console) -> None:
    score, ground, missile, bonus_ship, alien = 196, 246, 6, 82, 20
    masked_rows = SCORE_ROWS * 210 // 84
    masked: set[int] = set()
    below: set[int] = set()
    console.start(Start(40))
    for _ in range(2000):
        console.act(1)
        screen = console.screen_palette()
        masked |= set(np.unique(screen[:masked_rows]).tolist())
        below |= set(np.unique(screen[masked_rows:150]).tolist())
    assert masked == {0, score, ground, missile, bonus_ship}
    assert below == {0, missile, alien}


def test_any_pixels_are_reduced_as_the_whole_screen_is() -> None:
    rng = np.random.default_rng(0)
    for _ in range(20):
        first, second = rng.integers(256, size=(2, 210, 160), dtype=np.uint8)
        np.testing.assert_array_equal(preprocess(first, second), reference(first, second))


def test_at_a_start_the_stack_holds_the_starts_screen_four_times(console: Console) -> None:
    game = AgentGame(console)
    game.reset(Start(33))
    gray = console.screen_grayscale()
    assert game.observation.shape == OBSERVATION_SHAPE
    for screen in game.observation:
        np.testing.assert_array_equal(screen, reference(gray, gray))
    first = game.observation[0]
    game.step(0)
    np.testing.assert_array_equal(game.observation[:3], [first] * 3)


def test_a_new_game_does_not_see_the_last_one(console: Console) -> None:
    game = AgentGame(console)
    game.reset(Start(33))
    fresh = game.observation
    for action in random_actions(seed=3, frames=60, hold=1):
        game.step(action)
    game.reset(Start(33))
    np.testing.assert_array_equal(game.observation, fresh)


def play_to_the_hit(game: AgentGame) -> None:
    game.reset(Start(0))
    while game.end is None:
        game.step(0)


def test_the_step_of_the_hit_is_completed_for_the_observation_only(console: Console) -> None:
    game = AgentGame(console)
    play_to_the_hit(game)
    assert game.end is EndReason.HIT
    assert (game.episode.frame, game.steps) == (443, 111)
    console.start(Start(0))
    for _ in range(443):
        console.act(0)
    before = console.screen_grayscale()
    console.act(0)
    np.testing.assert_array_equal(
        game.observation[3], reference(before, console.screen_grayscale())
    )


def test_demonstrations_and_training_see_equal_observations_for_equal_frames(
    console: Console,
) -> None:
    trained = AgentGame(console)
    play_to_the_hit(trained)
    episode, view = Episode(Console(), Start(0)), AgentView()
    view.reset(episode.console)
    for action in trained.episode.actions:
        episode.advance(action)
        view.update(episode.console, episode.frame)
    view.finish_step(episode.console, episode.frame)
    np.testing.assert_array_equal(view.observation, trained.observation)


@pytest.mark.parametrize("frame", [120, 121, 122, 123])
def test_a_restored_view_goes_on_from_any_frame_of_a_step(console: Console, frame: int) -> None:
    actions = random_actions(seed=5, frames=200, hold=3)
    episode, view = Episode(console, Start(8)), AgentView()
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
    view = AgentView()
    view.restore(saved_view)
    np.testing.assert_array_equal(advance(actions[frame:]), expected)


def test_batched_views_equal_single_views() -> None:
    """Also where some of them end, begin anew, are restored or stand still."""
    count = 4
    together = [AgentGame(Console(), view=view) for view in AgentViews(count)]
    alone = [AgentGame(Console()) for _ in range(count)]
    rng = np.random.default_rng(1)
    saved = None
    for index in range(count):
        together[index].reset(Start(index))
        alone[index].reset(Start(index))
    for step in range(260):
        stepped = [index for index in range(count) if rng.random() < 0.9]
        for index in stepped:
            if alone[index].end is not None:
                start = Start(int(rng.integers(128)))
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
