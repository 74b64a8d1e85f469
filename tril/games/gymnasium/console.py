"""An environment as a console: a frame is a step."""

from __future__ import annotations

import hashlib
import struct
from dataclasses import dataclass

import numpy as np

from tril.games.base import ConsoleState, Game, Screen, Start
from tril.games.gymnasium.environment import AnyEnv, Environment, Picture
from tril.games.seeds import SeedStart

_STATE_HEADER = struct.Struct("<BI")
_STATE_VERSION = 1


@dataclass(frozen=True)
class PlayedState:
    """A saved console: how its game began and what was played.

    Attributes:
        seed: The seed of its start.
        actions: The action of every frame since, one byte each.
    """

    seed: int
    actions: bytes

    def to_bytes(self) -> bytes:
        """Return the state as bytes, 5 and one for each frame."""
        return _STATE_HEADER.pack(_STATE_VERSION, self.seed) + self.actions


class GymnasiumConsole:
    """One environment.

    The game is a deterministic function of the seed and the actions since; `examine` checked that.
    So a state is the seed and the actions, and is restored by playing them. That works for every
    environment, in any process and without pickle, whose bytes could do anything when they are
    read. A copy of the environment would be restored faster, but not every one can be copied.
    """

    def __init__(self, game: Game, environment: Environment, picture: Picture) -> None:
        """Make the environment.

        Args:
            game: The game.
            environment: Environment of the game.
            picture: Picture of the environment.
        """
        self.game = game
        self.score: float = 0.0
        self.over = False
        self.truncated = False
        self.lives = 0
        self._picture = picture
        self._env: AnyEnv | None = environment.make()
        self._first_action = environment.first_action(self._env)
        self._seed: int | None = None
        self._actions = bytearray()
        # Of the current frame once it was asked for: drawing takes longer than a step.
        self._screen: Screen | None = None

    @property
    def _open_env(self) -> AnyEnv:
        if self._env is None:
            raise ValueError(f"The console of {self.game.name} is closed.")
        return self._env

    def start(self, start: Start) -> None:
        """Begin a game: reset the environment with the start's seed."""
        if not isinstance(start, SeedStart):
            raise TypeError(f"Expected a start of a Gymnasium environment, got {start!r}.")
        self._begin(start.seed)

    def _begin(self, seed: int) -> None:
        self._open_env.reset(seed=seed)
        self._seed = seed
        self._actions.clear()
        self.score = 0.0
        self.over = self.truncated = False
        self._discard_screen()

    def act(self, action: int) -> None:
        """Step the environment; nothing happens once the game has ended."""
        if self.over or self.truncated:
            return
        _, reward, terminated, truncated, _ = self._open_env.step(self._first_action + action)
        self._actions.append(action)
        self.score += float(reward)
        self.over = bool(terminated)
        self.truncated = bool(truncated) and not self.over
        self._discard_screen()

    def ram_bytes(self) -> bytes:
        """Return nothing: an environment has no memory to show."""
        return b""

    def state_hash(self) -> str:
        """Return a digest of the screen: 16 hexadecimal digits of BLAKE2b."""
        return screen_hash(self._current_screen())

    def screen(self, out: Screen | None = None) -> Screen:
        """Return the screen, uint8 (height, width, 3) RGB, in out if given."""
        screen = self._current_screen()
        if out is None:
            return screen.copy()
        out[:] = screen
        return out

    def _discard_screen(self) -> None:
        self._screen = None
        if self._picture.every_frame:
            self._current_screen()

    def _current_screen(self) -> Screen:
        if self._screen is None:
            self._screen = self._picture.of(self._open_env)
        return self._screen

    def save(self) -> PlayedState:
        """Return the state of the console.

        Raises:
            ValueError: No game was begun.
        """
        if self._seed is None:
            raise ValueError("Expected a console with a game, got one before its first start.")
        return PlayedState(self._seed, bytes(self._actions))

    def restore(self, state: ConsoleState) -> None:
        """Restore a saved state by playing it; equal actions then give equal frames.

        If the current game is the beginning of it, only the rest is played.
        """
        if not isinstance(state, PlayedState):
            raise TypeError(f"Expected a state of an environment, got {type(state).__name__}.")
        if state.seed != self._seed or not state.actions.startswith(self._actions):
            self._begin(state.seed)
        for action in state.actions[len(self._actions) :]:
            self.act(action)

    def state_from_bytes(self, data: bytes) -> PlayedState:
        """Read a state that `PlayedState.to_bytes` wrote.

        Raises:
            ValueError: The bytes are of another format version, or no state of this game.
        """
        if len(data) < _STATE_HEADER.size or data[0] != _STATE_VERSION:
            version = data[0] if data else None
            raise ValueError(f"Expected console state version {_STATE_VERSION}, got {version}.")
        _, seed = _STATE_HEADER.unpack_from(data)
        actions = data[_STATE_HEADER.size :]
        if actions and max(actions) >= self.game.controls.n_actions:
            raise ValueError(f"Expected actions of {self.game.name}, got {max(actions)}.")
        return PlayedState(seed, actions)

    def close(self) -> None:
        """Drop the environment.

        It is not closed: those that draw with pygame end it for all consoles of the process.
        """
        self._env = None


def screen_hash(screen: Screen) -> str:
    """Return 16 hexadecimal digits of BLAKE2b over a screen."""
    return hashlib.blake2b(np.ascontiguousarray(screen).data, digest_size=8).hexdigest()
