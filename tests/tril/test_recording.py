from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tril.games import game_named
from tril.games.atari.starts import AtariStart
from tril.games.base import Console, Start
from tril.games.settings import GameSettings
from tril.games.space_invaders import SPACE_INVADERS
from tril.games.space_invaders.ends import EndReason
from tril.games.space_invaders.memory import Action
from tril.play.agent import AgentGame
from tril.play.episode import Episode, EpisodeEnded
from tril.recording import (
    Recorder,
    Recording,
    RecordingRefused,
    replay,
    step_actions,
    trajectory,
    verify,
)

short_plays = settings(max_examples=15, suppress_health_check=[HealthCheck.function_scoped_fixture])
starts = st.builds(AtariStart, st.integers(0, 127), difficulty=st.integers(0, 1))
# Actions held for a while, as people hold keys, so that something happens in a short game.
held_actions = st.lists(
    st.tuples(st.sampled_from(Action), st.integers(1, 40)), min_size=1, max_size=12
).map(lambda runs: bytes(action for action, length in runs for _ in range(length)))


@pytest.fixture(scope="module")
def console() -> Console:
    return SPACE_INVADERS.make_console()


@pytest.fixture(scope="module")
def other_console() -> Console:
    return SPACE_INVADERS.make_console()


@pytest.fixture(scope="module")
def hit_game(console: Console) -> Recording:
    """A game that ends by a hit within a step of the agent, at a frame that is no multiple of 4."""
    rng = np.random.default_rng(0)
    recorder = _played(console, AtariStart(5), bytes(rng.integers(6, size=1200).tolist()))
    assert recorder.episode.end == EndReason.HIT
    assert recorder.episode.frame % 4
    return recorder.recording()


def _played(console: Console, start: Start, actions: Sequence[int]) -> Recorder:
    recorder = Recorder(Episode(console, start))
    for action in actions:
        if recorder.episode.end is not None:
            break
        recorder.advance(action)
    return recorder


@short_plays
@given(starts, held_actions)
def test_a_replay_equals_the_play_frame_by_frame(
    console: Console, other_console: Console, start: Start, actions: bytes
) -> None:
    recorder = Recorder(Episode(console, start))
    seen = [(console.ram_bytes(), console.screen().tobytes())]
    for action in actions:
        if recorder.episode.end is None:
            recorder.advance(action)
            seen.append((console.ram_bytes(), console.screen().tobytes()))
    again: list[tuple[bytes, bytes]] = []
    played = replay(
        recorder.recording(),
        other_console,
        lambda episode: again.append(
            (episode.console.ram_bytes(), episode.console.screen().tobytes())
        ),
    )
    assert again == seen
    assert played == recorder.replay()
    assert len(played.hashes) == played.n_frames // 60


@short_plays
@given(starts, held_actions)
def test_a_recording_is_verified_as_it_was_played(
    console: Console, start: Start, actions: bytes
) -> None:
    recorder = _played(console, start, actions)
    hits = [hit.cell for hit in recorder.episode.taken]
    verified = verify(recorder.recording(), hits, console)
    assert verified.recording == recorder.recording()
    assert verified.replay == recorder.replay()
    assert verified.n_cut == 0


@short_plays
@given(starts, held_actions, st.data())
def test_a_changed_action_is_noticed_as_soon_as_it_changes_the_ram_at_a_hash(
    console: Console, other_console: Console, start: Start, actions: bytes, data: st.DataObject
) -> None:
    recording = _played(console, start, actions).recording()
    at = data.draw(st.integers(0, recording.n_frames - 1))
    changed = bytearray(recording.actions)
    changed[at] = data.draw(st.integers(0, 5).filter(lambda action: action != changed[at]))

    # Independently of the code: the RAM itself, after every second, in both games.
    def ram_each_second(played: bytes) -> list[bytes]:
        other_console.start(start)
        rams = []
        for frame, action in enumerate(played, start=1):
            other_console.act(action)
            if frame % 60 == 0:
                rams.append(other_console.ram_bytes())
        return rams

    forged = replace(recording, actions=bytes(changed))
    if ram_each_second(recording.actions) == ram_each_second(bytes(changed)):
        assert verify(forged, console=console).replay.hashes == recording.hashes
    else:
        with pytest.raises(RecordingRefused, match="differs from the recording"):
            verify(forged, console=console)


