"""The plans of a behaviour's example demonstrations, each with a rule for its hits.

The twelve follow appendix C of the thesis, best first: all targets, gradually fewer, none, then
wrong aliens, from one to many. No alien outside a plan is hit.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from tril.errors import Invalid
from tril.games.base import Cell
from tril.games.behaviours import Behaviour
from tril.games.space_invaders.behaviours import ROW_1
from tril.games.space_invaders.ends import EndReason
from tril.games.space_invaders.memory import COLUMNS, ROWS

N_DEMONSTRATIONS = 12
_MAX_GRADUAL = 6
_MAX_TARGETS = 14
"""More can't be hit reliably in 300 steps."""

# Appendix C: columns (from 1) of the wrong aliens in demonstrations 8 to 12, by the taught column.
_WRONG_COLUMNS = {
    1: ((2,), (2,), (2, 3), (2, 3, 4), (2, 3, 4)),
    2: ((1,), (1,), (1, 3), (1, 3, 4), (1, 3, 4)),
    3: ((2,), (2,), (2, 4), (1, 2, 4), (1, 2, 4)),
    4: ((3,), (3,), (3, 5), (2, 3, 5), (2, 3, 5)),
    5: ((4,), (4,), (3, 4), (2, 3, 4), (2, 3, 4)),
    6: ((5,), (5,), (3, 4), (2, 3, 4, 5), (2, 3, 4, 5)),
}
# Numbers of aliens for "one", "several", "several", "several" and "many" of appendix C.
_WRONG_COUNTS = ((1, 1), (3, 4), (5, 6), (7, 8), (11, 13))
_NEARNESS = 1.5
"""Exponential decay, per column of distance, of the probability to be shot at next."""
_MAX_DRAWS = 10_000
_TO_THE_END = frozenset({EndReason.STEPS, EndReason.CLEARED})


@dataclass(frozen=True)
class DemonstrationPlan:
    """A demonstration to make and the rule for its hits.

    Attributes:
        number: Rank among the demonstrations, 1 being the best.
        description: Description for people.
        allowed: The only cells that may be hit.
        min_hits: Minimum number of hits.
        max_hits: Maximum number of hits.
        each_of: Sets of cells; at least one cell of each is hit.
        sequence: The exact hits in order, None for any order.
        out_of_order: Whether the hits must not go from left to right.
    """

    number: int
    description: str
    allowed: frozenset[Cell]
    min_hits: int
    max_hits: int
    each_of: tuple[frozenset[Cell], ...] = ()
    sequence: tuple[Cell, ...] | None = None
    out_of_order: bool = False


@dataclass(frozen=True)
class GameOutcome:
    """The outcome of a game.

    Attributes:
        hits: The aliens hit as (row, column), in order of time.
        end: Why it ended, None if it was quit.
        n_frames: Number of frames played.
    """

    hits: tuple[Cell, ...]
    end: str | None
    n_frames: int


def plan_violation(plan: DemonstrationPlan, game: GameOutcome) -> str | None:
    """Return why a game doesn't fulfil a plan, None if it does.

    The game has to follow the plan's rule and to be survived for 300 steps or until no alien is
    left: a shorter one doesn't show which aliens would have been left alone.
    """
    if game.end not in _TO_THE_END:
        return f"The game ended at frame {game.n_frames}: {game.end or 'quit'}."
    return rule_violation(plan, game.hits)


def rule_violation(plan: DemonstrationPlan, hits: Sequence[Cell]) -> str | None:
    """Return why hits, (row, column) in order of time, break a plan's rule, None if they don't."""
    wrong = [cell for cell in hits if cell not in plan.allowed]
    if wrong:
        return f"It hits {_cells(wrong)}, which the plan leaves alone."
    if not plan.min_hits <= len(hits) <= plan.max_hits:
        return f"It hits {len(hits)} aliens instead of {_span(plan.min_hits, plan.max_hits)}."
    if plan.sequence is not None and tuple(hits) != plan.sequence:
        return f"It hits {_cells(hits)} instead of {_cells(plan.sequence)}, in this order."
    for group in plan.each_of:
        if not group.intersection(hits):
            return f"It hits none of {_cells(sorted(group))}."
    if plan.out_of_order and list(hits) == sorted(hits, key=lambda cell: cell[1]):
        return "It hits the aliens from left to right, which the plan rules out."
    return None


