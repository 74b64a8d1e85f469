"""Many games in processes over shared memory."""

import itertools
import mmap
import os
import pickle
import socket
import subprocess
import sys
import tempfile
import weakref
from collections.abc import Sequence
from dataclasses import dataclass
from multiprocessing.connection import Connection
from types import TracebackType
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from tril.game import space_invaders as game
from tril.game.episode import Ending, EndReason
from tril.game.observation import Observation
from tril.game.start_sources import (
    DemonstrationLog,
    DemonstrationStep,
    FixedStarts,
    StartSource,
    TrainingStarts,
)
from tril.game.vector_worker import (
    COMMAND_RESET,
    COMMAND_RESTORE,
    COMMAND_SNAPSHOT,
    COMMAND_STEP,
    REPLY_ERROR,
    REPLY_VALUE,
    Assignment,
    FinishedGame,
    SharedArrays,
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

CLOSE_TIMEOUT_S = 5.0

# Not -m: run as a main module, its classes would be others than the ones pickled here.
_WORKER_PROGRAM = "import sys; from tril.game.vector_worker import main; sys.exit(main(sys.argv))"


class GameProcessFailed(RuntimeError):
    """A process that plays games ended or failed; the message says how."""


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
            n_processes: default is one for each core, at most one for each game.
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
            n_processes = os.cpu_count() or 1
        self.n_games = n_games
        self._half = 0
        self._pending = False
        memory_fd = _memory_file(SharedArrays.size(n_games))
        self._shared = SharedArrays(mmap.mmap(memory_fd, 0), n_games)
        self._workers: list[_Worker] = []
        self._finalizer = weakref.finalize(self, _close_all, self._workers)
        try:
            for games in _split(n_games, min(n_processes, n_games)):
                assignment = Assignment(
                    n_games=n_games,
                    games=games,
                    starts=starts,
                    ending=ending,
                    max_frames=max_frames,
                    sticky_action_probability=sticky_action_probability,
                    training_seed=training_seed,
                    parent=os.getpid(),
                )
                self._workers.append(_Worker(assignment, memory_fd))
            for worker in self._workers:
                worker.receive()
        except BaseException:
            self.close()
            raise
        finally:
            os.close(memory_fd)

    def reset(self) -> Observation:
        """Begin all games and return their observations, uint8 (n, 4, 84, 84); once only."""
        self._call_all([COMMAND_RESET + bytes([self._half])] * len(self._workers))
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
        self._half = 1 - self._half
        self._send_all([COMMAND_STEP + bytes([self._half])] * len(self._workers))

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
        return np.asarray(self._shared.observations[self._half], np.uint8)

    def snapshot(self) -> VectorSnapshot:
        """Return all that the future of the games depends on, actions apart."""
        parts = self._call_all([COMMAND_SNAPSHOT] * len(self._workers))
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
        half = bytes([self._half])
        self._call_all(
            [
                COMMAND_RESTORE + half + pickle.dumps([snapshot.games[i] for i in worker.games])
                for worker in self._workers
            ]
        )
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

    def _call_all(self, messages: Sequence[bytes]) -> list[Any]:
        self._send_all(messages)
        return self._receive_all()

    def _send_all(self, messages: Sequence[bytes]) -> None:
        if not self._finalizer.alive:
            raise GameProcessFailed("The games have been closed.")
        if self._pending:
            raise RuntimeError("A step is under way: call step_wait first.")
        self._pending = True
        for worker, message in zip(self._workers, messages, strict=True):
            worker.send(message)

    def _receive_all(self) -> list[Any]:
        if not self._pending:
            raise RuntimeError("No step is under way: call step_async first.")
        values = [worker.receive() for worker in self._workers]
        self._pending = False
        return values


class _Worker:
    """The parent's side of one process."""

    def __init__(self, assignment: Assignment, memory_fd: int) -> None:
        self.games = assignment.games
        ours, theirs = socket.socketpair()
        # One thread each: the parallelism is in the processes.
        environment = os.environ | {
            "PYTHONPATH": os.pathsep.join(os.path.abspath(path) for path in sys.path),
            "OMP_NUM_THREADS": "1",
            "OPENBLAS_NUM_THREADS": "1",
        }
        with theirs:
            fds = (theirs.fileno(), memory_fd)
            self._process = subprocess.Popen(
                [sys.executable, "-c", _WORKER_PROGRAM, *map(str, fds)],
                pass_fds=fds,
                env=environment,
                stdin=subprocess.DEVNULL,
            )
        self._connection: Connection = Connection(ours.detach())
        self.send(pickle.dumps(assignment))

    def send(self, message: bytes) -> None:
        try:
            self._connection.send_bytes(message)
        except (BrokenPipeError, ConnectionResetError):
            raise self._failure() from None

    def receive(self) -> Any:
        """Return the value of the reply, None when it has none."""
        try:
            reply = self._connection.recv_bytes()
        except (EOFError, ConnectionResetError):
            raise self._failure() from None
        if reply[:1] == REPLY_ERROR:
            raise GameProcessFailed(f"A process that plays games failed:\n{reply[1:].decode()}")
        return pickle.loads(reply[1:]) if reply[:1] == REPLY_VALUE else None

    def _failure(self) -> GameProcessFailed:
        code = self._process.wait(CLOSE_TIMEOUT_S)
        return GameProcessFailed(
            f"A process that plays games {list(self.games)} ended with exit code {code}. It may"
            " have been killed for want of memory; go on from the last checkpoint."
        )

    def close(self) -> None:
        self._connection.close()

    def wait(self) -> None:
        try:
            self._process.wait(CLOSE_TIMEOUT_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()


def _close_all(workers: list[_Worker]) -> None:
    for worker in workers:
        worker.close()
    for worker in workers:
        worker.wait()


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