@pytest.mark.parametrize("frame", [0, 50, 175])
def test_two_frames_to_the_right_in_a_game_of_standing_still_are_noticed(
    console: Console, frame: int
) -> None:
    recording = _played(console, AtariStart(3), bytes(180)).recording()
    forged = bytearray(180)
    # The game reads the joystick at every other frame: one of these two.
    forged[frame : frame + 2] = bytes([Action.RIGHT, Action.RIGHT])
    with pytest.raises(RecordingRefused, match=f"after frame {-(-(frame + 1) // 60) * 60} "):
        verify(replace(recording, actions=bytes(forged)), console=console)


@short_plays
@given(starts, held_actions, st.data())
def test_a_resumed_game_goes_on_identically(
    console: Console, other_console: Console, start: Start, actions: bytes, data: st.DataObject
) -> None:
    whole = _played(console, start, actions).recording()
    left_at = data.draw(st.integers(0, whole.n_frames))
    begun = _played(console, start, whole.actions[:left_at]).recording()
    resumed = Recorder.resume(begun, other_console)
    assert resumed.recording() == begun
    for action in whole.actions[left_at:]:
        resumed.advance(action)
    assert resumed.recording() == whole
    assert resumed.replay() == replay(whole, console)


def test_a_game_that_does_not_replay_is_not_resumed(console: Console) -> None:
    begun = _played(console, AtariStart(3), bytes(120)).recording()
    with pytest.raises(RecordingRefused, match="after frame 60"):
        Recorder.resume(replace(begun, start=AtariStart(40)), console)


def test_a_game_that_is_over_resumes_as_over(console: Console, hit_game: Recording) -> None:
    resumed = Recorder.resume(hit_game, console)
    assert resumed.episode.end == EndReason.HIT
    with pytest.raises(EpisodeEnded):
        resumed.advance(Action.NOOP)
    longer = replace(hit_game, actions=hit_game.actions + b"\0", hashes=())
    with pytest.raises(RecordingRefused, match=f"ended at frame {hit_game.n_frames}"):
        Recorder.resume(longer, console)


def test_an_episode_under_way_is_not_recorded_from_the_middle(console: Console) -> None:
    episode = Episode(console, AtariStart(0))
    episode.advance(Action.NOOP)
    with pytest.raises(ValueError, match="at frame 1"):
        Recorder(episode)


@pytest.mark.parametrize("extra", [1, 59, 60, 500])
def test_actions_after_the_hit_on_the_player_are_cut(
    console: Console, hit_game: Recording, extra: int
) -> None:
    actions = hit_game.actions + bytes(extra)
    n_hashes = len(actions) // 60
    hashes = hit_game.hashes + ("0" * 16,) * (n_hashes - len(hit_game.hashes))
    verified = verify(replace(hit_game, actions=actions, hashes=hashes), console=console)
    assert verified.recording == hit_game
    assert verified.n_cut == extra
    assert verified.replay.end == EndReason.HIT


def test_missing_hashes_are_completed(console: Console, hit_game: Recording) -> None:
    assert verify(replace(hit_game, hashes=()), console=console).recording == hit_game


def test_a_recording_of_another_rom_is_refused(console: Console, hit_game: Recording) -> None:
    with pytest.raises(RecordingRefused, match="another version of Space Invaders"):
        verify(replace(hit_game, version="0" * 32), console=console)


def test_hits_that_do_not_happen_are_refused(console: Console, hit_game: Recording) -> None:
    hits = [(hit.row, hit.column) for hit in replay(hit_game, console).taken]
    assert len(hits) == 2
    assert verify(hit_game, hits, console).recording == hit_game
    for wrong in ([], hits[::-1], [*hits, (0, 5)]):
        with pytest.raises(RecordingRefused, match="replay takes row 1, column 1; row 2, column 1"):
            verify(hit_game, wrong, console)


