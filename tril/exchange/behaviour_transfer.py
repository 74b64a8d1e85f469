"""Whole behaviours into a file and out of it: what is taught, recordings, every ranking revision.

docs/behaviour-format.md describes the file.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from sqlalchemy.orm import Session

from tril.behaviours import Behaviour
from tril.exchange.formats import (
    BEHAVIOUR_FORMAT,
    BEHAVIOUR_VERSION,
    BehaviourObject,
    BehaviourRefused,
    Exchanged,
    NumberedRecording,
    from_exchange,
    parse_behaviour,
)
from tril.exchange.recording_transfer import as_exchange
from tril.game.console import Console
from tril.game.space_invaders import GAME
from tril.recording import RecordingRefused
from tril.store import behaviours, players, rankings, recordings
from tril.store.database import Database
from tril.store.models import (
    BehaviourRow,
    RankingRow,
    RecordingRow,
    RecordingState,
    Source,
    Verification,
    now,
)


@dataclass(frozen=True)
class BehaviourImported:
    """What became of a behaviour's file.

    Attributes:
        slug: The behaviour that holds it now.
        was_there: Whether that came ready and was empty; else it is new.
        n_recordings: Recordings added, deleted ones included.
        n_revisions: Revisions of the ranking added.
        notices: What was changed or left out.
    """

    slug: str
    was_there: bool
    n_recordings: int
    n_revisions: int
    notices: list[str] = field(default_factory=list)


def export_whole(session: Session, behaviour: BehaviourRow) -> tuple[dict[str, Any], list[str]]:
    """Write a behaviour's file as an object ready for json.dumps, and what had to be left out.

    Deleted recordings are in it where a revision of the ranking names them. What trainings made is
    not. A recording that was never verified is left out, and out of the revisions too: nobody
    could import it.
    """
    revisions = rankings.history(session, behaviour.id)
    named = {key for row in revisions for tier in row.tiers for key in tier}
    rows = [
        row
        for row in recordings.listing(session, behaviour.id, with_deleted=True)
        if row.deleted_at is None or row.id in named
    ]
    rows.sort(key=lambda row: row.id)
    sound = [row for row in rows if row.verification == Verification.VERIFIED]
    notices = [
        f"Recording {row.id} is left out: it is not verified."
        for row in rows
        if row.verification != Verification.VERIFIED
    ]
    known = {row.id for row in sound}
    names = players.names(session)
    about = behaviours.as_behaviour(behaviour)
    return {
        "format": BEHAVIOUR_FORMAT,
        "version": BEHAVIOUR_VERSION,
        "game": GAME,
        "slug": about.slug,
        "name": about.name,
        "description": about.description,
        "target": None if about.target is None else [list(cell) for cell in about.target],
        "ordered": about.ordered,
        "recordings": [_numbered(row, known, names) for row in sound],
        "rankings": [_revision(row, known, names) for row in revisions],
    }, notices


def import_whole(database: Database, content: bytes, name: str | None = None) -> BehaviourImported:
    """Add a behaviour from a file, all of it or nothing; every recording is replayed before.

    A behaviour that comes ready takes what the file says of it where it is still empty; otherwise a
    new behaviour is made, under a short name that is free.

    Args:
        database: Where to.
        content: The file.
        name: What the new behaviour is called; None takes the file's name.

    Raises:
        BehaviourRefused: It is something else, contradicts itself, or a recording in it does not
            replay.
        Invalid: The target makes no sense.
        Conflict: There are very many behaviours already.
    """
    given = parse_behaviour(content)
    replayed = _replayed(given)
    with database.writing() as session:
        found = None if name is not None else _empty_built_in(session, given)
        row = found or behaviours.create(
            session, name or given.name, given.description, _about(given).target, given.ordered
        )
        ids = _add_recordings(session, row.id, given, replayed)
        rankings.restore_history(
            session,
            row.id,
            [
                RankingRow(
                    behaviour_id=row.id,
                    player_id=_player(session, saved.player),
                    revision=saved.revision,
                    tiers=[[ids[number] for number in tier] for tier in saved.tiers],
                    change=saved.change,
                    undo_to=saved.undo_to,
                    redo_to=saved.redo_to,
                    created_at=saved.saved_at,
                )
                for saved in given.rankings
            ],
        )
        notices = [
            f"Recording {number}: {notice}"
            for number, one in replayed.items()
            for notice in one.notices
        ]
        return BehaviourImported(
            row.slug, found is not None, len(ids), len(given.rankings), notices
        )


def _numbered(row: RecordingRow, known: set[int], names: dict[int, str]) -> dict[str, Any]:
    parent = None
    if row.parent_id in known and row.parent_frame is not None:
        parent = {"number": row.parent_id, "frame": row.parent_frame}
    return {
        "number": row.id,
        "recording": as_exchange(row),
        "player": None if row.player_id is None else names.get(row.player_id),
        "played_at": row.created_at.isoformat(),
        "unfinished": row.state == RecordingState.UNFINISHED,
        "deleted": row.deleted_at is not None,
        "parent": parent,
    }


def _revision(row: RankingRow, known: set[int], names: dict[int, str]) -> dict[str, Any]:
    kept = rankings.as_ranking(row).without(
        {key for tier in row.tiers for key in tier if key not in known}
    )
    return {
        "revision": row.revision,
        "tiers": [list(tier) for tier in kept.tiers],
        "change": row.change,
        "player": None if row.player_id is None else names.get(row.player_id),
        "saved_at": row.created_at.isoformat(),
        "undo_to": row.undo_to,
        "redo_to": row.redo_to,
    }


def _about(given: BehaviourObject) -> Behaviour:
    target = None if given.target is None else tuple((r, c) for r, c in given.target)
    return Behaviour(given.slug, given.name, given.description, target, given.ordered)


def _replayed(given: BehaviourObject) -> dict[int, Exchanged]:
    console = Console()
    replayed: dict[int, Exchanged] = {}
    for numbered in given.recordings:
        try:
            content = numbered.recording.model_dump(mode="json", exclude_none=True)
            replayed[numbered.number] = from_exchange(content, console)
        except RecordingRefused as refusal:
            raise BehaviourRefused(
                f"Recording {numbered.number} is refused, and nothing was imported: {refusal}"
            ) from refusal
    return replayed


def _empty_built_in(session: Session, given: BehaviourObject) -> BehaviourRow | None:
    wanted = _about(given)
    for row in behaviours.listing(session):
        present = behaviours.as_behaviour(row)
        is_same = (present.slug, present.target, present.ordered) == (
            wanted.slug,
            wanted.target,
            wanted.ordered,
        )
        if not (row.built_in and is_same):
            continue
        is_empty = not recordings.has_any(session, row.id) and not rankings.history(session, row.id)
        return row if is_empty else None
    return None


def _add_recordings(
    session: Session, behaviour_id: int, given: BehaviourObject, replayed: dict[int, Exchanged]
) -> dict[int, int]:
    """Add the recordings and return their ids by their numbers in the file."""
    rows = {
        numbered.number: _add(session, behaviour_id, numbered, replayed[numbered.number])
        for numbered in given.recordings
    }
    for numbered in given.recordings:
        if numbered.parent is not None:
            row = rows[numbered.number]
            row.parent_id = rows[numbered.parent.number].id
            row.parent_frame = numbered.parent.frame
    return {number: row.id for number, row in rows.items()}


def _add(
    session: Session, behaviour_id: int, numbered: NumberedRecording, given: Exchanged
) -> RecordingRow:
    row = recordings.add(
        session,
        behaviour_id,
        given.recording,
        given.replay,
        Source(given.source or Source.PERSON),
        player_id=_player(session, numbered.player),
        perfect=given.perfect,
        notes=given.notes,
        conditions=given.conditions,
    )
    row.created_at = numbered.played_at
    row.finished_at = numbered.played_at
    if numbered.unfinished:
        row.state = RecordingState.UNFINISHED
    if numbered.deleted:
        row.deleted_at = now()
    return row


def _player(session: Session, name: str | None) -> int | None:
    return None if name is None else players.named(session, name).id
