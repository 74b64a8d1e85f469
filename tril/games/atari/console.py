"""The emulated console: start, step, screen, RAM, save and restore."""

import hashlib
import struct
import zlib
from dataclasses import dataclass
from typing import Self

import ale_py
import cv2
import numpy as np
import numpy.typing as npt

from tril.games.atari.palette import palette_grayscale, palette_rgb
from tril.games.space_invaders import memory as game
from tril.games.space_invaders.starts import Start

Screen = npt.NDArray[np.uint8]
"""A screen, uint8 (210, 160): palette values or grayscale."""

_STATE_HEADER = struct.Struct("<BI")
_STATE_VERSION = 1


@dataclass(frozen=True)
class ConsoleState:
    """A saved console, which can be restored into any console in any process.

    Attributes:
        machine: the emulator's state.
        screen: the screen's palette values, 210 x 160 bytes, which the emulator's state lacks.
    """

    machine: ale_py.ALEState
    screen: bytes

    def to_bytes(self) -> bytes:
        """Return the state as bytes, about 9 kB; `from_bytes` reads them."""
        machine = self.machine.serialize()
        header = _STATE_HEADER.pack(_STATE_VERSION, len(machine))
        return header + machine + zlib.compress(self.screen, 1)

    @classmethod
    def from_bytes(cls, data: bytes) -> Self:
        """Read a state that `to_bytes` wrote.

        Raises:
            ValueError: the bytes are of another format version.
        """
        version, size = _STATE_HEADER.unpack_from(data)
        if version != _STATE_VERSION:
            raise ValueError(f"Expected console state version {_STATE_VERSION}, got {version}.")
        end = _STATE_HEADER.size + size
        machine = ale_py.ALEState(data[_STATE_HEADER.size : end])
        return cls(machine, zlib.decompress(data[end:]))


StartCache = dict[Start, ConsoleState]
"""Console states at starts, to be shared by the consoles of a process."""


class Console:
    """One emulated console with Space Invaders in it.

    The game is a deterministic function of the start and the actions since. A start reached before
    is restored from the cache instead of played again, with the same result.
    """

    def __init__(self, start_cache: StartCache | None = None) -> None:
        """Load the ROM; takes about 0.1 s.

        Args:
            start_cache: starts reached before, shared with other consoles and threads of this
                process.
        """
        ale_py.ALEInterface.setLoggerMode(ale_py.LoggerMode.Error)
        self._ale = ale_py.ALEInterface()
        self._ale.setFloat("repeat_action_probability", 0.0)
        self._ale.setBool("sound", False)
        self._ale.loadROM(game.rom_path())
        self._start_cache: StartCache = {} if start_cache is None else start_cache
        self._ram = np.empty(game.RAM_SIZE, np.uint8)
        # After a restore, the emulator shows the old screen until the next frame is drawn.
        self._restored_screen: Screen | None = None

    def start(self, start: Start) -> None:
        """Begin a game: reset, run the intro and the start's idle frames."""
        state = self._start_cache.get(start)
        if state is None:
            self._play_to(start)
            state = self._start_cache[start] = self.save()
        # Also after playing to it, so that a start is the same however it was reached.
        self.restore(state)

    def _play_to(self, start: Start) -> None:
        earlier = [
            known
            for known in list(self._start_cache)  # another thread may add one
            if (known.mode, known.difficulty) == (start.mode, start.difficulty)
            and known.idle_frames < start.idle_frames
        ]
        if earlier:
            nearest = max(earlier)
            self.restore(self._start_cache[nearest])
            frames = start.idle_frames - nearest.idle_frames
        else:
            self._ale.setMode(start.mode)
            self._ale.setDifficulty(start.difficulty)
            self._ale.reset_game()
            frames = game.INTRO_FRAMES + start.idle_frames
        for _ in range(frames):
            self.act(game.Action.NOOP)

    def act(self, action: int) -> None:
        """Run one frame with this action, an index into the minimal actions."""
        self._ale.act(_ALE_ACTIONS[action])
        self._restored_screen = None

    @property
    def ram(self) -> npt.NDArray[np.uint8]:
        """The RAM, uint8 (128,), a fresh array."""
        return self._ale.getRAM()

    def ram_bytes(self) -> bytes:
        """Return the RAM as 128 bytes: faster to index than `ram`."""
        self._ale.getRAM(self._ram)
        return self._ram.tobytes()

    def ram_hash(self) -> str:
        """Return a digest of the RAM: 16 hexadecimal digits of BLAKE2b."""
        return hashlib.blake2b(self.ram_bytes(), digest_size=8).hexdigest()

    @property
    def lives(self) -> int:
        """The emulator's count of lives, which drops 128 to 131 frames after the hit."""
        return int(self._ale.lives())

    def screen_palette(self, out: Screen | None = None) -> Screen:
        """Return the screen, uint8 (210, 160) of palette values, in out if given."""
        if out is None:
            out = np.empty(game.SCREEN_SHAPE, np.uint8)
        if self._restored_screen is None:
            self._ale.getScreen(out)
        else:
            out[:] = self._restored_screen
        return out

    def screen_grayscale(self, out: Screen | None = None) -> Screen:
        """Return the screen, uint8 (210, 160) of grays from 0 to 255, in out if given."""
        gray = cv2.LUT(self.screen_palette(), palette_grayscale(), dst=out)
        return np.asarray(gray, np.uint8)

    def screen_rgb(self) -> npt.NDArray[np.uint8]:
        """Return the screen, uint8 (210, 160, 3) RGB."""
        return palette_rgb()[self.screen_palette()]

    def save(self) -> ConsoleState:
        """Return the state of the console."""
        return ConsoleState(self._ale.cloneState(), self.screen_palette().tobytes())

    def restore(self, state: ConsoleState) -> None:
        """Restore a saved state; equal actions then give equal frames."""
        self._ale.restoreState(state.machine)
        self._restored_screen = np.frombuffer(state.screen, np.uint8).reshape(game.SCREEN_SHAPE)


_ALE_ACTIONS = tuple(getattr(ale_py.Action, action.name) for action in game.Action)
