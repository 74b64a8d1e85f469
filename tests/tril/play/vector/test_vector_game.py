import os
import select
import signal
import subprocess
import sys
import textwrap
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

from testsupport.space_invaders import EVALUATION_STARTS
from tril.games.atari.starts import EVALUATION_START_COUNT, AtariStart
from tril.games.base import Console, Opening
from tril.games.space_invaders import SPACE_INVADERS
from tril.games.space_invaders.ends import Ending, EndReason
from tril.games.space_invaders.memory import Action
from tril.play.agent import AgentGame
from tril.play.episode import EpisodeEnded
from tril.play.observation import Observation
from tril.play.vector.vector_game import (
    DemonstrationLog,
    FinishedGame,
    FixedStarts,
    GameProcessFailed,
    ResetDistribution,
    TrainingStarts,
    VectorGame,
    VectorSnapshot,
)

ROOT = Path(__file__).parents[4]
# Short episodes, so that many end within few steps.
MAX_FRAMES = 120
DEMONSTRATION = DemonstrationLog(SPACE_INVADERS, AtariStart(7), bytes([2, 1, 4, 1] * 20))


@dataclass
class Trace:
    """What a vector gave."""

    observations: list[Observation]
    steps: list[list[int]]
    finished: list[FinishedGame]

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, Trace)
            and len(self.observations) == len(other.observations)
            and all(map(np.array_equal, self.observations, other.observations))
            and (self.steps, self.finished) == (other.steps, other.finished)
        )


def actions_of(vector: VectorGame, steps: int, seed: int = 0) -> npt.NDArray[np.int64]:
    return np.random.default_rng(seed).integers(6, size=(steps, vector.n_games))


def play(vector: VectorGame, actions: npt.NDArray[np.int64], first: Observation) -> Trace:
    trace = Trace([first.copy()], [], [])
    for row in actions:
        step = vector.step(row)
        trace.observations.append(step.observations.copy())
        trace.steps.append(step.steps.tolist())
        trace.finished.extend(step.finished)
        assert [one.game for one in step.finished] == np.flatnonzero(step.ended).tolist()
        for one in step.finished:
            assert step.ends[one.game] is one.end
    return trace


def traced(
    starts: ResetDistribution,
    *,
    n_games: int = 3,
    n_processes: int = 2,
    steps: int = 70,
    training_seed: int = 5,
    sticky: float = 0.0,
) -> Trace:
    with VectorGame(
        SPACE_INVADERS,
        n_games,
        starts,
        n_processes=n_processes,
        max_frames=MAX_FRAMES,
        training_seed=training_seed,
        sticky_action_probability=sticky,
    ) as vector:
        return play(vector, actions_of(vector, steps), vector.reset())


MIXED = TrainingStarts(SPACE_INVADERS, demonstrations=(DEMONSTRATION,), demonstration_share=0.5)


def test_a_vector_gives_the_trajectories_of_one_console(console: Console) -> None:
    starts = tuple(AtariStart(idle) for idle in (3, 50, 97))
    game = AgentGame(console)
    with VectorGame(
        SPACE_INVADERS, 3, FixedStarts(starts), n_processes=2, training_seed=0
    ) as vector:
        actions = actions_of(vector, 300)
        trace = play(vector, actions, vector.reset())
        terminal = vector.step(actions[0]).terminal_observations.copy()
        inactive = vector.inactive
    assert inactive.all()
    assert [one.start for one in sorted(trace.finished, key=lambda one: one.game)] == list(starts)
    for index, start in enumerate(starts):
        game.reset(start)
        np.testing.assert_array_equal(trace.observations[0][index], game.observation)
        for step, row in enumerate(actions):
            game.step(int(row[index]))
            if game.end is not None:
                break
            np.testing.assert_array_equal(trace.observations[step + 1][index], game.observation)
            assert trace.steps[step][index] == game.steps
        np.testing.assert_array_equal(terminal[index], game.observation)
        finished = next(one for one in trace.finished if one.game == index)
        assert finished.actions == game.episode.actions
        assert (finished.end, finished.taken) == (game.end, game.taken)


def test_the_number_of_processes_changes_nothing() -> None:
    one = traced(MIXED, n_processes=1, sticky=0.25)
    assert len(one.finished) >= 4
    assert traced(MIXED, n_processes=2, sticky=0.25) == one
    assert traced(MIXED, n_processes=8, sticky=0.25) == one


def test_the_same_training_seed_gives_the_same_games_and_another_others() -> None:
    first = traced(MIXED)
    assert traced(MIXED) == first
    assert traced(MIXED, training_seed=6) != first


