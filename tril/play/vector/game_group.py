"""The games of a vector, in groups that are each played by one process."""

import json
import mmap
import struct
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Any

import numpy as np

from tril.games.base import Console, Game, Start, StartCache, Taken
from tril.play.agent import AgentGame, StickyActions
from tril.play.observation import OBSERVATION_SHAPE, AgentView, agent_views
from tril.play.saved_game import pack_game, unpack_game
from tril.play.vector.reset_distribution import (
    DemonstrationLog,
    DemonstrationStep,
    ResetDistribution,
)

_SNAPSHOT_HEADER = struct.Struct("<BI")
_SNAPSHOT_VERSION = 1


class Command(Enum):
    """A command to a group of games."""

    RESET = b"R"
    STEP = b"S"
    SNAPSHOT = b"G"
    RESTORE = b"P"


@dataclass(frozen=True)
class FinishedGame:
    """A finished episode of a vector.

    Attributes:
        game: index of the game in the vector.
        start: how it began.
        actions: the action executed at every frame since the start, one byte each, including those
            of the demonstration or opening that it began with.
        first_step: the first step played by the vector; 0 unless the episode began with a
            demonstration or an opening.
        from_demonstration: whether it began in a demonstration.
        taken: the items taken, in order of time, since the start.
        end: name of the end.
        died: whether it ended with the player's death.
        truncated: whether the time limit ended it.
    """

    game: int
    start: Start
    actions: bytes
    first_step: int
    from_demonstration: bool
    taken: tuple[Taken, ...]
    end: str
    died: bool
    truncated: bool


@dataclass(frozen=True)
class GroupConfig:
    """The configuration of a group of games.

    Attributes:
        game: the game.
        n_games: number of games in the whole vector.
        games: indices of the group's games.
        part: number of the vector's part that they belong to.
        reset_distribution: where episodes begin.
        end_rule: name of the rule by which a loss ends an episode.
        max_frames: maximum length of an episode.
        sticky_action_probability: see StickyActions.
        training_seed: seeds the games' generators, together with their indices or starts.
    """

    game: Game
    n_games: int
    games: range
    part: int
    reset_distribution: ResetDistribution
    end_rule: str
    max_frames: int
    sticky_action_probability: float
    training_seed: int


Reply = list[FinishedGame] | list[bytes] | None


class SharedArrays:
    """The arrays that a vector shares with its processes, in one block of memory.

    Attributes:
        observations: uint8 (2, n, 4, 84, 84), double-buffered.
        half: uint8 (n,), one entry per part: which of the two buffers its current command fills.
        terminal_observations: uint8 (n, 4, 84, 84), valid where ended.
        actions: uint8 (n,).
        ended: bool (n,): whether the last step ended an episode.
        inactive: bool (n,): whether the game has no further episode.
        steps: int32 (n,): steps since the start of the episode last stepped.
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
        self.inactive = self._array((n_games,), np.bool_)
        self.half = self._array((n_games,), np.uint8)

    def _array(self, shape: tuple[int, ...], dtype: type[np.generic]) -> Any:
        count = int(np.prod(shape))
        array = np.frombuffer(self._memory, dtype, count, self._offset).reshape(shape)
        # Rounded up, so that every array is aligned.
        self._offset += -(-array.nbytes // 64) * 64
        return array

    @staticmethod
    def size(n_games: int) -> int:
        """Return an upper bound of the arrays' size in bytes."""
        return n_games * (3 * int(np.prod(OBSERVATION_SHAPE)) + 8) + 7 * 64


class DemonstrationStates:
    """The states before every step of the demonstrations, replayed on first use by a rule."""

    def __init__(
        self, game: Game, logs: tuple[DemonstrationLog, ...], end_rule: str, start_cache: StartCache
    ) -> None:
        self._game = game
        self._logs = logs
        self._end_rule = end_rule
        self._start_cache = start_cache
        self._states: dict[int, list[bytes]] = {}

    def state(self, at: DemonstrationStep) -> bytes:
        """Return the packed game before a step."""
        if at.demonstration not in self._states:
            self._states[at.demonstration] = self._replay(self._logs[at.demonstration])
        return self._states[at.demonstration][at.step]

    def _replay(self, log: DemonstrationLog) -> list[bytes]:
        console = self._game.make_console(self._start_cache)
        replay = AgentGame(console, self._end_rule, len(log.actions))
        replay.reset(log.start)
        states = []
        for frame, action in enumerate(log.actions):
            if frame % self._game.clock.frames_per_step == 0:
                states.append(pack_game(replay.save()))
            replay.advance(action)
        return states


