"""The scripted player: aims by RAM and looks ahead on the saved game.

It plays one action every four frames, as agents do, in short sequences that it first simulates on
the saved game. The game is deterministic, so a simulated sequence that hits the target alien and no
other, and that the player survives, does so when played.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from tril.games.base import Cell
from tril.games.space_invaders import memory as game
from tril.games.space_invaders.ends import EndReason
from tril.games.space_invaders.grid import missile_in_air
from tril.games.space_invaders.memory import FRAMES_PER_STEP, Action
from tril.games.space_invaders.readout import alien_grid
from tril.play.episode import Episode, EpisodeState
from tril.recording import Recorder

_PX_PER_STEP = game.PLAYER_SPEED_PX * FRAMES_PER_STEP
_REACH_PX = 6
"""Distance from an alien's centre at which a missile, when fired, may still hit it."""
_TAIL_STEPS = 12
"""Steps that have to be safe after a sequence: longer than a bomb falls, and enough to dodge one
dropped then."""
_FLIGHT_STEPS = 30
"""Upper bound of a missile's flight."""
_MAX_WALK_STEPS = 45
_RETRY_FRAMES = 16
"""Wait after an impossible shot; the aliens move half a pixel meanwhile."""
_SHARE_PER_HIT = 0.075
"""Share of the game reserved for each target hit."""
_PX_PER_STEP_OF_DELAY = 0.25
"""Aim error traded for a shot one step earlier."""
_MAX_WAIT_STEPS = 4
"""Longest wait at a wall before a shot."""
_MAX_STROLL_STEPS = 6
"""Steps after which a walk without a shot is replanned."""
_SIDES = (Action.LEFT, Action.RIGHT)
_DODGES = (1, 2, 3, 4, 6, 8, 12)
"""Lengths, in steps, of dodges to either side."""


@dataclass(frozen=True)
class PlayStyle:
    """Playing style: what varies between games that show the same, unlike errors.

    Attributes:
        pace: Share of the game, 0 to 1, over which the target hits are spread.
        aim_px: Standard deviation of the point aimed at, from an alien's centre.
        wander_px: Range of walks while waiting.
        wait_steps: Mean length of a rest between two walks.
    """

    pace: float = 0.5
    aim_px: float = 1.5
    wander_px: float = 10.0
    wait_steps: float = 6.0


def draw_style(rng: np.random.Generator) -> PlayStyle:
    """Draw a style for a ranked demonstration."""
    return PlayStyle(
        pace=rng.uniform(0.2, 0.7),
        aim_px=rng.uniform(0.5, 2.0),
        wander_px=rng.uniform(4.0, 16.0),
        wait_steps=rng.uniform(3.0, 9.0),
    )


def draw_brisk_style(rng: np.random.Generator) -> PlayStyle:
    """Draw a style for cloning: quick shots, since a clone sees no time to wait for."""
    return PlayStyle(
        pace=rng.uniform(0.0, 0.15),
        aim_px=rng.uniform(0.2, 1.0),
        wander_px=rng.uniform(2.0, 8.0),
        wait_steps=rng.uniform(3.0, 9.0),
    )


def draw_times(
    targets: Sequence[Cell], style: PlayStyle, max_frames: int, rng: np.random.Generator
) -> list[float]:
    """Draw the earliest time of each target hit, in frames from the start.

    Args:
        targets: The aliens to hit, in order.
        style: Playing style.
        max_frames: Length of the game.
        rng: Source of the draws.
    """
    latest = min(style.pace, max(0.0, 1 - len(targets) * _SHARE_PER_HIT))
    times = np.sort(rng.uniform(0, latest * max_frames, len(targets)))
    # The rightmost column is out of the cannon's reach from about frame 600 to 1,000.
    leaving = [n for n, (_, column) in enumerate(targets) if column == game.COLUMNS - 1]
    if leaving:
        times[: leaving[-1] + 1] = 0
    return [float(time) for time in times]


