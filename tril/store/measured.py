"""Values of measures of recordings, as they are stored.

A value is stored with its recording by the key of what was measured, without bounds. It is thereby
never stale: another bound finds the same value, another measure none.
"""

from __future__ import annotations

from collections.abc import Mapping

from sqlalchemy import select
from sqlalchemy.orm import Session

from tril.games.measures import Measure
from tril.games.measuring import Values
from tril.store import rankings
from tril.store.behaviours import as_behaviour
from tril.store.changes import note_change, note_recordings
from tril.store.models import BehaviourRow, RecordingRow, RecordingState, Verification


def unmeasured(session: Session) -> dict[int, tuple[Measure, ...]]:
    """Return the missing measures of each recording, by its id, newest first.

    Verified recordings count, those of runs and borrowed ones included.
    """
    missing: dict[int, dict[str, Measure]] = {}
    for behaviour in session.scalars(
        select(BehaviourRow).where(BehaviourRow.deleted_at.is_(None)).order_by(BehaviourRow.id)
    ):
        measures = as_behaviour(behaviour).measures
        if not measures:
            continue
        query = select(RecordingRow.id, RecordingRow.measured).where(
            (RecordingRow.behaviour_id == behaviour.id)
            | RecordingRow.id.in_(rankings.borrowed_ids(behaviour.id)),
            RecordingRow.game == behaviour.game,
            RecordingRow.state != RecordingState.PLAYING,
            RecordingRow.verification == Verification.VERIFIED,
            RecordingRow.deleted_at.is_(None),
        )
        for recording_id, values in session.execute(query):
            lacking = {measure.key: measure for measure in measures if measure.key not in values}
            if lacking:
                missing[recording_id] = lacking | missing.get(recording_id, {})
    return {key: tuple(lacking.values()) for key, lacking in sorted(missing.items(), reverse=True)}


def store(session: Session, values: Mapping[int, Values]) -> None:
    """Add values of recordings, by their ids, to those that are stored."""
    rows = list(session.scalars(select(RecordingRow).where(RecordingRow.id.in_(values))))
    for row in rows:
        row.measured = {**row.measured, **values[row.id]}
    note_recordings(session, rows)
    # The pages of runs show the values of their games.
    for run_id in sorted({row.run_id for row in rows if row.run_id is not None}):
        note_change(session, "run", run_id)
