"""The scripted player: aims by RAM and looks ahead on the saved game for hits.

It plays as an agent does, one action every four frames, in short sequences of actions that it
tries out on the saved game before it plays them. The game is deterministic, so what it has tried
is what happens: a sequence that hits the wanted alien, no other, and does not get the player hit.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from tril.behaviours import Cell
from tril.game import space_invaders as game
from tril.game.aliens import missile_in_air
from tril.game.episode import EndReason, Episode, EpisodeState
from tril.game.space_invaders import FRAMES_PER_STEP, Action
from tril.recording import Recorder

_PX_PER_STEP = game.PLAYER_SPEED_PX * FRAMES_PER_STEP
_REACH_PX = 6
"""A missile this far from an alien's centre when it is fired may still hit it."""
_TAIL_STEPS = 12
"""How long what follows a sequence has to be safe: a bomb needs fewer steps to come down, and this
is enough to walk out of the way of one that comes then."""
_FLIGHT_STEPS = 30
"""More than any missile stays in the air."""
_MAX_WALK_STEPS = 45
_RETRY_FRAMES = 16
"""Wait after a shot that can't be made: meanwhile the aliens move half a pixel."""
_SHARE_PER_HIT = 0.075
"""Part of the game to keep for each wanted hit."""
_PX_PER_STEP_OF_DELAY = 0.25
"""How much worse an aim may be if the shot comes a step earlier."""
_MAX_WAIT_STEPS = 4
"""How long a walk that ends at a wall may wait there before the shot."""
_MAX_STROLL_STEPS = 6
"""A walk that has no alien for its goal is looked at again after so many steps."""
_SIDES = (Action.LEFT, Action.RIGHT)
_DODGES = (1, 2, 3, 4, 6, 8, 12)
"""Steps walked aside when a bomb comes."""


@dataclass(frozen=True)
class Style:
    """How the player plays what it is to show. A game is different for each draw of its chances.

    Attributes:
        pace: Part of the game, 0 to 1, over which the wanted hits are spread.
        aim_px: Standard deviation of where on an alien it aims, from the alien's centre.
        wander_px: How far it walks about while it waits.
        wait_steps: Mean length of a rest between two walks.
    """

    pace: float = 0.5
    aim_px: float = 1.5
    wander_px: float = 10.0
    wait_steps: float = 6.0


def draw_style(rng: np.random.Generator) -> Style:
    """Draw a style, so that games differ in more than their start."""
    return Style(
        pace=rng.uniform(0.2, 0.7),
        aim_px=rng.uniform(0.5, 2.0),
        wander_px=rng.uniform(4.0, 16.0),
        wait_steps=rng.uniform(3.0, 9.0),
    )


def draw_brisk_style(rng: np.random.Generator) -> Style:
    """Draw a style for a clone to learn from: whoever can't count time has to see when to shoot."""
    return Style(
        pace=rng.uniform(0.0, 0.15),
        aim_px=rng.uniform(0.2, 1.0),
        wander_px=rng.uniform(2.0, 8.0),
        wait_steps=rng.uniform(3.0, 9.0),
    )


def draw_times(
    wanted: Sequence[Cell], style: Style, max_frames: int, rng: np.random.Generator
) -> list[float]:
    """Draw when each wanted hit is tried at the earliest, in frames from the start.

    Args:
        wanted: The aliens to hit, in order.
        style: How the game is to be played.
        max_frames: How long it is.
        rng: Where the chances come from.
    """
    latest = min(style.pace, max(0.0, 1 - len(wanted) * _SHARE_PER_HIT))
    times = np.sort(rng.uniform(0, latest * max_frames, len(wanted)))
    # The rightmost column drifts out of the cannon's reach within 600 frames and comes back after
    # 1,000.
    leaving = [n for n, (_, column) in enumerate(wanted) if column == game.COLUMNS - 1]
    if leaving:
        times[: leaving[-1] + 1] = 0
    return [float(time) for time in times]