def test_every_finished_game_replays_from_its_executed_actions(console: Console) -> None:
    trace = traced(MIXED, sticky=0.25, steps=100)
    assert {one.first_step > 0 for one in trace.finished} == {True, False}
    game = AgentGame(console, max_frames=MAX_FRAMES)
    for one in trace.finished:
        game.reset(one.start)
        for action in one.actions:
            game.advance(action)
        assert (game.end, game.taken) == (one.end, one.taken)


def test_games_begin_in_the_states_of_a_demonstration_and_keep_its_clock() -> None:
    source = TrainingStarts(
        SPACE_INVADERS, demonstrations=(DEMONSTRATION,), demonstration_share=1.0
    )
    trace = traced(source, steps=100)
    begun = {one.first_step for one in trace.finished}
    assert len(begun) > 3
    for one in trace.finished:
        frames = one.first_step * 4
        assert one.start == DEMONSTRATION.start
        assert one.actions[:frames] == DEMONSTRATION.actions[:frames]
        assert len(one.actions) <= MAX_FRAMES
    whole = [one for one in trace.finished if one.end == EndReason.STEPS]
    assert whole
    assert {len(one.actions) for one in whole} == {MAX_FRAMES}


def test_games_begin_after_an_opening_that_their_recordings_hold(console: Console) -> None:
    trace = traced(TrainingStarts(SPACE_INVADERS, opening_share=1.0), sticky=0.25, steps=100)
    assert not any(one.from_demonstration for one in trace.finished)
    assert len({one.first_step for one in trace.finished}) > 2
    game = AgentGame(console, max_frames=MAX_FRAMES)
    for one in trace.finished:
        game.reset(one.start)
        for action in one.actions:
            game.advance(action)
        assert (game.end, game.taken) == (one.end, one.taken)


def test_an_evaluation_opening_is_fixed_and_differs_from_the_others() -> None:
    openings = [
        SPACE_INVADERS.starts.evaluation_opening(number) for number in range(EVALUATION_START_COUNT)
    ]
    assert openings == [
        SPACE_INVADERS.starts.evaluation_opening(number) for number in range(EVALUATION_START_COUNT)
    ]
    assert len({opening.actions for opening in openings}) > 25
    assert [opening.start for opening in openings] == list(EVALUATION_STARTS)
    source = FixedStarts(tuple(openings))
    with VectorGame(SPACE_INVADERS, len(openings), source, n_processes=1, training_seed=0) as games:
        games.reset()
        steps = games.step(np.zeros(len(openings), np.int64)).steps
    # All survive their openings, which count towards the length of the game.
    assert steps.tolist() == [len(opening.actions) + 1 for opening in openings]


def test_every_evaluation_opening_leaves_a_game_that_can_be_survived(console: Console) -> None:
    def survives(opening: Opening, action: Action) -> bool:
        game = AgentGame(console)
        game.begin(opening)
        for _ in range(25):
            if game.end is None:
                game.step(int(action))
        return game.end is None

    moves = (Action.NOOP, Action.LEFT, Action.RIGHT)
    for number in range(EVALUATION_START_COUNT):
        opening = SPACE_INVADERS.starts.evaluation_opening(number)
        assert any(survives(opening, move) for move in moves), number


def test_a_demonstration_state_is_observed_as_it_was(console: Console) -> None:
    source = TrainingStarts(
        SPACE_INVADERS, demonstrations=(DEMONSTRATION,), demonstration_share=1.0
    )
    seen = []
    replay = AgentGame(console)
    replay.reset(DEMONSTRATION.start)
    for frame, action in enumerate(DEMONSTRATION.actions):
        if frame % 4 == 0:
            seen.append(replay.observation)
        replay.advance(action)
    with VectorGame(SPACE_INVADERS, 6, source, n_processes=1, training_seed=1) as vector:
        for observation in vector.reset():
            assert any(np.array_equal(observation, one) for one in seen)


def test_the_published_ending_is_an_option() -> None:
    starts = FixedStarts((AtariStart(0),))
    with VectorGame(
        SPACE_INVADERS, 1, starts, end_rule=Ending.LIFE_COUNTER, training_seed=0
    ) as vector:
        vector.reset()
        while not (step := vector.step(np.array([0]))).ended[0]:
            pass
    assert step.ends == (EndReason.LIVES,)
    assert len(step.finished[0].actions) == 571


def test_observations_stay_as_they_are_during_the_next_step() -> None:
    with VectorGame(
        SPACE_INVADERS, 2, TrainingStarts(SPACE_INVADERS), n_processes=1, training_seed=0
    ) as vector:
        vector.reset()
        actions = actions_of(vector, 20)
        before = vector.step(actions[0]).observations
        copy = before.copy()
        for row in actions[1:]:
            after = vector.step(row).observations
            np.testing.assert_array_equal(before, copy)
            before, copy = after, after.copy()


