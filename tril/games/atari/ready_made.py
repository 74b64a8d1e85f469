"""Behaviours that come with Atari games without a module of their own, each with its measures."""

from __future__ import annotations

from collections.abc import Mapping

from tril.games.behaviours import Behaviour
from tril.games.measures import (
    ActionRate,
    AliveAtEnd,
    Axes,
    Counted,
    GameScore,
    InRegion,
    Measure,
    Near,
)
from tril.games.settings import Rectangle


def _behaviour(game: str, slug: str, name: str, description: str, *measures: Measure) -> Behaviour:
    return Behaviour(slug, name, description, game, measures=measures)


_ALL = (
    _behaviour(
        "boxing",
        "keep-away",
        "Keep away",
        "Stay out of the black boxer's reach.",
        Near(thing="player", other="opponent", distance_px=40, at_most=0.2),
    ),
    _behaviour(
        "boxing",
        "stay-close",
        "Stay close",
        "Stay within the black boxer's reach all the time.",
        Near(thing="player", other="opponent", distance_px=40, at_least=0.8),
    ),
    _behaviour(
        "freeway",
        "wait-in-the-middle",
        "Wait in the middle",
        "Walk to the middle of the road and wait between its two halves.",
        InRegion(thing="chicken", area=Rectangle(0, 93, 160, 115), at_least=0.5),
        GameScore(at_most=0),
    ),
    _behaviour(
        "ms_pacman",
        "lower-half",
        "Lower half",
        "Eat in the lower half of the maze only, and stay alive.",
        InRegion(thing="player", area=Rectangle(0, 86, 160, 172), at_least=0.9),
        AliveAtEnd(),
    ),
    _behaviour(
        "ms_pacman",
        "away-from-red",
        "Away from the red ghost",
        "Keep the red ghost at a distance, whatever the others do.",
        Near(thing="player", other="blinky", distance_px=24, at_most=0.05),
        AliveAtEnd(),
    ),
    _behaviour(
        "pong",
        "stay-up",
        "Stay up",
        "Keep the paddle in the upper half, wherever the ball is.",
        InRegion(thing="player", area=Rectangle(0, 0, 160, 114), at_least=0.9),
    ),
    _behaviour(
        "pong",
        "level-with-the-ball",
        "Level with the ball",
        "Keep the paddle level with the ball, also while it flies away.",
        Near(thing="player", other="ball", distance_px=12, axes=Axes.Y, at_least=0.7),
    ),
    _behaviour(
        "riverraid",
        "middle-of-the-river",
        "Middle of the river",
        "Fly along the middle of the screen as far as the river lets you.",
        InRegion(thing="plane", area=Rectangle(66, 0, 94, 210), at_least=0.8),
        AliveAtEnd(),
    ),
    _behaviour(
        "riverraid",
        "hold-fire",
        "Hold fire",
        "Get through without a shot: fly around what is in the way.",
        ActionRate(button="fire", at_most=0),
        AliveAtEnd(),
    ),
    _behaviour(
        "seaquest",
        "near-the-surface",
        "Near the surface",
        "Stay in the upper water, and alive.",
        InRegion(thing="submarine", area=Rectangle(0, 40, 160, 84), at_least=0.8),
        AliveAtEnd(),
    ),
    _behaviour(
        "seaquest",
        "rescue-divers",
        "Rescue divers",
        "Pick up divers rather than shoot.",
        Counted(counter="divers", at_least=2),
        ActionRate(button="fire", at_most=0.5),
        AliveAtEnd(),
    ),
    _behaviour(
        "skiing",
        "left-side",
        "Left side",
        "Ski down the left side of the slope, past the gates.",
        InRegion(thing="skier", area=Rectangle(0, 0, 80, 210), at_least=0.8),
    ),
)

READY_MADE: Mapping[str, tuple[Behaviour, ...]] = {
    game: tuple(behaviour for behaviour in _ALL if behaviour.game == game)
    for game in sorted({behaviour.game for behaviour in _ALL})
}
"""The behaviours of each game, by its name."""
