"""The games of a vector: episode after episode, in groups that one process plays."""

import json
import mmap
import struct
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Any

import numpy as np

from tril.game import space_invaders as game
from tril.game.agent import AgentGame, StickyActions
from tril.game.console import Console, KnownStarts
from tril.game.episode import Ending, EndReason, Hit, Start
from tril.game.observation import OBSERVATION_SHAPE, AgentView, AgentViews
from tril.game.saved_game import pack_game, unpack_game
from tril.game.vector.reset_distribution import DemonstrationLog, DemonstrationStep, StartSource

_SNAPSHOT_HEADER = struct.Struct("<BI")
_SNAPSHOT_VERSION = 1


class Command(Enum):
    """What a group of games is told to do."""

    RESET = b"R"
    STEP = b"S"
    SNAPSHOT = b"G"
    RESTORE = b"P"


@dataclass(frozen=True)
class FinishedGame:
    """An episode that a vector has played to its end.

    Attributes:
        game: index of the game in the vector.
        start: how it began.
        actions: the action executed at every frame from the start on, one byte each; those of a
            demonstration included, if it began in one.
        first_step: the step from which on the vector's actions were played; 0 unless the game
            began in a demonstration.
        hits: the aliens shot, in order of time, since the start.
        end: why it ended.
        shots: missiles that left the cannon since the start.
    """

    game: int
    start: Start
    actions: bytes
    first_step: int
    hits: tuple[Hit, ...]
    end: EndReason
    shots: int

    @property
    def own_hits(self) -> tuple[Hit, ...]:
        """The aliens shot by the vector's own actions."""
        first_frame = self.first_step * game.FRAMES_PER_STEP
        return tuple(hit for hit in self.hits if hit.frame > first_frame)


@dataclass(frozen=True)
class Assignment:
    """Which games of a vector are a group, and how they are played.

    Attributes:
        n_games: games in the whole vector.
        games: indices of those in the group.
        starts: where they begin.
        ending: which rule for the player's death ends an episode.
        max_frames: after how many frames an episode ends in any case.
        sticky_action_probability: see StickyActions.
        training_seed: each game draws from generators of its own, made of this and its index or
            start.
    """

    n_games: int
    games: range
    starts: StartSource
    ending: Ending
    max_frames: int
    sticky_action_probability: float
    training_seed: int


Answer = list[FinishedGame] | list[bytes] | None