class GameSlot:
    """One game of a vector, with its own generators and automatic reset."""

    def __init__(
        self,
        index: int,
        config: GroupConfig,
        shared: SharedArrays,
        demonstrations: DemonstrationStates,
        view: AgentView,
        console: Console,
    ) -> None:
        self._index = index
        self._resets = config.reset_distribution
        self._shared = shared
        self._demonstrations = demonstrations
        seed = config.training_seed
        self._start_rng = np.random.default_rng((seed, index, 0))
        self._sticky_rng = np.random.default_rng((seed, *self._resets.rng_key(index), 1))
        sticky_probability = config.sticky_action_probability
        self._game = AgentGame(
            console,
            config.end_rule,
            config.max_frames,
            StickyActions(sticky_probability, self._sticky_rng) if sticky_probability else None,
            view,
        )
        self._games_before = 0
        self._first_step = 0
        self._from_demonstration = False

    def begin(self) -> None:
        """Begin the next episode; become inactive if there is none."""
        sample = self._resets.sample(self._start_rng, self._index, self._games_before)
        self._first_step = 0
        self._from_demonstration = isinstance(sample, DemonstrationStep)
        if sample is None:
            self._shared.inactive[self._index] = True
        elif isinstance(sample, DemonstrationStep):
            self._first_step = sample.step
            self._game.restore(unpack_game(self._demonstrations.state(sample), self._game.console))
        else:
            self._first_step = self._game.begin(sample)

    def step(self) -> bool:
        """Play the step whose action is in shared memory; return whether it ended the episode."""
        shared, index = self._shared, self._index
        if shared.inactive[index]:
            shared.ended[index] = False
            return False
        self._game.step(int(shared.actions[index]))
        ended = self._game.end is not None
        shared.ended[index] = ended
        shared.steps[index] = self._game.steps
        return ended

    def finish(self) -> FinishedGame:
        """Return the episode that has ended and begin the next one."""
        self._game.observe(self._shared.terminal_observations[self._index])
        episode = self._game.episode
        if episode.end is None:
            raise RuntimeError(f"Game {self._index} has not ended.")
        finished = FinishedGame(
            game=self._index,
            start=episode.start,
            actions=episode.actions,
            first_step=self._first_step,
            from_demonstration=self._from_demonstration,
            taken=episode.taken,
            end=episode.end,
            died=episode.died,
            truncated=episode.end == episode.game.time_end,
        )
        self._games_before += 1
        self.begin()
        return finished

    def snapshot(self) -> bytes:
        """Return the state of the game and its generators."""
        small = {
            "start_rng": self._start_rng.bit_generator.state,
            "sticky_rng": self._sticky_rng.bit_generator.state,
            "games_before": self._games_before,
            "first_step": self._first_step,
            "from_demonstration": self._from_demonstration,
            "resting": bool(self._shared.inactive[self._index]),
        }
        text = json.dumps(small).encode()
        header = _SNAPSHOT_HEADER.pack(_SNAPSHOT_VERSION, len(text))
        return header + text + pack_game(self._game.save())

    def restore(self, snapshot: bytes) -> None:
        """Restore a snapshot."""
        version, size = _SNAPSHOT_HEADER.unpack_from(snapshot)
        if version != _SNAPSHOT_VERSION:
            raise ValueError(f"Expected snapshot version {_SNAPSHOT_VERSION}, got {version}.")
        end = _SNAPSHOT_HEADER.size + size
        small = json.loads(snapshot[_SNAPSHOT_HEADER.size : end])
        self._start_rng.bit_generator.state = small["start_rng"]
        self._sticky_rng.bit_generator.state = small["sticky_rng"]
        self._games_before = small["games_before"]
        self._first_step = small["first_step"]
        # Checkpoints of earlier versions know no openings.
        self._from_demonstration = small.get("from_demonstration", self._first_step > 0)
        self._shared.inactive[self._index] = small["resting"]
        self._game.restore(unpack_game(snapshot[end:], self._game.console))


class GameGroup:
    """The games of a vector that one process plays."""

    def __init__(self, config: GroupConfig, shared: SharedArrays) -> None:
        start_cache: StartCache = {}
        consoles = [config.game.make_console(start_cache) for _ in config.games]
        # In order, since each start is reached from the one before, and now, so that no step waits.
        for start in sorted(config.reset_distribution.possible_starts):
            consoles[0].start(start)
        demonstrations = DemonstrationStates(
            config.game, config.reset_distribution.demonstrations, config.end_rule, start_cache
        )
        games = slice(config.games.start, config.games.stop)
        self._half = shared.half[config.part : config.part + 1]
        self._halves = [half[games] for half in shared.observations]
        self._views = agent_views(config.game, len(config.games), self._halves[0])
        self._slots = [
            GameSlot(index, config, shared, demonstrations, view, console)
            for index, view, console in zip(config.games, self._views, consoles, strict=True)
        ]

    def execute(self, command: Command, snapshots: Sequence[bytes] | None = None) -> Reply:
        """Execute a command.

        Args:
            command: the command.
            snapshots: the games' snapshots for RESTORE.

        Returns:
            The finished games for STEP, the games' snapshots for SNAPSHOT, else None.
        """
        self._views.set_output(self._halves[self._half[0]])
        if command is Command.STEP:
            # All steps, then all observations, then all resets: AgentViews batches them.
            ended = [slot for slot in self._slots if slot.step()]
            self._views.flush()
            finished = [slot.finish() for slot in ended]
            self._views.flush()
            return finished or None
        if command is Command.SNAPSHOT:
            return [slot.snapshot() for slot in self._slots]
        if command is Command.RESET:
            for slot in self._slots:
                slot.begin()
        else:
            for slot, snapshot in zip(self._slots, snapshots or (), strict=True):
                slot.restore(snapshot)
        self._views.flush()
        return None
