"""Many games in processes over shared memory."""

import itertools
import mmap
import os
import tempfile
import weakref
from collections.abc import Sequence
from dataclasses import dataclass
from types import TracebackType
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from tril.cores import core_count
from tril.game import space_invaders as game
from tril.game.episode import Ending, EndReason
from tril.game.observation import Observation
from tril.game.vector.game_group import (
    Answer,
    Assignment,
    Command,
    FinishedGame,
    GameGroup,
    SharedArrays,
)
from tril.game.vector.game_process import GameProcess, GameProcessFailed
from tril.game.vector.reset_distribution import (
    DemonstrationLog,
    DemonstrationStep,
    FixedStarts,
    StartSource,
    TrainingStarts,
)

__all__ = [
    "DemonstrationLog",
    "DemonstrationStep",
    "FinishedGame",
    "FixedStarts",
    "GameProcessFailed",
    "StartSource",
    "TrainingStarts",
    "VectorGame",
    "VectorSnapshot",
    "VectorStep",
]


@dataclass(frozen=True)
class VectorStep:
    """What one step of all games gave.

    Attributes:
        observations: uint8 (n, 4, 84, 84): where a game ended, of the next one already. A view
            that stays as it is during the next step and is overwritten by the one after that.
        ended: bool (n,): the games whose episode this step ended.
        terminal_observations: uint8 (n, 4, 84, 84): the last observation of the episode where
            ended, anything elsewhere. A view that the next step overwrites.
        reasons: why the episode ended, by game; None where it goes on.
        steps: int32 (n,): steps of the episode that was stepped, since its start.
        finished: the episodes that ended, in order of their games.
    """

    observations: Observation
    ended: npt.NDArray[np.bool_]
    terminal_observations: Observation
    reasons: tuple[EndReason | None, ...]
    steps: npt.NDArray[np.int32]
    finished: tuple[FinishedGame, ...]


@dataclass(frozen=True)
class VectorSnapshot:
    """All that the future of a vector depends on, actions apart.

    Attributes:
        games: one saved game with its generators each.
    """

    games: tuple[bytes, ...]

    def to_arrays(self) -> dict[str, npt.NDArray[Any]]:
        """Return the snapshot as plain arrays, for a file without pickle."""
        sizes = np.array([len(one) for one in self.games], np.int64)
        return {"sizes": sizes, "games": np.frombuffer(b"".join(self.games), np.uint8)}

    @classmethod
    def from_arrays(cls, arrays: dict[str, npt.NDArray[Any]]) -> Self:
        """Read what `to_arrays` returned."""
        data = arrays["games"].tobytes()
        ends = np.cumsum(arrays["sizes"]).tolist()
        return cls(tuple(data[a:b] for a, b in zip([0, *ends[:-1]], ends, strict=True)))


