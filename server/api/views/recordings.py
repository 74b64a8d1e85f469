"""Recordings as several resources show them."""

from __future__ import annotations

from collections.abc import Iterable

from sqlalchemy.orm import Session

from server.api.schemas.measures import MeasuredValue
from server.api.schemas.recordings import BegunBy, Branch, Hit, Recording
from server.play.conditions import PlayConditions
from server.replay_cache import version_of
from server.web.permissions import for_reader
from tril.games import game_named
from tril.games.behaviours import Behaviour, score
from tril.games.measuring import measured_before
from tril.store import behaviours, players, rankings
from tril.store.access.credentials import Identity
from tril.store.models import BehaviourRow, RecordingRow
from tril.store.recordings import as_recording, own_ids, taken_of


def parent_of(session: Session, who: Identity, row: RecordingRow) -> Branch | None:
    """Show the recording that this one continues; not another person's to a participant."""
    if row.parent_id is None or row.parent_frame is None:
        return None
    if who.is_participant and not own_ids(
        session, who.player_id, who.behaviour_ids, [row.parent_id]
    ):
        return None
    number = session.get_one(RecordingRow, row.parent_id).number
    return Branch(recording_id=row.parent_id, number=number, frame=row.parent_frame)


def _begun_by(conditions: PlayConditions | None) -> BegunBy | None:
    if conditions is None or conditions.begun_by is None:
        return None
    return BegunBy.of(conditions.begun_by)


class RecordingViews:
    """Shows recordings; what they share is queried once.

    Args:
        session: The transaction.
        who: Who reads them.
        behaviour_id: The behaviour that they are shown for, which has borrowed those of others;
            None shows each for its own.
    """

    def __init__(self, session: Session, who: Identity, behaviour_id: int | None = None) -> None:
        self._session = session
        self._who = who
        self._behaviour_id = behaviour_id
        self._names = players.names(session)
        self._behaviours: dict[int, Behaviour] = {}
        self._ranked: dict[int, frozenset[int]] = {}
        self._borrowed: dict[int, frozenset[int]] = {}

    def all(self, rows: Iterable[RecordingRow]) -> list[Recording]:
        """Show recordings in the given order."""
        return [self.view(row) for row in rows]

    def view(self, row: RecordingRow) -> Recording:
        """Show a recording."""
        shown_for = self._behaviour_id or row.behaviour_id
        borrowed = shown_for != row.behaviour_id or row.id in self._borrowed_by(shown_for)
        taken = taken_of(row)
        cells = tuple(one.cell for one in taken)
        columns = [column for _, column in cells]
        items = game_named(row.game).items
        n_columns = 0 if items is None else items.columns
        behaviour = self._behaviour(shown_for)
        found = score(behaviour, cells)
        recording = as_recording(row)
        version = version_of(recording)
        conditions = PlayConditions.from_conditions(row.conditions)
        played = row.n_frames
        shown = Recording.of(
            row,
            behaviour_name=self._behaviour(row.behaviour_id).name,
            borrowed=borrowed,
            perfect=row.perfect and not borrowed,
            player=self._names.get(row.player_id or 0),
            evaluation_start=recording.game.starts.evaluation_number(recording.start),
            n_steps=recording.n_steps,
            hits=[
                Hit(
                    row=one.row,
                    column=one.column,
                    frame=one.frame,
                    on_target=behaviour.target and one.cell in behaviour.target,
                )
                for one in taken
            ],
            hits_per_column=[columns.count(column) for column in range(n_columns)],
            targets=None if found is None else found.targets,
            strays=None if found is None else found.strays,
            order_errors=None if found is None else found.order_errors,
            measured=[
                MeasuredValue.of_measured(one)
                for one in measured_before(behaviour.measures, row.measured)
            ],
            latency=None if conditions is None else conditions.latency(played),
            slowest_percent=None if conditions is None else conditions.slowest_percent(played),
            single_steps=None if conditions is None else len(conditions.single_steps),
            parent=parent_of(self._session, self._who, row),
            begun_by=_begun_by(conditions),
            ranked=row.id in self._ranked_of(shown_for),
            strip_url=f"/api/recordings/{row.id}/strip.webp?v={version}",
            frames_url=f"/api/recordings/{row.id}/frames?v={version}",
            deleted=row.deleted_at is not None,
        )
        return for_reader(self._who, shown)

    def _behaviour(self, behaviour_id: int) -> Behaviour:
        # The recordings of a deleted behaviour remain results of its trainings.
        if behaviour_id not in self._behaviours:
            row = self._session.get_one(BehaviourRow, behaviour_id)
            self._behaviours[behaviour_id] = behaviours.as_behaviour(row)
        return self._behaviours[behaviour_id]

    def _borrowed_by(self, behaviour_id: int) -> frozenset[int]:
        if behaviour_id not in self._borrowed:
            ids = self._session.scalars(rankings.borrowed_ids(behaviour_id))
            self._borrowed[behaviour_id] = frozenset(ids)
        return self._borrowed[behaviour_id]

    def _ranked_of(self, behaviour_id: int) -> frozenset[int]:
        if behaviour_id not in self._ranked:
            row = rankings.current(self._session, behaviour_id)
            self._ranked[behaviour_id] = frozenset(rankings.as_ranking(row).items)
        return self._ranked[behaviour_id]
