"""What every game promises, whatever it is played in."""

import json
import pickle
from collections.abc import Iterator

import numpy as np
import pytest

from tests.tril.games.examples import examples_installed
from tril.games import game_named, game_titles, published
from tril.games.base import Console, EndKind, Game, Start, UnknownStart, start_of
from tril.games.seeds import SeedStart
from tril.play.episode import Episode
from tril.recording import Recorder, trajectory, verify

GAMES = (
    "space_invaders",
    "breakout",
    "boxing",
    "gym:CartPole-v1",
    "gym:MiniGrid-DoorKey-5x5-v0",
    "gym:highway-fast-v0",
    "catch",
    "gym:Catch-v0",
)
FRAMES = 24
"""Fewer than the shortest game of random actions may have would be too few to tell anything."""


@pytest.fixture(scope="module", autouse=True)
def installed() -> Iterator[None]:
    with examples_installed():
        yield


@pytest.fixture(scope="module", params=GAMES)
def game(request: pytest.FixtureRequest, installed: None) -> Game:
    return game_named(request.param)


@pytest.fixture(scope="module")
def console(game: Game) -> Console:
    return game.make_console()


def random_actions(game: Game, count: int = FRAMES, seed: int = 0) -> list[int]:
    return [
        int(a) for a in np.random.default_rng(seed).integers(game.controls.n_actions, size=count)
    ]


def play(console: Console, start: Start, actions: list[int]) -> list[tuple[bytes, str, bool]]:
    """Return what is seen at a start and after every frame, until the game is over."""
    console.start(start)
    seen = [(console.screen().tobytes(), console.state_hash(), console.over)]
    for action in actions:
        if console.over:
            break
        console.act(action)
        seen.append((console.screen().tobytes(), console.state_hash(), console.over))
    return seen


def test_equal_starts_and_actions_give_equal_frames(game: Game, console: Console) -> None:
    start, other = game.starts.training[:2]
    actions = random_actions(game)
    first = play(console, start, actions)
    assert len({screen for screen, _, _ in first}) > 1
    play(console, other, actions[:5])
    assert play(console, start, actions) == first
    fresh = game.make_console()
    assert play(fresh, start, actions) == first
    fresh.close()


def test_screens_have_the_shape_that_the_game_tells(game: Game, console: Console) -> None:
    console.start(game.starts.training[0])
    screen = console.screen()
    assert screen.shape == game.screen.shape
    assert screen.dtype == np.uint8
    out = np.zeros(game.screen.shape, np.uint8)
    assert console.screen(out) is out
    np.testing.assert_array_equal(out, screen)
    for area in game.screen.hidden:
        assert area.right <= game.screen.width
        assert area.bottom <= game.screen.height


def test_a_screen_that_was_returned_does_not_change(game: Game, console: Console) -> None:
    console.start(game.starts.training[0])
    screen = console.screen()
    before = screen.copy()
    screen[:] = 0
    np.testing.assert_array_equal(console.screen(), before)


def test_hashes_are_sixteen_hexadecimal_digits(game: Game, console: Console) -> None:
    console.start(game.starts.training[0])
    assert len(bytes.fromhex(console.state_hash())) == 8
    assert bool(console.ram_bytes()) is game.has_memory


def test_a_saved_state_continues_alike_in_another_console(game: Game, console: Console) -> None:
    if not game.saves_states:
        pytest.skip("It saves no states.")
    actions = random_actions(game)
    whole = play(console, game.starts.training[3], actions)
    half = len(whole) // 2
    play(console, game.starts.training[3], actions[:half])
    score = console.score
    data = console.save().to_bytes()
    other = game.make_console()
    play(other, game.starts.training[7], actions[:3])
    other.restore(other.state_from_bytes(data))
    assert other.score == score
    continued = []
    for action in actions[half : len(whole) - 1]:
        other.act(action)
        continued.append((other.screen().tobytes(), other.state_hash(), other.over))
    assert continued == whole[half + 1 :]
    other.close()


def test_states_of_another_format_are_refused(game: Game, console: Console) -> None:
    for data in (b"", b"\xff" + bytes(40)):
        with pytest.raises(ValueError, match="version"):
            console.state_from_bytes(data)


def test_an_episode_is_equal_after_a_restore(game: Game, console: Console) -> None:
    if not game.saves_states:
        pytest.skip("It saves no states.")
    actions = random_actions(game, seed=2)
    episode = Episode(console, game.starts.training[1], max_frames=FRAMES)

    def go_on() -> list[object]:
        seen: list[object] = []
        while episode.end is None:
            episode.advance(actions[episode.frame])
            marks = episode.readout.marks(console)
            seen.append((episode.end, episode.taken, episode.counters, marks, episode.score))
            assert len(marks) == (game.overlay.marks_bytes if game.overlay else 0)
        return seen

    for action in actions[:4]:
        episode.advance(action)
    state = episode.save()
    json.dumps(state.readout)
    first = go_on()
    episode.restore(state)
    assert go_on() == first
    assert episode.end in {end.name for end in game.ends}


