"""A vector of games played by processes over shared memory."""

import itertools
import mmap
import os
import tempfile
import weakref
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from tril.cores import core_count
from tril.game import space_invaders as game
from tril.game.episode import Ending, EndReason
from tril.game.observation import Observation
from tril.game.vector.game_group import (
    Command,
    FinishedGame,
    GameGroup,
    GroupConfig,
    Reply,
    SharedArrays,
)
from tril.game.vector.game_process import GameProcess, GameProcessFailed
from tril.game.vector.reset_distribution import (
    DemonstrationLog,
    DemonstrationStep,
    FixedStarts,
    ResetDistribution,
    TrainingStarts,
)

__all__ = [
    "DemonstrationLog",
    "DemonstrationStep",
    "FinishedGame",
    "FixedStarts",
    "GameProcessFailed",
    "ResetDistribution",
    "TrainingStarts",
    "VectorGame",
    "VectorSnapshot",
    "VectorStep",
]


@dataclass(frozen=True)
class VectorStep:
    """The result of one step of all games.

    Attributes:
        observations: uint8 (n, 4, 84, 84), of the next episode where one ended. A view that stays
            valid during the next step and is overwritten by the one after.
        ended: bool (n,): the games whose episode this step ended.
        terminal_observations: uint8 (n, 4, 84, 84): the episode's last observation where ended,
            undefined elsewhere. A view that the next step overwrites.
        reasons: why the episode ended, by game; None where it goes on.
        steps: int32 (n,): steps since the start of the episode just stepped.
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
    """The state of a vector: each game with its generators, as bytes."""

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
    """AgentGames stepped together by processes that share observations with this one.

    A game's episodes depend only on the training seed, its index and its actions, so the number of
    processes affects nothing but speed. The processes are plain subprocesses that end with the
    caller.

    Attributes:
        n_games: number of games.
    """

    def __init__(
        self,
        n_games: int,
        reset_distribution: ResetDistribution,
        *,
        n_processes: int | None = None,
        ending: Ending = Ending.HIT,
        max_frames: int = game.MAX_FRAMES,
        sticky_action_probability: float = 0.0,
        training_seed: int,
    ) -> None:
        """Start the processes and wait until they are ready, about a second.

        Args:
            n_games: number of games.
            reset_distribution: where episodes begin.
            n_processes: by default one per core, at most one per game. With one, the caller's
                process plays all games.
            ending: which rule for the player's death ends an episode.
            max_frames: maximum length of an episode.
            sticky_action_probability: probability of repeating the previous frame's action.
            training_seed: seed of resets and repeated actions.

        Raises:
            ValueError: n_games is not positive or does not fit the reset distribution.
            GameProcessFailed: a process failed to start.
        """
        if n_games < 1:
            raise ValueError(f"Expected at least one game, got {n_games}.")
        reset_distribution.check(n_games)
        self.n_games = n_games
        self._pending = False
        memory_fd = _anonymous_memory(SharedArrays.size(n_games))
        self._shared = SharedArrays(mmap.mmap(memory_fd, 0), n_games)
        processes: list[GameProcess] = []
        self._finalizer = weakref.finalize(self, _close_all, processes)
        configs = [
            GroupConfig(
                n_games,
                games,
                reset_distribution,
                ending,
                max_frames,
                sticky_action_probability,
                training_seed,
            )
            for games in _split(n_games, min(n_processes or core_count(), n_games))
        ]
        self._groups: Sequence[GameProcess | _LocalGroup] = processes
        try:
            if len(configs) == 1:
                self._groups = [_LocalGroup(configs[0], self._shared)]
            else:
                processes.extend(GameProcess(one, memory_fd) for one in configs)
                _pin_to_cores(processes)
            for process in processes:
                process.receive()
        except BaseException:
            self.close()
            raise
        finally:
            os.close(memory_fd)

    def reset(self) -> Observation:
        """Begin all games and return their observations, uint8 (n, 4, 84, 84). Call it once."""
        self._call_all(Command.RESET)
        return self._observations

    def step(self, actions: npt.NDArray[np.integer[Any]]) -> VectorStep:
        """Play one step of every game; actions is (n,) with values 0 to 5."""
        self.step_async(actions)
        return self.step_wait()

    def step_async(self, actions: npt.NDArray[np.integer[Any]]) -> None:
        """Begin a step; step_wait returns its result."""
        actions = np.asarray(actions)
        if actions.shape != (self.n_games,):
            raise ValueError(f"Expected actions of shape ({self.n_games},), got {actions.shape}.")
        if actions.min() < 0 or actions.max() >= game.ACTION_COUNT:
            raise ValueError(f"Expected actions from 0 to {game.ACTION_COUNT - 1}, got {actions}.")
        self._shared.actions[:] = actions
        self._shared.half[0] ^= 1
        self._send_all(Command.STEP)

    def step_wait(self) -> VectorStep:
        """Return the result of the step that step_async began."""
        reasons: list[EndReason | None] = [None] * self.n_games
        finished: list[FinishedGame] = []
        for reply in self._receive_all():
            finished.extend(reply or ())
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
    def inactive(self) -> npt.NDArray[np.bool_]:
        """The games that have no further episode, bool (n,)."""
        return np.array(self._shared.inactive)

    @property
    def _observations(self) -> Observation:
        return np.asarray(self._shared.observations[self._shared.half[0]], np.uint8)

    def snapshot(self) -> VectorSnapshot:
        """Return the state of the games and their generators."""
        parts = self._call_all(Command.SNAPSHOT)
        return VectorSnapshot(tuple(one for part in parts for one in part))

    def restore(self, snapshot: VectorSnapshot) -> Observation:
        """Restore a snapshot of a vector with as many games and the same settings.

        Returns:
            The observations at the snapshot, uint8 (n, 4, 84, 84).
        """
        if len(snapshot.games) != self.n_games:
            raise ValueError(
                f"Expected a snapshot of {self.n_games} games, got {len(snapshot.games)}."
            )
        parts = [[snapshot.games[index] for index in group.games] for group in self._groups]
        self._call_all(Command.RESTORE, parts)
        return self._observations

    def close(self) -> None:
        """End the processes. May be called more than once."""
        self._finalizer()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
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


class _LocalGroup:
    """The single group of a vector without processes."""

    def __init__(self, config: GroupConfig, shared: SharedArrays) -> None:
        self.games = config.games
        self._group = GameGroup(config, shared)
        self._command: tuple[Command, Sequence[bytes] | None] | None = None

    def send(self, command: Command, snapshots: Sequence[bytes] | None = None) -> None:
        self._command = command, snapshots

    def receive(self) -> Reply:
        command, self._command = self._command, None
        return None if command is None else self._group.execute(*command)


def _close_all(processes: list[GameProcess]) -> None:
    for process in processes:
        process.close()
    for process in processes:
        process.wait()


def _pin_to_cores(processes: Sequence[GameProcess]) -> None:
    """Pin each process to its own core if there are as many processes as cores.

    Every step waits for the slowest process. Without pinning, the scheduler often wakes two on the
    caller's core, which costs 7% of the speed and more.
    """
    if not hasattr(os, "sched_setaffinity"):  # Not Linux.
        return
    cores = sorted(os.sched_getaffinity(0))
    if len(cores) == len(processes):
        for process, core in zip(processes, cores, strict=True):
            process.pin_to_core(core)


def _split(count: int, parts: int) -> list[range]:
    """Split range(count) into ranges as equal as possible."""
    edges = [count * part // parts for part in range(parts + 1)]
    return [range(begin, end) for begin, end in itertools.pairwise(edges)]


def _anonymous_memory(size: int) -> int:
    """Return a file descriptor of anonymous shared memory."""
    if hasattr(os, "memfd_create"):
        fd = os.memfd_create("tril-games")
    else:  # Not Linux.
        with tempfile.TemporaryFile() as file:
            fd = os.dup(file.fileno())
    os.truncate(fd, size)
    return fd