class ScriptedPlayer:
    """Plays one game in which it hits wanted aliens, one after the other, and nothing else."""

    def __init__(
        self, recorder: Recorder, wanted: Sequence[Cell], style: Style, rng: np.random.Generator
    ) -> None:
        """Take a seat at a game that is at its start.

        Args:
            recorder: The game to play, which it records.
            wanted: As of Planner.
            style: How it plays.
            rng: Where its chances come from.
        """
        self._recorder = recorder
        self._planner = Planner(recorder.episode, wanted, style, rng)

    def play(self) -> None:
        """Play until the game ends. Wanted hits that never come off are left out."""
        while self._recorder.episode.end is None:
            self._execute(self._planner.next_actions())

    def _execute(self, actions: Iterable[int]) -> None:
        for action in actions:
            for _ in range(FRAMES_PER_STEP):
                if self._recorder.episode.end is not None:
                    return
                self._recorder.advance(action)


class Planner:
    """Decides what to do next in a game, by trying it out on the game itself."""

    def __init__(
        self, episode: Episode, wanted: Sequence[Cell], style: Style, rng: np.random.Generator
    ) -> None:
        """Look at a game.

        Args:
            episode: The game, which ends at the hit; it is left as it was found.
            wanted: The aliens to hit, as (row, column), in an order in which each stands free
                when its turn comes, after as many cells as have been hit already.
            style: How it is to be played.
            rng: Where the chances come from.
        """
        self._episode = episode
        self._wanted = list(wanted)
        self._style = style
        self._rng = rng
        self._due = draw_times(wanted, style, episode.max_frames, rng)
        self._next_try = 0

    def next_actions(self) -> Sequence[int]:
        """Return the actions of the next steps, at least one; play them all before asking again."""
        n_hits = len(self._episode.hits)
        if n_hits == len(self._wanted):
            return self._walk(_player_x(self._episode))
        cell = self._wanted[n_hits]
        if self._episode.frame >= max(self._due[n_hits], self._next_try):
            shot = self._shot(cell)
            if shot is not None:
                return shot
            self._next_try = self._episode.frame + _RETRY_FRAMES
        return self._walk(column_centre(self._episode, cell[1]) - game.MISSILE_OFFSET)

    # Walking and waiting

    def _walk(self, place: float) -> Sequence[int]:
        """Some steps to somewhere near a place and a rest, or what the player needs to survive.

        Args:
            place: The player's x.
        """
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
        wish = [_towards(way)] * n_walk + _rest(n_rest)
        before = self._episode.save()
        latest, best = -1, _rest(1)
        for actions in (wish, _rest(1), *dodges):
            hit_at = self._hit_at([*actions, *_rest(_TAIL_STEPS)])
            self._episode.restore(before)
            if hit_at is None:
                return actions
            if hit_at > latest:
                latest, best = hit_at, actions[:1]
        return best

    def _hit_at(self, actions: Sequence[int]) -> int | None:
        """Play on the episode, to be restored: the frame of a hit on the player, or None."""
        self._play_on(actions)
        return self._episode.frame if self._episode.end is EndReason.HIT else None

    def _play_on(self, actions: Iterable[int]) -> None:
        """Play on the episode, to be restored, without recording it."""
        for action in actions:
            for _ in range(FRAMES_PER_STEP):
                if self._episode.end is not None:
                    return
                self._episode.advance(action)

    # Shooting

    def _shot(self, cell: Cell) -> Sequence[int] | None:
        """A walk, a shot that hits this alien alone, and the way until then; None if none does."""
        before = self._episode.save()
        aim = self._rng.normal(0, self._style.aim_px)
        try:
            for way, there in self._ways_to(cell, aim):
                for aside in self._asides():
                    self._episode.restore(there)
                    actions = self._fire(cell, aside)
                    if actions is not None:
                        return [*way, *actions]
                    if self._episode.end is not EndReason.HIT:
                        break  # The missile misses, whatever the player does meanwhile.
            return None
        finally:
            self._episode.restore(before)

    def _asides(self) -> list[list[int]]:
        """Ways to walk while the missile flies, best first: on to the next alien, or staying."""
        asides = [[], *([int(side)] * n_steps for n_steps in _DODGES for side in _SIDES)]
        n_next = len(self._episode.hits) + 1
        if n_next < len(self._wanted) and self._episode.frame >= self._due[n_next]:
            way = column_centre(self._episode, self._wanted[n_next][1]) - _missile_x(self._episode)
            if abs(way) > game.COLUMN_WIDTH / 2:
                asides.insert(0, [_towards(way)] * round(abs(way) / _PX_PER_STEP))
        return asides

    def _ways_to(self, cell: Cell, aim: float) -> list[tuple[list[int], EpisodeState]]:
        """Walks after which a missile may hit an alien, and the game then; the best one first."""
        before = self._episode.save()
        offset = column_centre(self._episode, cell[1]) - _missile_x(self._episode)
        found: list[tuple[float, list[int], EpisodeState]] = []
        for action in (int(Action.RIGHT), int(Action.LEFT)):
            if abs(offset) > _REACH_PX and action != _towards(offset):
                continue
            self._episode.restore(before)
            n_waited = 0
            for n_steps in range(_MAX_WALK_STEPS):
                x = _missile_x(self._episode)
                distance = x - column_centre(self._episode, cell[1])
                ready = not missile_in_air(self._episode.console.ram_bytes())
                if abs(distance) <= _REACH_PX and ready:
                    cost = abs(distance - aim) + n_steps * _PX_PER_STEP_OF_DELAY
                    found.append((cost, [action] * n_steps, self._episode.save()))
                elif abs(distance) > _REACH_PX and action == _towards(distance):
                    break
                self._play_on([action])
                n_waited += _missile_x(self._episode) == x
                if self._episode.end is not None or n_waited > _MAX_WAIT_STEPS:
                    break
        found.sort(key=lambda way: way[0])
        return [(way, there) for _, way, there in found]

    def _fire(self, cell: Cell, aside: Sequence[int]) -> list[int] | None:
        """Fire on the episode, to be restored, and walk aside: the actions until the hit.

        None if the shot misses, hits another alien, or the player is hit meanwhile or soon after.
        """
        n_hits = len(self._episode.hits)
        walk = iter(aside)
        actions = [int(Action.FIRE)]
        self._play_on(actions)
        while len(self._episode.hits) == n_hits:
            in_air = missile_in_air(self._episode.console.ram_bytes())
            if self._episode.end is not None or not in_air or len(actions) > _FLIGHT_STEPS:
                return None
            actions.append(next(walk, int(Action.NOOP)))
            self._play_on(actions[-1:])
        new = [(hit.row, hit.column) for hit in self._episode.hits[n_hits:]]
        if new != [cell] or self._hit_at([*walk, *_rest(_TAIL_STEPS)]) is not None:
            return None
        return actions


def _towards(way: float) -> int:
    """The action that walks this way, positive being right."""
    return int(Action.RIGHT if way > 0 else Action.LEFT)


def _rest(n_steps: int) -> list[int]:
    return [int(Action.NOOP)] * n_steps


def _player_x(episode: Episode) -> int:
    return episode.console.ram_bytes()[game.RAM_PLAYER_X]


def _missile_x(episode: Episode) -> int:
    """Where a missile fired now would leave, in pixels."""
    return _player_x(episode) + game.MISSILE_OFFSET


def column_centre(episode: Episode, column: int) -> int:
    """The centre of a column of aliens, in pixels; of a cleared one, where it would be."""
    return (
        episode.console.ram_bytes()[game.RAM_ALIEN_X]
        + game.COLUMN_WIDTH * (column - episode.shifts)
        + game.ALIEN_CENTRE
    )