def test_a_restored_snapshot_goes_on_bit_by_bit_in_new_processes(tmp_path: Path) -> None:
    def make(n_processes: int) -> VectorGame:
        return VectorGame(
            SPACE_INVADERS,
            3,
            MIXED,
            n_processes=n_processes,
            max_frames=MAX_FRAMES,
            sticky_action_probability=0.25,
            training_seed=8,
        )

    with make(2) as vector:
        actions = actions_of(vector, 110)
        first = play(vector, actions[:41], vector.reset())
        arrays = vector.snapshot().to_arrays()
        np.savez(tmp_path / "snapshot.npz", sizes=arrays["sizes"], games=arrays["games"])
        expected = play(vector, actions[41:], first.observations[-1])
    with np.load(tmp_path / "snapshot.npz", allow_pickle=False) as file:
        snapshot = VectorSnapshot.from_arrays(dict(file))
    with make(1) as vector:
        restored = vector.restore(snapshot)
        np.testing.assert_array_equal(restored, first.observations[-1])
        assert play(vector, actions[41:], restored) == expected
    assert len(expected.finished) > 3


@pytest.mark.parametrize(("n_processes", "n_parts"), [(1, 2), (2, 2), (4, 2), (3, 3)])
def test_parts_step_by_themselves_and_change_nothing(n_processes: int, n_parts: int) -> None:
    expected = traced(MIXED, n_games=5, sticky=0.25)
    with VectorGame(
        SPACE_INVADERS,
        5,
        MIXED,
        n_processes=n_processes,
        n_parts=n_parts,
        max_frames=MAX_FRAMES,
        training_seed=5,
        sticky_action_probability=0.25,
    ) as vector:
        actions = actions_of(vector, 70)
        observations = [
            vector.reset().copy(),
            *(np.empty_like(o) for o in expected.observations[1:]),
        ]
        steps = np.zeros((70, 5), np.int64)
        finished: list[FinishedGame] = []
        assert [index for part in vector.parts for index in part] == list(range(5))
        assert len(vector.parts) == n_parts
        # Each part is a step ahead of the one after it.
        for now in range(70 + n_parts):
            for part, games in enumerate(vector.parts):
                own = slice(games.start, games.stop)
                step = now - part
                if 0 < step <= 70:
                    played = vector.step_wait(part)
                    observations[step][own] = played.observations
                    steps[step - 1, own] = played.steps
                    finished += played.finished
                    ended = games.start + np.flatnonzero(played.ended)
                    assert [one.game for one in played.finished] == ended.tolist()
                if 0 <= step < 70:
                    vector.step_async(actions[step, own], part)
        snapshot = vector.snapshot()
        assert len(snapshot.games) == 5
        np.testing.assert_array_equal(vector.restore(snapshot), observations[-1])
    finished.sort(key=lambda one: (one.game, one.start, one.actions))
    expected.finished.sort(key=lambda one: (one.game, one.start, one.actions))
    assert Trace(observations, steps.tolist(), finished) == expected
    assert len(finished) > 4


def test_a_part_that_is_under_way_waits_for_its_own_result() -> None:
    with VectorGame(
        SPACE_INVADERS, 4, TrainingStarts(SPACE_INVADERS), n_processes=1, n_parts=2, training_seed=0
    ) as vector:
        vector.reset()
        vector.step_async(np.array([0, 0]), 1)
        with pytest.raises(RuntimeError, match="call step_wait first"):
            vector.step_async(np.array([0, 0]), 1)
        with pytest.raises(RuntimeError, match="call step_async first"):
            vector.step_wait(0)
        with pytest.raises(RuntimeError, match="call step_wait first"):
            vector.snapshot()
        assert vector.step(np.array([0, 0])).steps.tolist() == [1, 1]
        assert vector.step_wait(1).steps.tolist() == [1, 1]
        assert len(vector.snapshot().games) == 4


def test_a_snapshot_of_another_number_of_games_is_refused() -> None:
    with VectorGame(
        SPACE_INVADERS, 2, TrainingStarts(SPACE_INVADERS), n_processes=1, training_seed=0
    ) as vector:
        vector.reset()
        snapshot = vector.snapshot()
        with pytest.raises(ValueError, match="snapshot of 2 games, got 1"):
            vector.restore(VectorSnapshot(snapshot.games[:1]))


