"""The scripted player with human limits: delayed perception, aiming by eye, and errors.

It never simulates. It knows the screen of some frames ago and the keys held since; of the RAM it
reads only what the screen shows.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tril.demonstrators.error_model import ErrorModel
from tril.demonstrators.space_invaders.player import (
    PlayStyle,
    column_centre,
    direction_to,
    draw_times,
    idle,
)
from tril.games.base import Cell
from tril.games.space_invaders import memory as game
from tril.games.space_invaders.grid import missile_in_air
from tril.games.space_invaders.memory import FRAMES_PER_STEP, Action
from tril.games.space_invaders.readout import alien_grid
from tril.play.episode import Episode
from tril.recording import Recorder

_ALIEN_SPAN_PX = (-3, 4)
"""Range of a missile that hits, from the alien's centre."""
_SHIELD_MARGIN_PX = 1
_REACH_PX = (
    game.PLAYER_LEFT_WALL + game.MISSILE_OFFSET,
    game.PLAYER_RIGHT_WALL + game.MISSILE_OFFSET,
)
"""Range of x of a missile when fired."""
_LOOKS_RIGHT_PX = 2.0
"""Largest aim error that goes unnoticed."""
_BODY_PX = (1, 7)
"""Range of a bomb that hits the cannon, from the player's x."""
_BOMB_MARGIN_PX = 2
"""Distance from the cannon at which a bomb is ignored."""
_ALARM_Y = (58.0, 72.0)
"""Range of the bomb y at which the player dodges; the cannon is at 89."""
_CANNON_Y = (84, 98)
"""Range of the bomb y that hits the cannon."""
_BOMB_SPEED_PX = 0.5
"""Pixels per frame."""
_FIRE_FRAMES = (4, 9)
"""Range of how long the fire key is held."""
_FIRE_SHOWS_FRAMES = 4
"""Delay from the fire key to a visible missile, at most."""
_FLIGHT_FRAMES = 24
"""Flight time to the lowest row at the start of a game."""
_FLIGHT_FRAMES_PER_ROW = 8
_WATCHED_FRAMES = 90
"""Window for estimating the aliens' speed."""
_EARLIEST_LEAVE = 0.25
"""Earliest share of a game's length at which it may be quit."""
_MAX_STROLL_FRAMES = 24
_MOVES = {
    Action.RIGHT: 1,
    Action.RIGHTFIRE: 1,
    Action.LEFT: -1,
    Action.LEFTFIRE: -1,
}


@dataclass(frozen=True)
class ScreenState:
    """What a screen shows, in pixels from its left and top.

    Attributes:
        player_x: The player x of the RAM.
        columns: Centres of the columns of aliens, also of cleared ones.
        alive: The remaining aliens as (row, column).
        missile: Whether the player's missile is in the air.
        bombs: (y, x) of each bomb.
    """

    player_x: int
    columns: tuple[int, ...]
    alive: frozenset[Cell]
    missile: bool
    bombs: tuple[tuple[int, int], ...]


def read_screen(episode: Episode) -> ScreenState:
    """Read a game's screen."""
    ram = episode.console.ram_bytes()
    rows, columns = np.nonzero(alien_grid(episode.readout).alive)
    return ScreenState(
        player_x=ram[game.RAM_PLAYER_X],
        columns=tuple(column_centre(episode, column) for column in range(game.COLUMNS)),
        alive=frozenset(zip(rows.tolist(), columns.tolist(), strict=True)),
        missile=missile_in_air(ram),
        bombs=tuple((ram[y], ram[x]) for y, x in game.RAM_BOMBS if 0 < ram[y] < _CANNON_Y[1]),
    )


