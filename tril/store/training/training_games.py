"""The games that an imitator plays while it still learns, kept so that a person can rank them."""

from __future__ import annotations

from sqlalchemy import select
from sqlalchemy.orm import Session

from tril.analysis.variety import N_PROPOSED
from tril.store.models import EvaluationRow, RecordingRow

STEPS = "steps"
"""In a recording's conditions: training steps behind the policy that played it."""


def latest(session: Session, run_id: str) -> tuple[int, list[RecordingRow]]:
    """Return the games of a run's newest snapshot, and its training steps.

    Returns:
        Steps and games; 0 and none if no snapshot has been taken.
    """
    evaluated = select(EvaluationRow.recording_id).where(EvaluationRow.run_id == run_id)
    query = (
        select(RecordingRow)
        .where(RecordingRow.run_id == run_id, RecordingRow.id.not_in(evaluated))
        .order_by(RecordingRow.id.desc())
        .limit(N_PROPOSED)
    )
    rows = [row for row in session.scalars(query) if STEPS in row.conditions]
    if not rows:
        return 0, []
    steps: int = rows[0].conditions[STEPS]
    return steps, [row for row in reversed(rows) if row.conditions[STEPS] == steps]