def test_invalid_calls_are_refused_without_effect() -> None:
    with pytest.raises(ValueError, match="at least one game"):
        VectorGame(SPACE_INVADERS, 0, TrainingStarts(SPACE_INVADERS), training_seed=0)
    with pytest.raises(ValueError, match="2 starts, one per game, got 1"):
        VectorGame(SPACE_INVADERS, 2, FixedStarts((AtariStart(0),)), training_seed=0)
    with VectorGame(
        SPACE_INVADERS, 2, TrainingStarts(SPACE_INVADERS), n_processes=1, training_seed=0
    ) as vector:
        vector.reset()
        with pytest.raises(ValueError, match="shape"):
            vector.step(np.array([0]))
        with pytest.raises(ValueError, match="from 0 to 5"):
            vector.step(np.array([0, 6]))
        with pytest.raises(RuntimeError, match="call step_async first"):
            vector.step_wait()
        vector.step_async(np.array([0, 0]))
        with pytest.raises(RuntimeError, match="call step_wait first"):
            vector.snapshot()
        assert vector.step_wait().steps.tolist() == [1, 1]


def children() -> set[int]:
    return set(
        map(
            int, Path(f"/proc/self/task/{os.getpid()}/children").read_text(encoding="utf-8").split()
        )
    )


def test_closing_leaves_no_process_behind_and_may_be_done_twice() -> None:
    before = children()
    vector = VectorGame(
        SPACE_INVADERS, 3, TrainingStarts(SPACE_INVADERS), n_processes=3, training_seed=0
    )
    assert len(children() - before) == 3
    vector.close()
    vector.close()
    assert children() == before
    with pytest.raises(GameProcessFailed, match="closed"):
        vector.reset()


def test_a_forgotten_vector_closes_itself() -> None:
    before = children()
    vector = VectorGame(
        SPACE_INVADERS, 2, TrainingStarts(SPACE_INVADERS), n_processes=2, training_seed=0
    )
    assert children() != before
    del vector
    assert children() == before


def test_a_killed_process_is_reported() -> None:
    before = children()
    with VectorGame(
        SPACE_INVADERS, 2, TrainingStarts(SPACE_INVADERS), n_processes=2, training_seed=0
    ) as vector:
        vector.reset()
        process = max(children() - before)
        os.kill(process, signal.SIGKILL)
        with pytest.raises(GameProcessFailed, match="exit code -9"):
            vector.step(np.array([0, 0]))


def test_an_error_in_a_process_is_raised_with_its_trace() -> None:
    with VectorGame(
        SPACE_INVADERS, 2, TrainingStarts(SPACE_INVADERS), n_processes=2, training_seed=0
    ) as vector:
        vector.reset()
        first, second = vector.snapshot().games
        with pytest.raises(GameProcessFailed, match=r"Traceback[\s\S]*version 1, got 9"):
            vector.restore(VectorSnapshot((first, b"\x09" + second[1:])))


def test_a_demonstration_that_goes_on_after_its_end_is_refused() -> None:
    hit_at_443 = DemonstrationLog(SPACE_INVADERS, AtariStart(0), bytes(500))
    source = TrainingStarts(SPACE_INVADERS, demonstrations=(hit_at_443,), demonstration_share=1.0)
    with (
        VectorGame(SPACE_INVADERS, 1, source, n_processes=1, training_seed=0) as vector,
        pytest.raises(EpisodeEnded, match="ended at frame 443"),
    ):
        vector.reset()


PARENT = """
    import os, signal, sys, time
    import numpy as np
    from pathlib import Path
    from tril.games.space_invaders import SPACE_INVADERS
    from tril.play.vector.reset_distribution import TrainingStarts
    from tril.play.vector.vector_game import VectorGame

    # Ignored where the tests run in the background of a script.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    starts = TrainingStarts(SPACE_INVADERS)
    vector = VectorGame(SPACE_INVADERS, 2, starts, n_processes=2, training_seed=0)
    vector.reset()
    print(Path(f"/proc/self/task/{os.getpid()}/children").read_text(), flush=True)
    while True:
        vector.step(np.array([0, 0]))
"""


def kill_group(process: subprocess.Popen[str]) -> None:
    """Ctrl-C in a terminal: the parent and its processes get it alike."""
    os.killpg(process.pid, signal.SIGINT)


@pytest.mark.parametrize(
    ("end", "code"), [(subprocess.Popen.kill, -signal.SIGKILL), (kill_group, -signal.SIGINT)]
)
def test_the_processes_end_with_their_parent(
    end: Callable[[subprocess.Popen[str]], None], code: int
) -> None:
    with subprocess.Popen(
        [sys.executable, "-c", textwrap.dedent(PARENT)],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    ) as parent:
        assert parent.stdout is not None
        workers = [os.pidfd_open(int(pid)) for pid in parent.stdout.readline().split()]
        assert len(workers) == 2
        end(parent)
        try:
            for worker in workers:
                ended, _, _ = select.select([worker], [], [], 20)
                assert ended, "a process outlived its parent"
                os.close(worker)
        except BaseException:
            parent.kill()
            raise
        _, errors = parent.communicate()
    assert parent.returncode == code
    # Only the parent's own KeyboardInterrupt: no trace of a process of its.
    assert errors.count("Traceback") == (code == -signal.SIGINT)