class HumanLikePlayer:
    """Plays one game in which it tries to hit the given aliens in order."""

    def __init__(
        self,
        recorder: Recorder,
        targets: Sequence[Cell],
        style: PlayStyle,
        error_model: ErrorModel,
        rng: np.random.Generator,
    ) -> None:
        """Prepare to play the recorder's game, which is at its start.

        Args:
            recorder: The game to play and record.
            targets: The aliens to hit, as (row, column), in an order in which each can be shot.
            style: Playing style; its aim_px is ignored in favour of error_model.aim_error_px.
            error_model: Player errors.
            rng: Source of the player's random choices.
        """
        self._recorder = recorder
        self._episode = recorder.episode
        self._targets = list(targets)
        self._style = style
        self._error_model = error_model
        self._rng = rng
        self._screens: deque[ScreenState] = deque(maxlen=error_model.reaction_frames + 1)
        self._watched: deque[ScreenState] = deque(maxlen=_WATCHED_FRAMES)
        self._held: deque[int] = deque(maxlen=error_model.reaction_frames)
        self._keys: deque[int] = deque()
        self._due = draw_times(targets, style, self._episode.max_frames, rng)
        self._leaves_at = float(self._episode.max_frames)
        if rng.random() < error_model.cut_short_share:
            self._leaves_at *= rng.uniform(_EARLIEST_LEAVE, 1)
        self._aim_error: tuple[Cell, float] | None = None
        self._settled_at = 0
        self._fired_at = -game.MAX_FRAMES
        # The y at which to dodge each bomb in the air, by the bomb's x.
        self._noticed: dict[int, float] = {}

    def play(self) -> None:
        """Play until the game ends or is quit."""
        while self._episode.end is None:
            self._screens.append(read_screen(self._episode))
            if self._episode.frame >= self._leaves_at and not self._remaining(self._screens[0]):
                return
            key = self._next_key(self._screens[0])
            self._held.append(key)
            self._recorder.advance(key)

    def _next_key(self, screen: ScreenState) -> int:
        """Return the action of the next frame, given the screen of a reaction time ago."""
        self._watched.append(screen)
        self._watch_bombs(screen)
        escape = self._escape(screen)
        if escape:
            self._keys = deque(escape)
            self._aim_error = None
        if not self._keys:
            self._keys.extend(self._next_keys(screen))
        return self._keys.popleft()

    def _next_keys(self, screen: ScreenState) -> Sequence[int]:
        frame = self._episode.frame
        remaining = self._remaining(screen)
        fired = frame - self._fired_at <= self._error_model.reaction_frames + _FIRE_SHOWS_FRAMES
        in_flight = screen.missile or fired
        # A missile in the air is taken for a hit.
        next_one = remaining[1:] if in_flight and len(remaining) > 1 else remaining
        if not next_one:
            return self._stroll(screen, self._current_x(screen), self._style.wait_steps)
        cell = next_one[0]
        place = screen.columns[cell[1]] - game.MISSILE_OFFSET
        if frame < self._due[len(self._targets) - len(next_one)]:
            return self._stroll(screen, place, self._style.wait_steps)
        at = self._aim(screen, cell)
        if at is None:
            return self._stroll(screen, place, wait_steps=1)
        if self._is_under_fire(at - game.MISSILE_OFFSET, screen):
            return idle(1)
        if frame < self._settled_at + self._error_model.reaction_frames:
            return idle(1)  # Where it came to stand is not visible yet.
        if abs(screen.player_x + game.MISSILE_OFFSET - at) > _LOOKS_RIGHT_PX:
            return self._approach(screen, at)
        return idle(1) if in_flight else self._fire()

    def _remaining(self, screen: ScreenState) -> list[Cell]:
        """Return the remaining aliens to hit."""
        return [cell for cell in self._targets if cell in screen.alive]

    def _current_x(self, screen: ScreenState) -> float:
        """Estimate the current x from the one seen and the keys held since."""
        x = float(screen.player_x)
        for action in self._held:
            x += game.PLAYER_SPEED_PX * _MOVES.get(Action(action), 0)
        return float(np.clip(x, game.PLAYER_LEFT_WALL, game.PLAYER_RIGHT_WALL))

    # Walking

    def _walk(self, screen: ScreenState, goal: float) -> list[int]:
        """Return the keys to reach a goal, held too long or short by chance."""
        way = goal - self._current_x(screen)
        n_frames = abs(way) / game.PLAYER_SPEED_PX
        n_held = round(n_frames + self._rng.normal(0, self._error_model.key_error_frames))
        if n_frames < 1 or n_held < 1:
            return []
        return [direction_to(way)] * n_held

    def _stroll(self, screen: ScreenState, place: float, wait_steps: float) -> Sequence[int]:
        """Return a walk near a place and a rest."""
        goal = place + self._rng.uniform(-1, 1) * self._style.wander_px
        goal = float(np.clip(goal, game.PLAYER_LEFT_WALL, game.PLAYER_RIGHT_WALL))
        n_rest = FRAMES_PER_STEP * (1 + int(self._rng.poisson(wait_steps)))
        if self._is_under_fire(goal, screen):
            return idle(n_rest)
        way = self._walk(screen, goal)[:_MAX_STROLL_FRAMES]
        return [*way, *idle(n_rest)]

    # Bombs

    def _watch_bombs(self, screen: ScreenState) -> None:
        """Decide for each new bomb whether it is noticed."""
        falling = {x for _, x in screen.bombs}
        for x in sorted(falling - self._noticed.keys()):
            missed = self._rng.random() < self._error_model.missed_bomb_share
            self._noticed[x] = np.inf if missed else self._rng.uniform(*_ALARM_Y)
        for x in self._noticed.keys() - falling:
            del self._noticed[x]

    def _is_under_fire(self, x: float, screen: ScreenState) -> bool:
        """Return whether a bomb to dodge falls on a place."""
        return any(
            y >= self._noticed[bomb_x] and _endangers(bomb_x, x) for y, bomb_x in screen.bombs
        )

    def _escape(self, screen: ScreenState) -> list[int]:
        """Return the keys to dodge a noticed bomb, empty if there is none."""
        for y, bomb_x in screen.bombs:
            if y < self._noticed[bomb_x] or not self._collides(screen, y, bomb_x):
                continue
            margin = _BOMB_MARGIN_PX + 1 + self._rng.uniform(0, 4)
            sides = [bomb_x - _BODY_PX[1] - margin, bomb_x - _BODY_PX[0] + margin]
            open_sides = [
                side for side in sides if game.PLAYER_LEFT_WALL <= side <= game.PLAYER_RIGHT_WALL
            ]
            x = self._current_x(screen)
            return self._walk(screen, min(open_sides or sides, key=lambda side: abs(side - x)))
        return []

    def _collides(self, screen: ScreenState, y: int, bomb_x: int) -> bool:
        """Return whether a bomb hits the player during the planned keys."""
        y_now = y + _BOMB_SPEED_PX * self._error_model.reaction_frames
        first, last = ((down - y_now) / _BOMB_SPEED_PX for down in _CANNON_Y)
        x = self._current_x(screen)
        for frame, action in enumerate(self._keys):
            if first <= frame <= last and _endangers(bomb_x, x):
                return True
            x += game.PLAYER_SPEED_PX * _MOVES.get(Action(action), 0)
        return len(self._keys) <= last and _endangers(bomb_x, x)

    # Shooting

    def _approach(self, screen: ScreenState, at: float) -> Sequence[int]:
        """Return a walk to the firing position, sometimes with a premature shot."""
        way = self._walk(screen, at - game.MISSILE_OFFSET)
        self._settled_at = self._episode.frame + len(way)
        if way and self._rng.random() < self._error_model.slip_share:
            slip = int(self._rng.integers(len(way)))
            self._fired_at = self._episode.frame + slip
            fire = Action.RIGHTFIRE if way[0] == Action.RIGHT else Action.LEFTFIRE
            for frame in range(slip, min(slip + _FIRE_FRAMES[0], len(way))):
                way[frame] = int(fire)
        return way or idle(1)

    def _fire(self) -> Sequence[int]:
        self._aim_error = None
        self._fired_at = self._episode.frame
        return [int(Action.FIRE)] * int(self._rng.integers(*_FIRE_FRAMES))

    def _aim(self, screen: ScreenState, cell: Cell) -> float | None:
        """Return the firing position for an alien: about the middle of the widest shield gap.

        The aim error is drawn once per shot. None if no gap is within reach.
        """
        if self._aim_error is None or self._aim_error[0] != cell:
            self._aim_error = (cell, self._rng.normal(0, self._error_model.aim_error_px))
        places = _open_places(round(screen.columns[cell[1]] + self._lead(screen, cell)))
        if not places:
            return None
        return float(np.clip(_widest(places) + self._aim_error[1], *_REACH_PX))

    def _lead(self, screen: ScreenState, cell: Cell) -> float:
        """Extrapolate how far the aliens move until a missile reaches them."""
        drift = (screen.columns[0] - self._watched[0].columns[0]) / len(self._watched)
        flight = _FLIGHT_FRAMES + _FLIGHT_FRAMES_PER_ROW * cell[0]
        return drift * (self._error_model.reaction_frames + flight)


def _endangers(bomb_x: int, x: float) -> bool:
    return _BODY_PX[0] - _BOMB_MARGIN_PX <= bomb_x - x <= _BODY_PX[1] + _BOMB_MARGIN_PX


def _open_places(centre: int) -> list[int]:
    """Return each x from which a missile passes the shields and hits an alien."""
    first = max(centre + _ALIEN_SPAN_PX[0], _REACH_PX[0])
    last = min(centre + _ALIEN_SPAN_PX[1], _REACH_PX[1])
    return [
        x
        for x in range(first, last + 1)
        if not any(
            left_edge - _SHIELD_MARGIN_PX <= x <= right_edge + _SHIELD_MARGIN_PX
            for left_edge, right_edge in game.SHIELDS
        )
    ]


def _widest(places: Sequence[int]) -> float:
    """Return the middle of the longest run of adjacent places."""
    rows: list[list[int]] = []
    for x in places:
        if rows and rows[-1][-1] == x - 1:
            rows[-1].append(x)
        else:
            rows.append([x])
    return float(np.mean(max(rows, key=len)))