def tolerance_violation(plan: DemonstrationPlan, hits: Sequence[Cell]) -> str | None:
    """Return why hits deviate too far from a plan for a human-like game, None if they don't.

    The number of hits may be a quarter lower than planned or one higher, one hit may be outside the
    plan, and the order is free.
    """
    wrong = [cell for cell in hits if cell not in plan.allowed]
    if len(wrong) > 1:
        return f"It hits {_cells(wrong)}, which the plan leaves alone."
    min_hits = plan.min_hits - max(1, plan.min_hits // 4)
    if not min_hits <= len(hits) <= plan.max_hits + 1:
        return f"It hits {len(hits)} aliens; the plan has {_span(plan.min_hits, plan.max_hits)}."
    return None


def best_effort_violation(plan: DemonstrationPlan, hits: Sequence[Cell]) -> str | None:
    """Return why hits are no good attempt at all targets, None if they are.

    A third of the targets may be missed and two other aliens hit; the order is free.
    """
    n_wrong = sum(cell not in plan.allowed for cell in hits)
    n_targets = len(hits) - n_wrong
    if 3 * n_targets < 2 * plan.min_hits or n_wrong > 2:
        return f"It hits {n_targets} of {plan.min_hits} targets and {n_wrong} other aliens."
    return None


def example_plans(behaviour: Behaviour) -> tuple[DemonstrationPlan, ...]:
    """Return the twelve plans of a behaviour's example, best first.

    Raises:
        Invalid: The behaviour has no target cells, too many, or ones behind non-target aliens.
    """
    target = _check_target(behaviour)
    plans = [*_gradual(behaviour, target)]
    plans.append(DemonstrationPlan(len(plans) + 1, "No alien is hit", frozenset(), 0, 0))
    n_wrong = N_DEMONSTRATIONS - len(plans)
    if column := _whole_column(behaviour, target):
        plans += _wrong_columns(len(plans) + 1, _WRONG_COLUMNS[column], _WRONG_COUNTS)
    elif behaviour.ordered and target == ROW_1.target:
        plans += _wrong_in_row_1(len(plans) + 1)
    elif free := _free_columns(target):
        groups, counts = _graded(free, n_wrong)
        plans += _wrong_columns(len(plans) + 1, groups, counts)
    else:
        plans += _wrong_anywhere(len(plans) + 1, target, n_wrong)
    return tuple(plans)


def draw_hits(
    plan: DemonstrationPlan, rng: np.random.Generator, first_column: int = 0
) -> tuple[Cell, ...]:
    """Draw hits that fulfil a plan, in an order in which they can be shot.

    The next alien tends to be near the last one, as when people play, and the first one near
    ``first_column``.

    Raises:
        Invalid: No such order was found; the plan's rule contradicts itself.
    """
    if plan.sequence is not None:
        return plan.sequence
    for _ in range(_MAX_DRAWS):
        n_hits = int(rng.integers(plan.min_hits, plan.max_hits + 1))
        hits: list[Cell] = []
        while len(hits) < n_hits and (open_cells := _open_cells(plan.allowed, hits)):
            columns = np.array([column for _, column in open_cells])
            weights = np.exp(-_NEARNESS * abs(columns - (hits[-1][1] if hits else first_column)))
            hits.append(open_cells[rng.choice(len(open_cells), p=weights / weights.sum())])
        if rule_violation(plan, hits) is None:
            return tuple(hits)
    raise Invalid(f"No order of hits fulfils the plan {plan.description!r}.")


def _open_cells(allowed: Iterable[Cell], hits: Sequence[Cell]) -> list[Cell]:
    """Return the allowed cells below which every alien has been hit."""
    height = Counter(column for _, column in hits)
    return sorted((row, column) for row, column in allowed if height[column] == row)


def _check_target(behaviour: Behaviour) -> tuple[Cell, ...]:
    if behaviour.target is None:
        raise Invalid(
            f"{behaviour.name} has no target aliens, so the demonstrator can't show it."
            " Play its demonstrations yourself, or choose a behaviour with target aliens."
        )
    target = behaviour.target if behaviour.ordered else tuple(sorted(behaviour.target))
    if len(target) > _MAX_TARGETS:
        raise Invalid(
            f"{behaviour.name} has {len(target)} target aliens; the demonstrator can hit at most"
            f" {_MAX_TARGETS} in a game. Pick fewer, or play its demonstrations yourself."
        )
    hit: list[Cell] = []
    for cell in target:
        if cell not in _open_cells([cell], hit):
            raise Invalid(
                f"{_cells([cell])} of {behaviour.name} stands behind aliens that are not to be hit"
                " before it, and the demonstrator can't shoot past them. Add the cells below it"
                f"{', in order from the bottom' if behaviour.ordered else ''}, or play its"
                " demonstrations yourself."
            )
        hit.append(cell)
    return target


def _gradual(behaviour: Behaviour, target: tuple[Cell, ...]) -> list[DemonstrationPlan]:
    """Return plans of all targets, then fewer, in at most six even stages down to one."""
    n_stages = min(len(target), _MAX_GRADUAL)
    counts = np.linspace(len(target), 1, n_stages).round().astype(int).tolist()
    ending = ", in order" if behaviour.ordered and len(target) > 1 else ""
    return [
        DemonstrationPlan(
            number,
            f"{count} of {len(target)} target aliens{ending}, no other",
            frozenset(target),
            count,
            count,
            sequence=target[:count] if behaviour.ordered else None,
        )
        for number, count in enumerate(counts, start=1)
    ]


def _column_cells(column: int) -> frozenset[Cell]:
    """Return the cells of a column, counted from 1."""
    return frozenset((row, column - 1) for row in range(ROWS))


def _whole_column(behaviour: Behaviour, target: tuple[Cell, ...]) -> int | None:
    """Return the column, from 1, that the targets make up, None if they don't."""
    column = target[0][1] + 1
    return column if frozenset(target) == _column_cells(column) else None


def _wrong_columns(
    first: int, groups: Sequence[Sequence[int]], counts: Sequence[tuple[int, int]]
) -> list[DemonstrationPlan]:
    """Return plans that hit at least one alien in each of some wrong columns (from 1)."""
    return [
        DemonstrationPlan(
            number,
            f"{_amount(*count)} in {_columns(columns)}, no other",
            frozenset[Cell]().union(*map(_column_cells, columns)),
            *count,
            each_of=tuple(map(_column_cells, columns)),
        )
        for number, (columns, count) in enumerate(zip(groups, counts, strict=True), start=first)
    ]


def _wrong_in_row_1(first: int) -> list[DemonstrationPlan]:
    """Appendix C.7: the bottom row out of order, then increasingly many in the rows above."""
    rows = [frozenset((row, column) for column in range(COLUMNS)) for row in range(ROWS)]
    middle = frozenset((0, column) for column in range(1, COLUMNS - 1))
    centre = frozenset((0, column) for column in (COLUMNS // 2 - 1, COLUMNS // 2))
    low = rows[0] | rows[1] | rows[2]
    single, several, many, even_more, very_many = _WRONG_COUNTS
    above = low - rows[0]
    return [
        DemonstrationPlan(first, "One alien in the middle of row 1", centre, *single),
        DemonstrationPlan(
            first + 1, "Several in the middle of row 1, out of order", middle, *several,
            out_of_order=True,
        ),
        DemonstrationPlan(
            first + 2, "Several in and above row 1", low, *many,
            each_of=(rows[0], above), out_of_order=True,
        ),
        DemonstrationPlan(
            first + 3, "Even more in and above row 1", low, *even_more,
            each_of=(rows[0], above), out_of_order=True,
        ),
        DemonstrationPlan(
            first + 4, "Many in several rows", low | rows[3], *very_many,
            each_of=(rows[0], rows[1], rows[2]), out_of_order=True,
        ),
    ]  # fmt: skip


def _free_columns(target: tuple[Cell, ...]) -> list[int]:
    """Return the columns (from 1) without a target, nearest to the targets first."""
    target_columns = {column + 1 for _, column in target}
    free = [column for column in range(1, COLUMNS + 1) if column not in target_columns]
    return sorted(free, key=lambda column: min(abs(column - target) for target in target_columns))


def _graded(
    columns: Sequence[int], n_plans: int
) -> tuple[list[tuple[int, ...]], list[tuple[int, int]]]:
    """Return columns and (min, max) hits for n_plans wrong plans, from one alien to many."""
    at = np.linspace(0, len(_WRONG_COUNTS) - 1, n_plans)
    stages = np.arange(len(_WRONG_COUNTS))
    width = np.interp(at, stages, [1, 1, 2, 3, 3]).round().astype(int)
    room = min(len(columns), 3) * ROWS
    groups, counts = [], []
    for stage, n_columns in zip(at, width.tolist(), strict=True):
        group = tuple(sorted(columns[:n_columns]))
        span = [
            min(round(float(np.interp(stage, stages, bound))), len(group) * ROWS, room)
            for bound in zip(*_WRONG_COUNTS, strict=True)
        ]
        groups.append(group)
        counts.append((max(span[0], len(group)), max(span[1], len(group))))
    return groups, counts


def _wrong_anywhere(first: int, target: tuple[Cell, ...], n_plans: int) -> list[DemonstrationPlan]:
    """Return wrong plans for targets in all columns: strays above them, from one to many."""
    everywhere = frozenset((row, column) for row in range(ROWS) for column in range(COLUMNS))
    strays = everywhere - frozenset(target)
    lowest = min(row for row, _ in strays)
    nearest = frozenset(cell for cell in strays if cell[0] <= lowest + 1)
    _, counts = _graded(range(1, COLUMNS + 1), n_plans)
    return [
        DemonstrationPlan(
            number,
            f"{_amount(min_hits + lowest, max_hits + lowest)}, strays among them",
            everywhere,
            min_hits + lowest,
            max_hits + lowest,
            each_of=(nearest,),
        )
        for number, (min_hits, max_hits) in enumerate(counts, start=first)
    ]


def _amount(min_hits: int, max_hits: int) -> str:
    if max_hits == 1:
        return "One alien"
    return f"{'Many' if min_hits >= 10 else 'Several'} aliens ({_span(min_hits, max_hits)})"


def _span(min_hits: int, max_hits: int) -> str:
    return str(min_hits) if min_hits == max_hits else f"{min_hits} to {max_hits}"


def _columns(columns: Sequence[int]) -> str:
    return f"column{'s' if len(columns) > 1 else ''} {', '.join(map(str, columns))}"


def _cells(cells: Iterable[Cell]) -> str:
    return ", ".join(f"row {row + 1} of column {column + 1}" for row, column in cells) or "none"