def test_unknown_actions_and_wrong_numbers_of_hashes_are_refused(hit_game: Recording) -> None:
    with pytest.raises(RecordingRefused, match="got 6 at frame 2"):
        Recording(SPACE_INVADERS, AtariStart(0), b"\0\6")
    with pytest.raises(RecordingRefused, match="Expected 6 hashes of the memory"):
        replace(hit_game, hashes=hit_game.hashes[:-1])


@settings(short_plays, max_examples=6)
@given(starts, st.lists(st.sampled_from(Action), min_size=1, max_size=40))
def test_a_trajectory_holds_what_an_agent_saw_and_did(
    console: Console, other_console: Console, start: Start, actions: list[Action]
) -> None:
    game = AgentGame(console)
    game.reset(start)
    seen, done = [game.observation], []
    for action in actions:
        if game.end is None:
            game.step(action)
            seen.append(game.observation)
            done.append(action)
    found = trajectory(Recording(SPACE_INVADERS, start, game.episode.actions), other_console)
    np.testing.assert_array_equal(found.observations, np.stack(seen))
    np.testing.assert_array_equal(found.actions, done)
    assert found.n_steps == len(done)


@pytest.mark.parametrize("name", ["pong", "gym:CartPole-v1", "gym:Blackjack-v1"])
def test_a_trajectory_of_any_game_keeps_each_screen_once(name: str) -> None:
    game = game_named(name).with_settings(GameSettings(max_steps=40))
    console = game.make_console()
    agent, rng = AgentGame(console), np.random.default_rng(0)
    agent.reset(game.starts.evaluation(0))
    seen = [agent.observation]
    while agent.end is None:
        agent.step(int(rng.integers(game.controls.n_actions)))
        seen.append(agent.observation)
    played = Recording(game, game.starts.evaluation(0), agent.episode.actions)
    observations = trajectory(played, console).observations
    console.close()
    np.testing.assert_array_equal(observations, np.stack(seen))
    assert np.may_share_memory(observations[0], observations[-1]) == (
        len(observations) <= len(observations[0])
    )
    assert np.may_share_memory(observations[0], observations[1])


def test_a_trajectory_ends_with_the_whole_step_in_which_the_player_is_hit(
    console: Console, hit_game: Recording
) -> None:
    whole = trajectory(hit_game, console)
    assert whole.end == EndReason.HIT
    assert whole.n_steps == hit_game.n_steps == -(-hit_game.n_frames // 4)
    assert (whole.observations[-1] != whole.observations[-2]).any()
    assert [hit.cell for hit in whole.taken] == [(0, 0), (1, 0)]
    longer = replace(hit_game, actions=hit_game.actions + b"\1" * 9, hashes=())
    np.testing.assert_array_equal(trajectory(longer).observations, whole.observations)
    np.testing.assert_array_equal(trajectory(longer).actions, whole.actions)


@pytest.mark.parametrize(
    ("frames", "action"),
    [
        ([2, 2, 0, 0], 0),
        ([0, 2, 2, 0], 0),
        ([3, 3, 3, 1], 3),
        ([1, 2, 3, 4], 4),
        ([5, 0, 5, 1], 5),
        ([1, 2], 2),
        ([1, 1, 2], 1),
        ([4], 4),
    ],
)
def test_a_step_stands_for_the_action_executed_most_and_of_equals_the_last(
    frames: list[int], action: int
) -> None:
    found = step_actions(bytes([1, 1, 1, 1, *frames]), 4)
    assert found.dtype == np.int64
    assert found.tolist() == [1, action]


def test_no_frames_are_no_steps(console: Console) -> None:
    empty = Recording(SPACE_INVADERS, AtariStart(9), b"")
    assert step_actions(b"", 4).tolist() == []
    assert trajectory(empty, console).observations.shape == (1, 4, 84, 84)
    assert verify(empty, console=console).replay.end is None
