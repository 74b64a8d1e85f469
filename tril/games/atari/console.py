"""The emulated console: start, step, screen, RAM, save and restore."""

from __future__ import annotations

import hashlib
import struct
import zlib
from dataclasses import dataclass
from pathlib import Path

import ale_py
import numpy as np
import numpy.typing as npt

from tril.games.atari.starts import AtariStart
from tril.games.base import ConsoleState, Game, Screen, Start, StartCache

_STATE_HEADER = struct.Struct("<BIq")
_STATE_VERSION = 2
_SCORELESS_HEADER = struct.Struct("<BI")
_SCORELESS_VERSION = 1
"""Of trainings' checkpoints of before; the score is 0, which only a replay's figures would show."""


@dataclass(frozen=True)
class AtariState:
    """A saved console, which can be restored into any console of the game in any process.

    Attributes:
        machine: the emulator's state.
        screen: the screen's palette values, height x width bytes, which the emulator's state lacks.
        score: rewards since the game's start.
    """

    machine: ale_py.ALEState
    screen: bytes
    score: int

    def to_bytes(self) -> bytes:
        """Return the state as bytes, about 9 kB."""
        machine = self.machine.serialize()
        header = _STATE_HEADER.pack(_STATE_VERSION, len(machine), self.score)
        return header + machine + zlib.compress(self.screen, 1)


@dataclass(frozen=True)
class Intro:
    """What precedes a game: frames after a reset in which the player cannot act.

    Attributes:
        frames: Number of frames.
        button: Index of the action held at the first of them, which leaves a title screen; 0 for
            none.
        hold: Number of frames that it is held for.
    """

    frames: int = 0
    button: int = 0
    hold: int = 0


class AtariConsole:
    """One emulated Atari 2600 with a game in it.

    The game is a deterministic function of the start and the actions since. A start reached before
    is restored from the cache instead of played again, with the same result.
    """

    def __init__(
        self, game: Game, rom: Path, intro: Intro, start_cache: StartCache | None = None
    ) -> None:
        """Load the ROM; takes about 0.1 s.

        Args:
            game: the game.
            rom: path of its ROM.
            intro: what precedes it.
            start_cache: starts reached before, shared with other consoles and threads of this
                process.
        """
        ale_py.ALEInterface.setLoggerMode(ale_py.LoggerMode.Error)
        self.game = game
        self.score: float = 0
        self._ale = ale_py.ALEInterface()
        self._ale.setFloat("repeat_action_probability", 0.0)
        self._ale.setBool("sound", False)
        self._ale.loadROM(rom)
        # With the emulator's random numbers, from which a reset draws what memory and timer hold:
        # otherwise a start of Seaquest, say, would depend on how many went before it.
        self._powered_on = self._ale.cloneState(include_rng=True)
        # A state that is restored before the emulator has run a frame goes on differently in some
        # games, such as Q*bert.
        self._ale.act(ale_py.Action.NOOP)
        self._intro = intro
        self._actions = tuple(getattr(ale_py.Action, name) for name in game.controls.actions)
        self._start_cache: StartCache = {} if start_cache is None else start_cache
        self._shape = game.screen.shape
        self._ram = np.empty(self._ale.getRAMSize(), np.uint8)
        # After a restore, the emulator shows the old screen until the next frame is drawn.
        self._restored_screen: Screen | None = None

    def start(self, start: Start) -> None:
        """Begin a game: reset, run the intro if it is skipped, and the start's idle frames."""
        state = self._start_cache.get(start)
        if state is None:
            self._play_to(_atari(start))
            state = self._start_cache[start] = self.save()
        # Also after playing to it, so that a start is the same however it was reached.
        self.restore(state)

    def _play_to(self, start: AtariStart) -> None:
        earlier = [
            state
            for state in map(_atari, list(self._start_cache))  # another thread may add one
            if (state.mode, state.difficulty, state.intro)
            == (start.mode, start.difficulty, start.intro)
            and state.idle_frames < start.idle_frames
        ]
        noop = self.game.controls.noop
        if earlier:
            nearest = max(earlier)
            self.restore(self._start_cache[nearest])
            frames = start.idle_frames - nearest.idle_frames
        else:
            self._ale.restoreState(self._powered_on)
            self._ale.setMode(start.mode)
            self._ale.setDifficulty(start.difficulty)
            self._ale.reset_game()
            intro = self._intro if start.intro else Intro()
            for _ in range(intro.hold):
                self.act(intro.button)
            frames = intro.frames - intro.hold + start.idle_frames
        for _ in range(frames):
            self.act(noop)
        self.score = 0

    def act(self, action: int) -> None:
        """Run one frame with this action, an index into the game's actions."""
        self.score += self._ale.act(self._actions[action])
        self._restored_screen = None

    @property
    def over(self) -> bool:
        """Whether the emulator calls the game over."""
        return bool(self._ale.game_over(with_truncation=False))

    @property
    def ram(self) -> npt.NDArray[np.uint8]:
        """The RAM, uint8 (128,), a fresh array."""
        return self._ale.getRAM()

    def ram_bytes(self) -> bytes:
        """Return the RAM as 128 bytes: faster to index than `ram`."""
        self._ale.getRAM(self._ram)
        return self._ram.tobytes()

    def state_hash(self) -> str:
        """Return a digest of the RAM: 16 hexadecimal digits of BLAKE2b."""
        return hashlib.blake2b(self.ram_bytes(), digest_size=8).hexdigest()

    @property
    def lives(self) -> int:
        """The emulator's count of lives, which may drop seconds after the life is lost."""
        return int(self._ale.lives())

    def screen(self, out: Screen | None = None) -> Screen:
        """Return the screen, uint8 (height, width) of palette values, in out if given."""
        if out is None:
            out = np.empty(self._shape, np.uint8)
        if self._restored_screen is None:
            self._ale.getScreen(out)
        else:
            out[:] = self._restored_screen
        return out

    def save(self) -> AtariState:
        """Return the state of the console."""
        return AtariState(self._ale.cloneState(), self.screen().tobytes(), int(self.score))

    def restore(self, state: ConsoleState) -> None:
        """Restore a saved state; equal actions then give equal frames."""
        if not isinstance(state, AtariState):
            raise TypeError(f"Expected a state of an Atari console, got {type(state).__name__}.")
        self._ale.restoreState(state.machine)
        self.score = state.score
        self._restored_screen = np.frombuffer(state.screen, np.uint8).reshape(self._shape)

    def state_from_bytes(self, data: bytes) -> AtariState:
        """Read a state that `AtariState.to_bytes` wrote.

        Raises:
            ValueError: the bytes are of another format version.
        """
        version = data[0] if data else None
        if version == _STATE_VERSION:
            header = _STATE_HEADER
            _, size, score = header.unpack_from(data)
        elif version == _SCORELESS_VERSION:
            header, score = _SCORELESS_HEADER, 0
            _, size = header.unpack_from(data)
        else:
            raise ValueError(f"Expected console state version {_STATE_VERSION}, got {version}.")
        end = header.size + size
        machine = ale_py.ALEState(data[header.size : end])
        return AtariState(machine, zlib.decompress(data[end:]), score)

    def close(self) -> None:
        """Nothing to free: the emulator ends with the object."""


def _atari(start: Start) -> AtariStart:
    if not isinstance(start, AtariStart):
        raise TypeError(f"Expected a start of an Atari game, got {start!r}.")
    return start
