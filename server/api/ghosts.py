"""The best demonstration's cannon, to be drawn over a game."""

from __future__ import annotations

from fastapi import APIRouter, Request
from sqlalchemy.orm import Session

from server.api.schemas import Ghost
from server.dependencies import BehaviourId, services_of
from server.ghosts import cannon_track
from server.web.problems import NOT_FOUND
from tril.store import behaviours, rankings, recordings
from tril.store.models import RecordingRow

router = APIRouter(tags=["behaviours"])


@router.get("/behaviours/{behaviour_id}/ghost", responses=NOT_FOUND)
def get_ghost(request: Request, behaviour_id: BehaviourId) -> Ghost | None:
    """Return where the cannon of the best demonstration stood in every frame.

    The best one is the first of the ranking's best tier, without a ranking the newest one that is
    marked as perfect; null if there is neither.
    """
    services = services_of(request)
    with services.database.reading() as session:
        behaviours.get(session, behaviour_id)
        row = _best(session, behaviour_id)
        if row is None:
            return None
        recording, key, source = recordings.as_recording(row), row.id, row.source
    track = cannon_track(services.derived.memory(recording), recording.start.difficulty)
    return Ghost(
        recording_id=key,
        source=source,
        lefts=list(track.lefts),
        top=track.top,
        width=track.width,
        height=track.height,
    )


def _best(session: Session, behaviour_id: int) -> RecordingRow | None:
    ranking = rankings.as_ranking(rankings.current(session, behaviour_id))
    if ranking.tiers:
        return recordings.get(session, ranking.tiers[0][0])
    perfect = recordings.perfect_ids(session, behaviour_id)
    return recordings.get(session, perfect[-1]) if perfect else None
