"""Rows to what goes over HTTP, for the things that several resources show."""

from __future__ import annotations

from collections.abc import Iterable

from sqlalchemy.orm import Session

from server.api.schemas.recordings import Branch, Hit, Latency, Recording
from server.play.conditions import PlayConditions
from server.replay_cache import version_of
from tril.behaviours import Behaviour, score
from tril.game.episode import evaluation_number
from tril.game.space_invaders import COLUMNS
from tril.store import behaviours, players, rankings
from tril.store.models import BehaviourRow, RecordingRow
from tril.store.recordings import as_recording, hits_of


def parent_of(row: RecordingRow) -> Branch | None:
    """Show which recording this one goes on from."""
    if row.parent_id is None or row.parent_frame is None:
        return None
    return Branch(recording_id=row.parent_id, frame=row.parent_frame)


class RecordingViews:
    """Shows recordings, asking the database once for what they share.

    Args:
        session: The transaction to ask in.
    """

    def __init__(self, session: Session) -> None:
        self._session = session
        self._names = players.names(session)
        self._behaviours: dict[int, Behaviour] = {}
        self._ranked: dict[int, frozenset[int]] = {}

    def all(self, rows: Iterable[RecordingRow]) -> list[Recording]:
        """Show recordings in the order given."""
        return [self.one(row) for row in rows]

    def one(self, row: RecordingRow) -> Recording:
        """Show a recording."""
        behaviour = self._behaviour(row.behaviour_id)
        hits = hits_of(row)
        cells = tuple((hit.row, hit.column) for hit in hits)
        found = score(behaviour, cells)
        target = None if behaviour.target is None else set(behaviour.target)
        recording = as_recording(row)
        version = version_of(recording)
        conditions = PlayConditions.from_conditions(row.conditions)
        return Recording(
            id=row.id,
            behaviour_id=row.behaviour_id,
            run_id=row.run_id,
            source=row.source,
            player=None if row.player_id is None else self._names.get(row.player_id),
            state=row.state,
            verification=row.verification,
            verification_note=row.verification_note,
            idle_frames=row.idle_frames,
            evaluation_start=evaluation_number(recording.start),
            n_frames=row.n_frames,
            n_steps=recording.n_steps,
            end=row.end,
            hits=[
                Hit(
                    row=hit.row,
                    column=hit.column,
                    frame=hit.frame,
                    on_target=None if target is None else (hit.row, hit.column) in target,
                )
                for hit in hits
            ],
            hits_per_column=[
                sum(column == hit_column for _, hit_column in cells) for column in range(COLUMNS)
            ],
            targets=None if found is None else found.targets,
            strays=None if found is None else found.strays,
            order_errors=None if found is None else found.order_errors,
            shots=row.shots,
            latency=None
            if conditions is None
            else Latency.model_validate(conditions.latency(row.n_frames)),
            slowest_percent=None
            if conditions is None
            else conditions.slowest_percent(row.n_frames),
            single_steps=None if conditions is None else len(conditions.single_steps),
            parent=parent_of(row),
            perfect=row.perfect,
            notes=row.notes,
            ranked=row.id in self._ranked_of(row.behaviour_id),
            thumbnail_url=f"/api/recordings/{row.id}/thumbnail.png?v={version}",
            frames_url=f"/api/recordings/{row.id}/frames?v={version}",
            created_at=row.created_at,
            deleted=row.deleted_at is not None,
        )

    def _behaviour(self, behaviour_id: int) -> Behaviour:
        # A deleted behaviour's recordings are still results of its trainings.
        if behaviour_id not in self._behaviours:
            row = self._session.get_one(BehaviourRow, behaviour_id)
            self._behaviours[behaviour_id] = behaviours.as_behaviour(row)
        return self._behaviours[behaviour_id]

    def _ranked_of(self, behaviour_id: int) -> frozenset[int]:
        if behaviour_id not in self._ranked:
            row = rankings.current(self._session, behaviour_id)
            self._ranked[behaviour_id] = frozenset(rankings.as_ranking(row).items)
        return self._ranked[behaviour_id]