class VectorGame:
    """Many AgentGames, stepped together by processes that share the observations with this one.

    A game's episodes depend on the training seed, its index and its actions only, so that the
    number of processes changes the speed and nothing else. The processes are plain subprocesses:
    they import neither the caller's main module nor its libraries, and end with the caller.

    Attributes:
        n_games: how many games are played side by side.
    """

    def __init__(
        self,
        n_games: int,
        starts: StartSource,
        *,
        n_processes: int | None = None,
        ending: Ending = Ending.HIT,
        max_frames: int = game.MAX_FRAMES,
        sticky_action_probability: float = 0.0,
        training_seed: int,
    ) -> None:
        """Start the processes and wait until they are ready, about a second.

        Args:
            n_games: how many games are played side by side.
            starts: where they begin.
            n_processes: by default one for each core, and at most one for each game. With one,
                the caller plays all games itself.
            ending: which rule for the player's death ends an episode.
            max_frames: after how many frames an episode ends in any case.
            sticky_action_probability: of repeating the action of the frame before.
            training_seed: of the draws of starts and of repeated actions.

        Raises:
            ValueError: the numbers contradict each other.
            GameProcessFailed: a process could not be made ready.
        """
        if n_games < 1:
            raise ValueError(f"Expected at least one game, got {n_games}.")
        if isinstance(starts, FixedStarts) and len(starts.starts) != n_games:
            raise ValueError(f"Expected {n_games} starts, one per game, got {len(starts.starts)}.")
        if n_processes is None:
            n_processes = core_count()
        self.n_games = n_games
        self._pending = False
        memory_fd = _memory_file(SharedArrays.size(n_games))
        self._shared = SharedArrays(mmap.mmap(memory_fd, 0), n_games)
        processes: list[GameProcess] = []
        self._finalizer = weakref.finalize(self, _close_all, processes)
        assignments = [
            Assignment(
                n_games=n_games,
                games=games,
                starts=starts,
                ending=ending,
                max_frames=max_frames,
                sticky_action_probability=sticky_action_probability,
                training_seed=training_seed,
            )
            for games in _split(n_games, min(n_processes, n_games))
        ]
        self._groups: Sequence[GameProcess | _OwnGames] = processes
        try:
            if len(assignments) == 1:
                self._groups = [_OwnGames(assignments[0], self._shared)]
            else:
                processes.extend(GameProcess(one, memory_fd) for one in assignments)
                _spread(processes)
            for process in processes:
                process.receive()
        except BaseException:
            self.close()
            raise
        finally:
            os.close(memory_fd)

    def reset(self) -> Observation:
        """Begin all games and return their observations, uint8 (n, 4, 84, 84); once only."""
        self._call_all(Command.RESET)
        return self._observations

    def step(self, actions: npt.NDArray[np.integer[Any]]) -> VectorStep:
        """Play one step of every game; actions is (n,) with values 0 to 5."""
        self.step_async(actions)
        return self.step_wait()

    def step_async(self, actions: npt.NDArray[np.integer[Any]]) -> None:
        """Begin a step; step_wait returns what it gave."""
        actions = np.asarray(actions)
        if actions.shape != (self.n_games,):
            raise ValueError(f"Expected actions of shape ({self.n_games},), got {actions.shape}.")
        if actions.min() < 0 or actions.max() >= game.ACTION_COUNT:
            raise ValueError(f"Expected actions from 0 to {game.ACTION_COUNT - 1}, got {actions}.")
        self._shared.actions[:] = actions
        self._shared.half[0] ^= 1
        self._send_all(Command.STEP)

    def step_wait(self) -> VectorStep:
        """Wait for the step that step_async began and return what it gave."""
        reasons: list[EndReason | None] = [None] * self.n_games
        finished: list[FinishedGame] = []
        for news in self._receive_all():
            finished.extend(news or ())
        for one in finished:
            reasons[one.game] = one.end
        return VectorStep(
            observations=self._observations,
            ended=self._shared.ended.copy(),
            terminal_observations=self._shared.terminal_observations,
            reasons=tuple(reasons),
            steps=self._shared.steps.copy(),
            finished=tuple(finished),
        )

    @property
    def resting(self) -> npt.NDArray[np.bool_]:
        """The games that have been played and are stepped no more, bool (n,)."""
        return np.array(self._shared.resting)

    @property
    def _observations(self) -> Observation:
        return np.asarray(self._shared.observations[self._shared.half[0]], np.uint8)

    def snapshot(self) -> VectorSnapshot:
        """Return all that the future of the games depends on, actions apart."""
        parts = self._call_all(Command.SNAPSHOT)
        return VectorSnapshot(tuple(one for part in parts for one in part))

    def restore(self, snapshot: VectorSnapshot) -> Observation:
        """Go on from a snapshot of a vector with as many games and the same settings.

        Returns:
            The observations, uint8 (n, 4, 84, 84), as they were.
        """
        if len(snapshot.games) != self.n_games:
            raise ValueError(
                f"Expected a snapshot of {self.n_games} games, got {len(snapshot.games)}."
            )
        parts = [[snapshot.games[index] for index in group.games] for group in self._groups]
        self._call_all(Command.RESTORE, parts)
        return self._observations

    def close(self) -> None:
        """End the processes; closing twice is fine."""
        self._finalizer()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def _call_all(
        self, command: Command, snapshots: Sequence[Sequence[bytes]] | None = None
    ) -> list[Any]:
        self._send_all(command, snapshots)
        return self._receive_all()

    def _send_all(
        self, command: Command, snapshots: Sequence[Sequence[bytes]] | None = None
    ) -> None:
        if not self._finalizer.alive:
            raise GameProcessFailed("The games have been closed.")
        if self._pending:
            raise RuntimeError("A step is under way: call step_wait first.")
        self._pending = True
        for index, group in enumerate(self._groups):
            group.send(command, None if snapshots is None else snapshots[index])

    def _receive_all(self) -> list[Any]:
        if not self._pending:
            raise RuntimeError("No step is under way: call step_async first.")
        answers = [group.receive() for group in self._groups]
        self._pending = False
        return answers


class _OwnGames:
    """The one group of games of a vector without processes: the caller plays them."""

    def __init__(self, assignment: Assignment, shared: SharedArrays) -> None:
        self.games = assignment.games
        self._group = GameGroup(assignment, shared)
        self._command: tuple[Command, Sequence[bytes] | None] | None = None

    def send(self, command: Command, snapshots: Sequence[bytes] | None = None) -> None:
        self._command = command, snapshots

    def receive(self) -> Answer:
        command, self._command = self._command, None
        return None if command is None else self._group.answer(*command)


def _close_all(processes: list[GameProcess]) -> None:
    for process in processes:
        process.close()
    for process in processes:
        process.wait()


def _spread(processes: Sequence[GameProcess]) -> None:
    """Give each process a core of its own, where there are as many processes as cores.

    All of them wait for the slowest in every step. Left alone, the scheduler often wakes two on
    one core, next to the caller that has called them, which costs 7% of the speed and more.
    """
    if not hasattr(os, "sched_setaffinity"):  # Not Linux.
        return
    cores = sorted(os.sched_getaffinity(0))
    if len(cores) == len(processes):
        for process, core in zip(processes, cores, strict=True):
            process.run_on(core)


def _split(count: int, parts: int) -> list[range]:
    """Return ranges as equal as possible that make up range(count)."""
    edges = [count * part // parts for part in range(parts + 1)]
    return [range(begin, end) for begin, end in itertools.pairwise(edges)]


def _memory_file(size: int) -> int:
    """Return a file descriptor of memory without a name, so that nothing can be left behind."""
    if hasattr(os, "memfd_create"):
        fd = os.memfd_create("tril-games")
    else:  # Not Linux.
        with tempfile.TemporaryFile() as file:
            fd = os.dup(file.fileno())
    os.truncate(fd, size)
    return fd
