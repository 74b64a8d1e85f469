"""The demonstrations of a run."""

from __future__ import annotations

from sqlalchemy.orm import Session

from tril.games.behaviours import score
from tril.store import behaviours, recordings
from tril.store.models import BehaviourRow, RecordingRow, RunRow
from tril.store.recordings import cells_of


def best_demonstration(session: Session, run: RunRow) -> RecordingRow | None:
    """Return the demonstration that is worth most, and of several a best effort, ranked highest.

    It need not be at the top, since the ranking may be wrong there. Without a target it is a best
    effort, or else at the top.

    Returns:
        None if the run has none.
    """
    if run.snapshot is None:
        return None
    perfect = set(run.snapshot.perfect)
    # Sorting is stable: within both kinds the ranked ones stay first, from best to worst.
    ids = sorted(dict.fromkeys(run.snapshot.recordings), key=lambda one: one not in perfect)
    rows = recordings.by_ids(session, ids)
    found_rows = [rows[recording_id] for recording_id in ids if recording_id in rows]
    behaviour = behaviours.as_behaviour(session.get_one(BehaviourRow, run.behaviour_id))

    def worth(row: RecordingRow) -> int:
        outcome = score(behaviour, cells_of(row))
        return 0 if outcome is None else outcome.worth

    return max(found_rows, key=worth, default=None)
