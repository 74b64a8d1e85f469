"""The points of a run's curves."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from sqlalchemy import CTE, ColumnElement, delete, func, literal, or_, select
from sqlalchemy.orm import Session

from tril.store.models import MetricRow

Conditions = tuple[ColumnElement[bool], ...]

Curve = list[tuple[int, float]]
"""(step, value) in order of steps."""

Series = dict[str, dict[str, Curve]]
"""By stage and name."""


def add(session: Session, run_id: str, stage: str, step: int, values: Mapping[str, float]) -> None:
    """Add a point to several series of a stage; merged with an earlier one at the same step."""
    conditions = (MetricRow.run_id == run_id, MetricRow.stage == stage, MetricRow.step == step)
    earlier = session.scalar(select(MetricRow).where(*conditions))
    merged = {**(earlier.values if earlier else {}), **values}
    if earlier is not None:
        session.execute(delete(MetricRow).where(*conditions))
    session.add(MetricRow(run_id=run_id, stage=stage, step=step, values=merged))
    session.flush()


def add_curves(
    session: Session, run_id: str, points: Iterable[tuple[str, int, Mapping[str, float]]]
) -> None:
    """Add the points (stage, step, values) of a run that has none yet."""
    session.add_all(
        MetricRow(run_id=run_id, stage=stage, step=step, values=dict(values))
        for stage, step, values in points
    )
    session.flush()


def drop_after(session: Session, run_id: str, stage: str, step: int) -> None:
    """Drop a stage's points beyond a step, from which the run goes on."""
    session.execute(
        delete(MetricRow).where(
            MetricRow.run_id == run_id, MetricRow.stage == stage, MetricRow.step > step
        )
    )


def curves(
    session: Session, run_id: str, stage: str, names: Sequence[str], most: int | None = None
) -> dict[str, Curve]:
    """Return the named series of a stage; one without points is empty.

    Args:
        session: The database session.
        run_id: The run.
        stage: The stage.
        names: Names of series.
        most: As for series.
    """
    values = (MetricRow.values[name].as_float() for name in names)
    conditions = (MetricRow.run_id == run_id, MetricRow.stage == stage)
    chosen = _subsampled(session, conditions, most).get(stage, conditions)
    rows = session.execute(
        select(MetricRow.step, *values).where(*chosen).order_by(MetricRow.step)
    ).all()
    return {
        name: [(row[0], row[place]) for row in rows if row[place] is not None]
        for place, name in enumerate(names, start=1)
    }


def series(
    session: Session, run_id: str, after: int = 0, most: int | None = None
) -> tuple[int, Series]:
    """Return the points that were written after the one with the id ``after``.

    A point replaces an earlier one of the same stage, name and step: those beyond a checkpoint
    are written again when a run goes on from it.

    Args:
        session: The database session.
        run_id: The run.
        after: The newest point that is known.
        most: Of more steps of a stage about as many are returned, evenly spaced, with the first
            and the last; None returns all.

    Returns:
        The newest point's id, for the next call, and the points.
    """
    conditions = (MetricRow.run_id == run_id, MetricRow.id > after)
    last = session.scalar(select(func.max(MetricRow.id)).where(*conditions))
    curves_by_stage = Series()
    for stage, stage_conditions in _subsampled(session, conditions, most).items():
        by_name = curves_by_stage.setdefault(stage, {})
        points = (
            select(MetricRow.step, MetricRow.values)
            .where(*stage_conditions)
            .order_by(MetricRow.step)
        )
        for step, values in session.execute(points):
            for name, value in values.items():
                by_name.setdefault(name, []).append((step, value))
    return last or after, curves_by_stage


def _subsampled(session: Session, selection: Conditions, most: int | None) -> dict[str, Conditions]:
    """Return conditions, by stage, that select about ``most`` points of each."""
    stages = session.execute(
        select(MetricRow.stage, func.count(), func.min(MetricRow.step), func.max(MetricRow.step))
        .where(*selection)
        .group_by(MetricRow.stage)
        .order_by(MetricRow.stage)
    )
    conditions: dict[str, Conditions] = {}
    for stage, n_points, first, last in stages:
        stage_conditions = (*selection, MetricRow.stage == stage)
        if most is not None and n_points > most:
            chosen_steps = _spaced_steps(stage_conditions, first, max(1, (last - first) // most))
            stage_conditions = (
                *stage_conditions,
                or_(MetricRow.step.in_(select(chosen_steps.c.step)), MetricRow.step == last),
            )
        conditions[stage] = stage_conditions
    return conditions


def _spaced_steps(conditions: Conditions, first: int, width: int) -> CTE:
    """Return the first step and later ones at least ``width`` apart.

    Each is looked up in the index; points between them are not read.
    """
    chosen_steps = select(literal(first).label("step")).cte("kept", recursive=True)
    next_step = (
        select(func.min(MetricRow.step))
        .where(*conditions, MetricRow.step >= chosen_steps.c.step + width)
        .scalar_subquery()
    )
    return chosen_steps.union_all(select(next_step).where(chosen_steps.c.step.is_not(None)))
