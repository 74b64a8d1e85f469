"""The points of a run's curves."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from sqlalchemy import ColumnElement, Subquery, delete, func, or_, select
from sqlalchemy.orm import Session

from tril.store.models import MetricRow

Curve = list[tuple[int, float]]
"""(step, value) in order of steps."""

Series = dict[str, dict[str, Curve]]
"""By stage and name."""


def add(session: Session, run_id: str, stage: str, step: int, values: Mapping[str, float]) -> None:
    """Add a point to several series of a stage; merged with an earlier one at the same step."""
    here = (MetricRow.run_id == run_id, MetricRow.stage == stage, MetricRow.step == step)
    earlier = session.scalar(select(MetricRow).where(*here))
    merged = {**(earlier.values if earlier else {}), **values}
    if earlier is not None:
        session.execute(delete(MetricRow).where(*here))
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


def curves(session: Session, run_id: str, stage: str, names: Sequence[str]) -> dict[str, Curve]:
    """Return the named series of a stage; one without points is empty."""
    values = (MetricRow.values[name].as_float() for name in names)
    rows = session.execute(
        select(MetricRow.step, *values)
        .where(MetricRow.run_id == run_id, MetricRow.stage == stage)
        .order_by(MetricRow.step)
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
    wanted = (MetricRow.run_id == run_id, MetricRow.id > after)
    last = session.scalar(select(func.max(MetricRow.id)).where(*wanted))
    points = select(MetricRow.stage, MetricRow.step, MetricRow.values)
    if most is None:
        points = points.where(*wanted)
    else:
        kept = _evenly_spaced(wanted, most)
        points = points.join(kept, kept.c.id == MetricRow.id)
    found = Series()
    for stage, step, values in session.execute(points.order_by(MetricRow.stage, MetricRow.step)):
        by_name = found.setdefault(stage, {})
        for name, value in values.items():
            by_name.setdefault(name, []).append((step, value))
    return last or after, found


def _evenly_spaced(wanted: Sequence[ColumnElement[bool]], most: int) -> Subquery:
    """Return the ids of about ``most`` of the wanted points of each stage."""
    numbered = (
        select(
            MetricRow.id,
            func.row_number()
            .over(partition_by=MetricRow.stage, order_by=MetricRow.step)
            .label("number"),
            func.count().over(partition_by=MetricRow.stage).label("count"),
        )
        .where(*wanted)
        .subquery()
    )
    every = (numbered.c.count + most - 1) // most
    return (
        select(numbered.c.id)
        .where(or_((numbered.c.number - 1) % every == 0, numbered.c.number == numbered.c.count))
        .subquery()
    )
