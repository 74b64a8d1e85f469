"""How games came out and what is measured of them, in words."""

from __future__ import annotations

from tril.games.base import EndKind, Game, Rectangle, ScreenSpec
from tril.games.behaviours import Behaviour, score
from tril.games.measures import (
    ActionRate,
    Axes,
    Counted,
    GameScore,
    InRegion,
    ItemsInOrder,
    ItemsTaken,
    Measure,
    Near,
    Per,
    Unit,
)
from tril.games.measuring import measured_before
from tril.store.models import RecordingRow
from tril.store.recordings import cells_of


def counted(count: int, singular: str, plural: str = "") -> str:
    """Return a count with its noun: "1 stray", "2 strays"."""
    return f"{count} {singular if count == 1 else plural or f'{singular}s'}"


def result_of(row: RecordingRow, behaviour: Behaviour, game: Game) -> str:
    """Return how a game came out: "5 of 6 targets, 1 stray, survived all 300 steps".

    Args:
        row: The game's recording.
        behaviour: The behaviour that it is judged by.
        game: The game as the behaviour sets it.
    """
    parts = []
    scored = score(behaviour, cells_of(row))
    if scored is not None and behaviour.target is not None:
        parts.append(f"{scored.targets} of {counted(len(behaviour.target), 'target')}")
        parts.append(counted(scored.strays, "stray") if scored.strays else "no strays")
        if scored.order_errors:
            parts.append(f"{counted(scored.order_errors, 'hit')} out of order")
    elif game.items is None and row.score is not None:
        parts.append(f"score {row.score:g}")
    met = [measured.met for measured in measured_before(behaviour.measures, row.measured)]
    if asked := [value for value in met if value is not None]:
        parts.append(f"{sum(asked)} of {counted(len(asked), 'measure')} met")
    return ", ".join([*parts, _course(row, game)])


def _course(row: RecordingRow, game: Game) -> str:
    seconds = f"{row.n_frames / game.clock.frame_rate_hz:.1f} s"
    if row.end is None:
        return f"ended early after {seconds}"
    end = next((end for end in game.ends if end.name == row.end), None)
    if end is None:
        return f"{row.end.replace('_', ' ')} after {seconds}"
    if end.kind is EndKind.TIME:
        return f"survived all {counted(game.clock.n_steps(row.n_frames), 'step')}"
    return f"{end.sentence} after {seconds}"


def measure_title(measure: Measure, game: Game) -> str:
    """Return what a measure is of, with its bounds: "Score: at least 100"."""
    name, bounds = _name(measure, game), _bounds(measure)
    return f"{name}: {bounds}" if bounds else name


def _name(measure: Measure, game: Game) -> str:
    if isinstance(measure, ItemsTaken):
        taken = _capitalised(f"{game.items.plural if game.items else 'items'} taken")
        return taken if measure.cells is None else f"{taken}, of {len(measure.cells)} that count"
    if isinstance(measure, ItemsInOrder):
        return "Taken in their order"
    if isinstance(measure, InRegion):
        part = _part_of_screen(measure.area, game.screen)
        return _capitalised(f"{_thing(measure.thing, game)} in the {part}")
    if isinstance(measure, Near):
        where = {Axes.X: " sideways", Axes.Y: " in height", Axes.BOTH: ""}[measure.axes]
        first, other = _thing(measure.thing, game), _thing(measure.other, game)
        return _capitalised(f"{first} and {other} at most {measure.distance_px:g} px apart{where}")
    if isinstance(measure, ActionRate):
        what = f"Button {measure.button}" if measure.button else f"Action {measure.action}"
        return f"{what} {'held' if measure.per is Per.TIME else 'pressed'}"
    if isinstance(measure, Counted):
        titles = dict(game.counters) | {name: t.title for name, t in game.tallies.items()}
        return _capitalised(titles.get(measure.counter, measure.counter))
    if isinstance(measure, GameScore):
        return "Score"
    return {"alive": "Alive at the end", "length": "Length of the game"}[measure.kind]


def _part_of_screen(area: Rectangle, screen: ScreenSpec) -> str:
    """Return which part of the screen an area is where it ends at three edges, else its corners."""
    is_high = area.top <= 0 and area.bottom >= screen.height
    is_wide = area.left <= 0 and area.right >= screen.width
    side, share = "", 0.0
    if is_high and not is_wide:
        side = "left" if area.left <= 0 else "right" if area.right >= screen.width else ""
        share = (area.right - area.left) / screen.width
    elif is_wide and not is_high:
        side = "upper" if area.top <= 0 else "lower" if area.bottom >= screen.height else ""
        share = (area.bottom - area.top) / screen.height
    if side:
        return f"{side} {share:.0%} of the screen"
    return f"area {area.left}, {area.top} to {area.right}, {area.bottom}"


def _capitalised(text: str) -> str:
    return text[:1].upper() + text[1:]


def _thing(name: str, game: Game) -> str:
    return game.things[name].title if name in game.things else name


def _bounds(measure: Measure) -> str:
    low = None if measure.at_least is None else measure_value(measure.at_least, measure)
    high = None if measure.at_most is None else measure_value(measure.at_most, measure)
    if low and high:
        return f"between {low} and {high}"
    return f"at least {low}" if low else f"at most {high}" if high else ""


def measure_value(value: float, measure: Measure) -> str:
    """Return a value of a measure, or a mean of several, in its unit."""
    match measure.unit:
        case Unit.SHARE:
            of = "" if isinstance(measure, ItemsInOrder) else " of the time"
            return f"{value:.0%}{of}"
        case Unit.YES:
            return f"{value:.0%}"
        case Unit.SECONDS:
            return f"{value:.1f} s"
        case Unit.PER_SECOND:
            return f"{value:.1f} a second"
        case _:
            return f"{value:g}" if float(value).is_integer() else f"{value:.1f}"
