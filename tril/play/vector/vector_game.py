"""A vector of games played by processes over shared memory."""

from __future__ import annotations

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
from tril.games.base import Game
from tril.play.observation import Observation
from tril.play.vector.game_group import (
    Command,
    FinishedGame,
    GameGroup,
    GroupConfig,
    Reply,
    SharedArrays,
)
from tril.play.vector.game_process import GameProcess, GameProcessFailed
from tril.play.vector.reset_distribution import (
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
    """The result of one step of a part's games.

    Attributes:
        observations: uint8 (n, 4, 84, 84), of the next episode where one ended. A view that stays
            valid during the next step and is overwritten by the one after.
        ended: bool (n,): the games whose episode this step ended.
        terminal_observations: uint8 (n, 4, 84, 84): the episode's last observation where ended,
            undefined elsewhere. A view that the next step overwrites.
        ends: name of the end of each game's episode; None where it goes on.
        steps: int32 (n,): steps since the start of the episode just stepped.
        finished: the episodes that ended, in order of their games, whose indices count in the whole
            vector.
    """

    observations: Observation
    ended: npt.NDArray[np.bool_]
    terminal_observations: Observation
    ends: tuple[str | None, ...]
    steps: npt.NDArray[np.int32]
    finished: tuple[FinishedGame, ...]


@dataclass(frozen=True)
class VectorSnapshot:
    """The state of a vector: each game with its generators, as bytes."""

    games: tuple[bytes, ...]

    def to_arrays(self) -> dict[str, npt.NDArray[Any]]:
        """Return the snapshot as plain arrays, for a file without pickle."""
        sizes = np.array([len(game) for game in self.games], np.int64)
        return {"sizes": sizes, "games": np.frombuffer(b"".join(self.games), np.uint8)}

    @classmethod
    def from_arrays(cls, arrays: dict[str, npt.NDArray[Any]]) -> Self:
        """Read what `to_arrays` returned."""
        data = arrays["games"].tobytes()
        ends = np.cumsum(arrays["sizes"]).tolist()
        return cls(tuple(data[a:b] for a, b in zip([0, *ends[:-1]], ends, strict=True)))


class VectorGame:
    """AgentGames stepped together by processes that share observations with this one.

    A game's episodes depend only on the training seed, its index and its actions, so the numbers of
    processes and parts affect nothing but speed. The processes are plain subprocesses that end with
    the caller.

    A vector may have parts, each of which steps by itself: while the games of one part are played,
    the caller chooses actions for another.

    Attributes:
        game: the game.
        n_games: number of games.
        parts: the indices of each part's games.
    """

    def __init__(
        self,
        game: Game,
        n_games: int,
        reset_distribution: ResetDistribution,
        *,
        n_processes: int | None = None,
        n_parts: int = 1,
        end_rule: str | None = None,
        max_frames: int | None = None,
        sticky_action_probability: float = 0.0,
        training_seed: int,
    ) -> None:
        """Start the processes and wait until they are ready, about a second.

        Args:
            game: the game.
            n_games: number of games.
            reset_distribution: where episodes begin.
            n_processes: by default one per core; divided evenly among the parts, rounded down, at
                least one each and at most one per game. With one, the caller's process plays all
                games.
            n_parts: number of parts, at most one per game.
            end_rule: name of the rule by which a loss ends an episode; None for the default.
            max_frames: maximum length of an episode; None for the game's.
            sticky_action_probability: probability of repeating the previous frame's action.
            training_seed: seed of resets and repeated actions.

        Raises:
            ValueError: n_games is not positive or does not fit the reset distribution.
            GameProcessFailed: a process failed to start.
        """
        if n_games < 1:
            raise ValueError(f"Expected at least one game, got {n_games}.")
        reset_distribution.check(n_games)
        self.game = game
        self.n_games = n_games
        self.parts = _split(n_games, min(n_parts, n_games))
        self._pending = [False] * len(self.parts)
        memory_fd = _anonymous_memory(SharedArrays.size(n_games))
        self._shared = SharedArrays(mmap.mmap(memory_fd, 0), n_games)
        processes: list[GameProcess] = []
        self._finalizer = weakref.finalize(self, _close_all, processes)
        n_processes = n_processes or core_count()
        configs = [
            GroupConfig(
                game,
                n_games,
                range(part.start + games.start, part.start + games.stop),
                number,
                reset_distribution,
                game.check_end_rule(end_rule or game.end_rule),
                max_frames or game.clock.max_frames,
                sticky_action_probability,
                training_seed,
            )
            for number, part in enumerate(self.parts)
            for games in _split(len(part), min(max(1, n_processes // len(self.parts)), len(part)))
        ]
        self._groups: Sequence[GameProcess | _LocalGroup] = processes
        try:
            if n_processes == 1 or len(configs) == 1:
                self._groups = [_LocalGroup(config, self._shared) for config in configs]
            else:
                processes.extend(GameProcess(config, memory_fd) for config in configs)
                if len(self.parts) == 1:
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
        return self._observations()

    def step(self, actions: npt.NDArray[np.integer[Any]]) -> VectorStep:
        """Play one step of the first part's games; see step_async."""
        self.step_async(actions)
        return self.step_wait()

    def step_async(self, actions: npt.NDArray[np.integer[Any]], part: int = 0) -> None:
        """Begin a step of a part's n games; step_wait returns its result.

        Args:
            actions: (n,), indices of the game's actions.
            part: number of the part; a vector has one unless it was made with more.
        """
        games = self.parts[part]
        actions = np.asarray(actions)
        if actions.shape != (len(games),):
            raise ValueError(f"Expected actions of shape ({len(games)},), got {actions.shape}.")
        n_actions = self.game.controls.n_actions
        if actions.min() < 0 or actions.max() >= n_actions:
            raise ValueError(f"Expected actions from 0 to {n_actions - 1}, got {actions}.")
        self._check_free(part)
        self._pending[part] = True
        self._shared.actions[games.start : games.stop] = actions
        self._shared.half[part] ^= 1
        for group in self._groups_of(part):
            group.send(Command.STEP)

    def step_wait(self, part: int = 0) -> VectorStep:
        """Return the result of the step that step_async began."""
        games = self.parts[part]
        part_games = slice(games.start, games.stop)
        finished: list[FinishedGame] = []
        for reply in self._receive(part):
            finished.extend(reply or ())
        ends: list[str | None] = [None] * len(games)
        for game in finished:
            ends[game.game - games.start] = game.end
        return VectorStep(
            observations=self._observations_of(part),
            ended=self._shared.ended[part_games].copy(),
            terminal_observations=self._shared.terminal_observations[part_games],
            ends=tuple(ends),
            steps=self._shared.steps[part_games].copy(),
            finished=tuple(finished),
        )

    @property
    def inactive(self) -> npt.NDArray[np.bool_]:
        """The games that have no further episode, bool (n,)."""
        return np.array(self._shared.inactive)

    def _observations_of(self, part: int) -> Observation:
        games = self.parts[part]
        observations = self._shared.observations[self._shared.half[part], games.start : games.stop]
        return np.asarray(observations, np.uint8)

    def _observations(self) -> Observation:
        if len(self.parts) == 1:
            return self._observations_of(0)
        return np.concatenate([self._observations_of(part) for part in range(len(self.parts))])

    def snapshot(self) -> VectorSnapshot:
        """Return the state of the games and their generators."""
        groups = self._call_all(Command.SNAPSHOT)
        return VectorSnapshot(tuple(snapshot for group in groups for snapshot in group))

    def restore(self, snapshot: VectorSnapshot) -> Observation:
        """Restore a snapshot of a vector with as many games and the same settings.

        Returns:
            The observations at the snapshot, uint8 (n, 4, 84, 84).
        """
        if len(snapshot.games) != self.n_games:
            raise ValueError(
                f"Expected a snapshot of {self.n_games} games, got {len(snapshot.games)}."
            )
        groups = [[snapshot.games[index] for index in group.games] for group in self._groups]
        self._call_all(Command.RESTORE, groups)
        return self._observations()

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
        for part in range(len(self.parts)):
            self._check_free(part)
        self._pending = [True] * len(self.parts)
        for index, group in enumerate(self._groups):
            group.send(command, None if snapshots is None else snapshots[index])
        return [reply for part in range(len(self.parts)) for reply in self._receive(part)]

    def _groups_of(self, part: int) -> list[GameProcess | _LocalGroup]:
        return [group for group in self._groups if group.games.start in self.parts[part]]

    def _check_free(self, part: int) -> None:
        if not self._finalizer.alive:
            raise GameProcessFailed("The games have been closed.")
        if self._pending[part]:
            raise RuntimeError("A step is under way: call step_wait first.")

    def _receive(self, part: int) -> list[Any]:
        if not self._pending[part]:
            raise RuntimeError("No step is under way: call step_async first.")
        answers = [group.receive() for group in self._groups_of(part)]
        self._pending[part] = False
        return answers


class _LocalGroup:
    """A group of games that the caller's own process plays."""

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

    Where all games are one part, every step waits for the slowest process. Without pinning, the
    scheduler often wakes two on the caller's core, which costs 7% of the speed and more.
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