class SharedArrays:
    """The arrays that a vector shares with its processes, in one block of memory.

    Attributes:
        observations: uint8 (2, n, 4, 84, 84); the two halves take turns.
        half: uint8 (1,): the half that the command under way fills.
        terminal_observations: uint8 (n, 4, 84, 84), valid where ended.
        actions: uint8 (n,).
        ended: bool (n,): whether the last step ended an episode.
        resting: bool (n,): whether the game has been played and is not stepped any more.
        steps: int32 (n,): steps of the episode that was stepped, since its start.
    """

    def __init__(self, memory: mmap.mmap, n_games: int) -> None:
        """Lay the arrays out in the memory."""
        self._memory = memory
        self._offset = 0
        observations = (n_games, *OBSERVATION_SHAPE)
        self.observations = self._array((2, *observations), np.uint8)
        self.terminal_observations = self._array(observations, np.uint8)
        self.steps = self._array((n_games,), np.int32)
        self.actions = self._array((n_games,), np.uint8)
        self.ended = self._array((n_games,), np.bool_)
        self.resting = self._array((n_games,), np.bool_)
        self.half = self._array((1,), np.uint8)

    def _array(self, shape: tuple[int, ...], dtype: type[np.generic]) -> Any:
        count = int(np.prod(shape))
        array = np.frombuffer(self._memory, dtype, count, self._offset).reshape(shape)
        # Rounded up, so that every array is aligned.
        self._offset += -(-array.nbytes // 64) * 64
        return array

    @staticmethod
    def size(n_games: int) -> int:
        """Return how many bytes the arrays take, rounded up."""
        return n_games * (3 * int(np.prod(OBSERVATION_SHAPE)) + 8) + 7 * 64


class DemonstrationStates:
    """The states before every step of the demonstrations, replayed when first asked for."""

    def __init__(self, logs: tuple[DemonstrationLog, ...], known_starts: KnownStarts) -> None:
        self._logs = logs
        self._known_starts = known_starts
        self._states: dict[int, list[bytes]] = {}

    def state(self, at: DemonstrationStep) -> bytes:
        """Return the packed game before this step."""
        if at.demonstration not in self._states:
            self._states[at.demonstration] = self._replay(self._logs[at.demonstration])
        return self._states[at.demonstration][at.step]

    def _replay(self, log: DemonstrationLog) -> list[bytes]:
        replay = AgentGame(Console(self._known_starts), max_frames=len(log.actions))
        replay.reset(log.start)
        states = []
        for frame, action in enumerate(log.actions):
            if frame % game.FRAMES_PER_STEP == 0:
                states.append(pack_game(replay.save()))
            replay.advance(action)
        return states


class GameSlot:
    """One game of a vector: episode after episode, with generators of its own."""

    def __init__(
        self,
        index: int,
        assignment: Assignment,
        shared: SharedArrays,
        demonstrations: DemonstrationStates,
        view: AgentView,
        console: Console,
    ) -> None:
        self._index = index
        self._starts = assignment.starts
        self._shared = shared
        self._demonstrations = demonstrations
        seed = assignment.training_seed
        self._start_rng = np.random.default_rng((seed, index, 0))
        self._sticky_rng = np.random.default_rng((seed, *self._starts.generator_key(index), 1))
        sticky_probability = assignment.sticky_action_probability
        self._game = AgentGame(
            console,
            assignment.ending,
            assignment.max_frames,
            StickyActions(sticky_probability, self._sticky_rng) if sticky_probability else None,
            view,
        )
        self._games_before = 0
        self._first_step = 0

    def begin(self) -> None:
        """Begin the next episode, or rest when there is none."""
        beginning = self._starts.beginning(self._start_rng, self._index, self._games_before)
        self._first_step = 0
        if beginning is None:
            self._shared.resting[self._index] = True
        elif isinstance(beginning, DemonstrationStep):
            self._first_step = beginning.step
            self._game.restore(unpack_game(self._demonstrations.state(beginning)))
        else:
            self._game.reset(beginning)

    def step(self) -> bool:
        """Play the step whose action is in the shared memory; tell whether it ended the game."""
        shared, index = self._shared, self._index
        if shared.resting[index]:
            shared.ended[index] = False
            return False
        self._game.step(int(shared.actions[index]))
        ended = self._game.end is not None
        shared.ended[index] = ended
        shared.steps[index] = self._game.steps
        return ended

    def finish(self) -> FinishedGame:
        """Hand over the episode that has ended and begin the next one."""
        self._game.observe(self._shared.terminal_observations[self._index])
        episode = self._game.episode
        if episode.end is None:
            raise RuntimeError(f"Game {self._index} has not ended.")
        finished = FinishedGame(
            game=self._index,
            start=episode.start,
            actions=episode.actions,
            first_step=self._first_step,
            hits=episode.hits,
            end=episode.end,
            shots=episode.shots,
        )
        self._games_before += 1
        self.begin()
        return finished

    def snapshot(self) -> bytes:
        """Return all that the game's future depends on, actions apart."""
        small = {
            "start_rng": self._start_rng.bit_generator.state,
            "sticky_rng": self._sticky_rng.bit_generator.state,
            "games_before": self._games_before,
            "first_step": self._first_step,
            "resting": bool(self._shared.resting[self._index]),
        }
        text = json.dumps(small).encode()
        header = _SNAPSHOT_HEADER.pack(_SNAPSHOT_VERSION, len(text))
        return header + text + pack_game(self._game.save())

    def restore(self, snapshot: bytes) -> None:
        """Go on from a snapshot."""
        version, size = _SNAPSHOT_HEADER.unpack_from(snapshot)
        if version != _SNAPSHOT_VERSION:
            raise ValueError(f"Expected snapshot version {_SNAPSHOT_VERSION}, got {version}.")
        end = _SNAPSHOT_HEADER.size + size
        small = json.loads(snapshot[_SNAPSHOT_HEADER.size : end])
        self._start_rng.bit_generator.state = small["start_rng"]
        self._sticky_rng.bit_generator.state = small["sticky_rng"]
        self._games_before = small["games_before"]
        self._first_step = small["first_step"]
        self._shared.resting[self._index] = small["resting"]
        self._game.restore(unpack_game(snapshot[end:]))


class GameGroup:
    """Some of a vector's games, played by one process."""

    def __init__(self, assignment: Assignment, shared: SharedArrays) -> None:
        known_starts: KnownStarts = {}
        consoles = [Console(known_starts) for _ in assignment.games]
        # All at once: one passes the others on its way, and no step has to wait for one later.
        for start in sorted(assignment.starts.possible_starts):
            consoles[0].start(start)
        demonstrations = DemonstrationStates(assignment.starts.demonstrations, known_starts)
        own = slice(assignment.games.start, assignment.games.stop)
        self._half = shared.half
        self._halves = [half[own] for half in shared.observations]
        self._views = AgentViews(len(assignment.games), self._halves[0])
        self._slots = [
            GameSlot(index, assignment, shared, demonstrations, view, console)
            for index, view, console in zip(assignment.games, self._views, consoles, strict=True)
        ]

    def answer(self, command: Command, snapshots: Sequence[bytes] | None = None) -> Answer:
        """Carry out a command.

        Args:
            command: what to do.
            snapshots: of the games, to restore.

        Returns:
            The games that a step ended; the games' snapshots; else None.
        """
        self._views.turn_to(self._halves[self._half[0]])
        if command is Command.STEP:
            # First all steps, then all observations, then all new games: see AgentViews.
            ended = [slot for slot in self._slots if slot.step()]
            self._views.complete()
            finished = [slot.finish() for slot in ended]
            self._views.complete()
            return finished or None
        if command is Command.SNAPSHOT:
            return [slot.snapshot() for slot in self._slots]
        if command is Command.RESET:
            for slot in self._slots:
                slot.begin()
        else:
            for slot, snapshot in zip(self._slots, snapshots or (), strict=True):
                slot.restore(snapshot)
        self._views.complete()
        return None
