"""Behaviours and their checklists."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from typing import Annotated

from fastapi import APIRouter, Query
from sqlalchemy.orm import Session

from server.api.schemas.base import Cell
from server.api.schemas.behaviours import (
    Behaviour,
    BehaviourNew,
    BehaviourUpdate,
    Checklist,
    PlannedDemonstration,
    Settings,
)
from server.api.schemas.measures import Measure, measures_of
from server.dependencies import (
    MAX_ID,
    MAX_LISTED,
    BehaviourId,
    PageLimit,
    ReadSession,
    Who,
    WriteSession,
)
from server.web.permissions import for_reader
from server.web.problems import CONFLICT, NOT_FOUND
from tril.demonstrators import GameOutcome, example_plans, match_plans
from tril.errors import Invalid
from tril.games.settings import GameSettings
from tril.store import behaviours, library
from tril.store.database import parse_json
from tril.store.models import BehaviourRow, RecordingState, Verification

router = APIRouter(prefix="/behaviours", tags=["behaviours"])


@router.get("", responses=NOT_FOUND)
def list_behaviours(
    session: ReadSession,
    identity: Who,
    after: Annotated[
        int | None,
        Query(ge=1, le=MAX_ID, description="Only those that follow this one in the list."),
    ] = None,
    limit: PageLimit = MAX_LISTED,
) -> list[Behaviour]:
    """Return the behaviours that one may play, the built-in ones first.

    At most 200 are returned: ask for further ones with ``after``.
    """
    ids = identity.behaviour_ids if identity.is_participant else None
    rows = behaviours.listing(session, ids=ids, after=after, limit=limit)
    if identity.is_participant:
        return [for_reader(identity, _view(row, {})) for row in rows]
    counts = behaviours.counts(session)
    return [_view(row, counts) for row in rows]


@router.post("", status_code=201, responses=CONFLICT)
def create_behaviour(session: WriteSession, new: BehaviourNew) -> Behaviour:
    """Add a behaviour."""
    row = behaviours.create(
        session,
        new.name,
        new.description,
        _cells(new.target),
        new.ordered,
        game=new.game,
        settings=GameSettings.from_json(new.settings.model_dump()),
        measures=measures_of(new.measures),
    )
    return _with_counts(session, row)


@router.get("/{behaviour_id}/checklist", responses=NOT_FOUND)
def get_checklist(session: ReadSession, identity: Who, behaviour_id: BehaviourId) -> Checklist:
    """Return the demonstrations that exemplify a behaviour, and which of them exist.

    The plans are the demonstrator's. Any verified recording counts, whoever played it, that hits
    what a plan asks for and ends without the player's death; of a participant, their own.
    """
    behaviour = behaviours.as_behaviour(behaviours.get(session, behaviour_id))
    try:
        plans = example_plans(behaviour)
    except Invalid as error:
        return Checklist(planned=[], note=str(error))
    brief = library.brief(session, behaviour_id, only_of=identity.visible_player_id)
    games = {
        entry.id: _played(entry)
        for entry in brief.entries
        if entry.verification == Verification.VERIFIED and entry.state != RecordingState.FINISHED
    }
    ticks = match_plans(plans, games)
    numbers = {entry.id: entry.number for entry in brief.entries}
    return Checklist(
        planned=[
            PlannedDemonstration.of(
                plan,
                recording_id=ticks[plan.number],
                recording_number=numbers.get(ticks[plan.number] or 0),
            )
            for plan in plans
        ],
        note="",
    )


@router.get("/{behaviour_id}", responses=NOT_FOUND)
def get_behaviour(session: ReadSession, identity: Who, behaviour_id: BehaviourId) -> Behaviour:
    """Return one behaviour."""
    return for_reader(identity, _with_counts(session, behaviours.get(session, behaviour_id)))


@router.patch("/{behaviour_id}", responses=NOT_FOUND | CONFLICT)
def update_behaviour(
    session: WriteSession, identity: Who, behaviour_id: BehaviourId, update: BehaviourUpdate
) -> Behaviour:
    """Change a behaviour; omitted fields stay."""
    row = behaviours.get(session, behaviour_id)
    sent_fields = update.model_fields_set
    current = behaviours.as_behaviour(row)
    behaviours.update(
        session,
        row,
        name=row.name if update.name is None else update.name,
        description=row.description if update.description is None else update.description,
        target=_cells(update.target) if "target" in sent_fields else current.target,
        ordered=row.ordered if update.ordered is None else update.ordered,
        player_id=identity.player_id,
        settings=None
        if update.settings is None
        else GameSettings.from_json(update.settings.model_dump()),
        measures=None if update.measures is None else measures_of(update.measures),
    )
    return _with_counts(session, row)


@router.delete("/{behaviour_id}", status_code=204, responses=NOT_FOUND | CONFLICT)
def delete_behaviour(session: WriteSession, identity: Who, behaviour_id: BehaviourId) -> None:
    """Delete a behaviour; it can be restored."""
    behaviours.delete(session, behaviours.get(session, behaviour_id), identity.player_id)


@router.post("/{behaviour_id}/restore", responses=NOT_FOUND | CONFLICT)
def restore_behaviour(session: WriteSession, identity: Who, behaviour_id: BehaviourId) -> Behaviour:
    """Restore a deleted behaviour, with everything it had."""
    return _with_counts(session, behaviours.restore(session, behaviour_id, identity.player_id))


def _played(entry: library.Entry) -> GameOutcome:
    return GameOutcome(
        hits=tuple((row, column) for row, column, _ in parse_json(entry.taken)),
        end=entry.end,
        n_frames=entry.n_frames,
    )


def _with_counts(session: Session, row: BehaviourRow) -> Behaviour:
    return _view(row, behaviours.counts(session, row.id))


def _view(row: BehaviourRow, counts: Mapping[int, behaviours.Counts]) -> Behaviour:
    behaviour = behaviours.as_behaviour(row)
    counted = counts.get(row.id, behaviours.Counts())
    settings = Settings.model_validate(behaviour.settings.to_json())
    return Behaviour.of(
        row,
        target=behaviour.target,
        settings=settings,
        measures=[Measure.of_measure(measure) for measure in behaviour.measures],
        **asdict(counted),
    )


def _cells(target: list[Cell] | None) -> tuple[Cell, ...] | None:
    return None if target is None else tuple(target)