def test_evaluation_starts_are_not_for_training(game: Game) -> None:
    starts = game.starts
    evaluation = [starts.evaluation(number) for number in range(starts.n_evaluation)]
    assert len(set(evaluation)) == starts.n_evaluation
    assert not set(evaluation) & set(starts.training)
    assert [starts.evaluation_number(start) for start in evaluation] == list(
        range(starts.n_evaluation)
    )
    assert all(starts.evaluation_number(start) is None for start in starts.training)
    for number in (-1, starts.n_evaluation):
        with pytest.raises(UnknownStart, match="start number"):
            starts.evaluation(number)


def test_starts_are_read_as_they_were_written(game: Game) -> None:
    starts = game.starts
    for start in (*starts.training[:5], starts.evaluation(0)):
        assert starts.parse(json.loads(json.dumps(start.to_json()))) == start
        assert all(type(value) is int for value in start.key)
    good = starts.training[0].to_json()
    for bad in ({}, good | {"else": 1}, dict.fromkeys(good, -1), dict.fromkeys(good, "1")):
        with pytest.raises(UnknownStart):
            starts.parse(bad)
    with pytest.raises(UnknownStart):
        starts.with_options({"nothing": 1})


def test_openings_are_fixed_for_evaluation_and_drawn_otherwise(game: Game) -> None:
    starts = game.starts
    assert starts.evaluation_opening(3) == starts.evaluation_opening(3)
    assert start_of(starts.evaluation_opening(3)) == starts.evaluation(3)
    assert len({starts.evaluation_opening(n).actions for n in range(starts.n_evaluation)}) > 1
    drawn = starts.draw_opening(starts.training[0], np.random.default_rng(5))
    assert drawn == starts.draw_opening(starts.training[0], np.random.default_rng(5))
    assert all(0 <= action < game.controls.n_actions for action in drawn.actions)


def test_every_action_has_its_buttons(game: Game) -> None:
    controls = game.controls
    for action in range(controls.n_actions):
        assert controls.action_for(controls.held[action]) == action
    assert set(controls.default_keys.values()) == set(controls.buttons)
    assert controls.all_buttons.bit_length() == len(controls.buttons)
    assert (0 in controls.held) is not controls.waits
    if not controls.waits:
        assert controls.action_for(0) == controls.noop
    for held in range(min(controls.all_buttons + 1, 4096)):
        assert 0 <= controls.action_for(held) < controls.n_actions


def test_ends_and_rules_have_names_of_their_own(game: Game) -> None:
    for named in (game.ends, game.end_rules):
        names = [one.name for one in named]
        assert len(set(names)) == len(names)
    assert [end.kind for end in game.ends].count(EndKind.TIME) == 1
    assert game.end_rule == game.end_rules[0].name


def test_it_is_pickled_by_name(game: Game) -> None:
    data = pickle.dumps(game)
    assert len(data) < 1000
    assert pickle.loads(data) is game


def test_a_recording_replays_and_yields_observations(game: Game, console: Console) -> None:
    recorder = Recorder(Episode(console, game.starts.training[2]))
    for action in random_actions(game, seed=1):
        if recorder.episode.end is None:
            recorder.advance(action)
    recording = recorder.recording()
    assert verify(recording, console=console).replay == recorder.replay()
    seen = trajectory(recording, console)
    assert len(seen.actions) == game.clock.n_steps(recording.n_frames)
    assert seen.observations.max() > 0


def test_the_examples_of_the_documentation_are_found_as_installed_games_are() -> None:
    assert game_titles()["catch"] == "Catch"
    catch = game_named("catch")
    assert catch.behaviours
    assert not set(catch.behaviours) & set(published()), "they are offered, not added"
    for behaviour in catch.behaviours:
        catch.check_target(behaviour)


def test_fruits_caught_are_items_of_the_example() -> None:
    catch = game_named("catch")
    start = SeedStart(4)
    columns = [int(c) for c in np.random.default_rng(4).integers(7, size=10)]
    for end_rule, end in (("miss", "caught"), ("all", "caught")):
        episode = Episode(catch.make_console(), start, end_rule)
        while episode.end is None:
            wanted = columns[len(episode.taken)]
            basket = int(episode.console.screen()[-1, :, 2].argmax()) // 8
            episode.advance(0 if basket == wanted else 1 if wanted < basket else 2)
        assert episode.end == end
        assert [one.cell for one in episode.taken] == list(enumerate(columns))
    missed = Episode(catch.make_console(), start, "miss")
    while missed.end is None:
        missed.advance(1)
    assert (missed.end, missed.counters) == ("missed", {"missed": 1})
