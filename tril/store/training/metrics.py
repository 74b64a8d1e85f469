"""The points of a run's curves."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from sqlalchemy import delete, select
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


def series(session: Session, run_id: str, after: int = 0) -> tuple[int, Series]:
    """Return the points that were written after the one with the id ``after``.

    A point replaces an earlier one of the same stage, name and step: those beyond a checkpoint
    are written again when a run goes on from it.

    Returns:
        The newest point's id, for the next call, and the points.
    """
    rows = session.scalars(
        select(MetricRow)
        .where(MetricRow.run_id == run_id, MetricRow.id > after)
        .order_by(MetricRow.stage, MetricRow.step)
    )
    last, found = after, Series()
    for row in rows:
        last = max(last, row.id)
        by_name = found.setdefault(row.stage, {})
        for name, value in row.values.items():
            by_name.setdefault(name, []).append((row.step, value))
    return last, found