class ScriptedPlayer:
    """Plays one game in which it hits the given aliens in order and no others."""

    def __init__(
        self,
        recorder: Recorder,
        targets: Sequence[Cell],
        style: PlayStyle,
        rng: np.random.Generator,
    ) -> None:
        """Prepare to play the recorder's game, which is at its start; see Planner."""
        self._recorder = recorder
        self._planner = Planner(recorder.episode, targets, style, rng)

    def play(self) -> None:
        """Play until the game ends, skipping hits that prove impossible."""
        while self._recorder.episode.end is None:
            self._execute(self._planner.next_actions())

    def _execute(self, actions: Iterable[int]) -> None:
        for action in actions:
            for _ in range(FRAMES_PER_STEP):
                if self._recorder.episode.end is not None:
                    return
                self._recorder.advance(action)


class Planner:
    """Plans the next actions in a game by simulating them on it."""

    def __init__(
        self, episode: Episode, targets: Sequence[Cell], style: PlayStyle, rng: np.random.Generator
    ) -> None:
        """Make a planner for a game.

        Args:
            episode: The game, which ends at the hit; planning restores its state.
            targets: The aliens to hit, as (row, column), in an order in which each can be shot.
                Begins with those hit so far.
            style: Playing style.
            rng: Source of the player's random choices.
        """
        self._episode = episode
        self._targets = list(targets)
        self._style = style
        self._rng = rng
        self._due = draw_times(targets, style, episode.max_frames, rng)
        self._next_try = 0

    def next_actions(self) -> Sequence[int]:
        """Return the actions of the next steps, at least one, to be played before the next call."""
        n_hits = len(self._episode.taken)
        if n_hits == len(self._targets):
            return self._walk(_player_x(self._episode))
        cell = self._targets[n_hits]
        if self._episode.frame >= max(self._due[n_hits], self._next_try):
            shot = self._shot(cell)
            if shot is not None:
                return shot
            self._next_try = self._episode.frame + _RETRY_FRAMES
        return self._walk(column_centre(self._episode, cell[1]) - game.MISSILE_OFFSET)

    # Walking and waiting

    def _walk(self, place: float) -> Sequence[int]:
        """Return a walk to near a player x and a rest, or a dodge if that is unsafe."""
        drawn = place + self._rng.uniform(-1, 1) * self._style.wander_px
        goal = float(np.clip(drawn, game.PLAYER_LEFT_WALL, game.PLAYER_RIGHT_WALL))
        way = goal - _player_x(self._episode)
        n_walk = min(round(abs(way) / _PX_PER_STEP), _MAX_STROLL_STEPS)
        n_rest = 1 + int(self._rng.poisson(self._style.wait_steps))
        if n_walk == _MAX_STROLL_STEPS:
            n_rest = 0
        dodges = [[int(side)] * n_steps for n_steps in _DODGES for side in _SIDES]
        self._rng.shuffle(dodges)
        dodges.sort(key=len)
        wish = [direction_to(way)] * n_walk + idle(n_rest)
        before = self._episode.save()
        latest, best = -1, idle(1)
        for actions in (wish, idle(1), *dodges):
            hit_at = self._death_frame([*actions, *idle(_TAIL_STEPS)])
            self._episode.restore(before)
            if hit_at is None:
                return actions
            if hit_at > latest:
                latest, best = hit_at, actions[:1]
        return best

    def _death_frame(self, actions: Sequence[int]) -> int | None:
        """Simulate actions; return the frame of the player's death, None if it survives."""
        self._simulate(actions)
        return self._episode.frame if self._episode.end == EndReason.HIT else None

    def _simulate(self, actions: Iterable[int]) -> None:
        """Simulate actions on the episode, which the caller restores."""
        for action in actions:
            for _ in range(FRAMES_PER_STEP):
                if self._episode.end is not None:
                    return
                self._episode.advance(action)

    # Shooting

    def _shot(self, cell: Cell) -> Sequence[int] | None:
        """Return a walk, a shot that hits only this alien, and moves until the hit, or None."""
        before = self._episode.save()
        aim = self._rng.normal(0, self._style.aim_px)
        try:
            for way, state in self._approaches(cell, aim):
                for aside in self._sidesteps():
                    self._episode.restore(state)
                    actions = self._fire(cell, aside)
                    if actions is not None:
                        return [*way, *actions]
                    if self._episode.end != EndReason.HIT:
                        break  # The missile misses, however the player moves.
            return None
        finally:
            self._episode.restore(before)

    def _sidesteps(self) -> list[list[int]]:
        """Return moves during the missile's flight, best first: to the next alien, or none."""
        asides = [[], *([int(side)] * n_steps for n_steps in _DODGES for side in _SIDES)]
        n_next = len(self._episode.taken) + 1
        if n_next < len(self._targets) and self._episode.frame >= self._due[n_next]:
            way = column_centre(self._episode, self._targets[n_next][1]) - _missile_x(self._episode)
            if abs(way) > game.COLUMN_WIDTH / 2:
                asides.insert(0, [direction_to(way)] * round(abs(way) / _PX_PER_STEP))
        return asides

    def _approaches(self, cell: Cell, aim: float) -> list[tuple[list[int], EpisodeState]]:
        """Return walks to firing positions for an alien, with the states after them, best first."""
        before = self._episode.save()
        offset = column_centre(self._episode, cell[1]) - _missile_x(self._episode)
        ways: list[tuple[float, list[int], EpisodeState]] = []
        for action in (int(Action.RIGHT), int(Action.LEFT)):
            if abs(offset) > _REACH_PX and action != direction_to(offset):
                continue
            self._episode.restore(before)
            n_waited = 0
            for n_steps in range(_MAX_WALK_STEPS):
                x = _missile_x(self._episode)
                distance = x - column_centre(self._episode, cell[1])
                ready = not missile_in_air(self._episode.console.ram_bytes())
                if abs(distance) <= _REACH_PX and ready:
                    cost = abs(distance - aim) + n_steps * _PX_PER_STEP_OF_DELAY
                    ways.append((cost, [action] * n_steps, self._episode.save()))
                elif abs(distance) > _REACH_PX and action == direction_to(distance):
                    break
                self._simulate([action])
                n_waited += _missile_x(self._episode) == x
                if self._episode.end is not None or n_waited > _MAX_WAIT_STEPS:
                    break
        ways.sort(key=lambda way: way[0])
        return [(way, state) for _, way, state in ways]

    def _fire(self, cell: Cell, aside: Sequence[int]) -> list[int] | None:
        """Simulate a shot while walking aside; return the actions until the hit.

        None if the shot misses, hits another alien, or the player is hit then or soon after.
        """
        n_hits = len(self._episode.taken)
        walk = iter(aside)
        actions = [int(Action.FIRE)]
        self._simulate(actions)
        while len(self._episode.taken) == n_hits:
            in_air = missile_in_air(self._episode.console.ram_bytes())
            if self._episode.end is not None or not in_air or len(actions) > _FLIGHT_STEPS:
                return None
            actions.append(next(walk, int(Action.NOOP)))
            self._simulate(actions[-1:])
        new_hits = [(hit.row, hit.column) for hit in self._episode.taken[n_hits:]]
        if new_hits != [cell] or self._death_frame([*walk, *idle(_TAIL_STEPS)]) is not None:
            return None
        return actions


def direction_to(way: float) -> int:
    """Return the action that walks this way, positive being right."""
    return int(Action.RIGHT if way > 0 else Action.LEFT)


def idle(n: int) -> list[int]:
    """Return n actions without a key."""
    return [int(Action.NOOP)] * n


def _player_x(episode: Episode) -> int:
    return episode.console.ram_bytes()[game.RAM_PLAYER_X]


def _missile_x(episode: Episode) -> int:
    """Return the x, in pixels, of a missile fired now."""
    return _player_x(episode) + game.MISSILE_OFFSET


def column_centre(episode: Episode, column: int) -> int:
    """Return the centre of a column of aliens, in pixels, also of a cleared one."""
    return (
        episode.console.ram_bytes()[game.RAM_ALIEN_X]
        + game.COLUMN_WIDTH * (column - alien_grid(episode.readout).shifts)
        + game.ALIEN_CENTRE
    )
