"""Recordings into the library and out of it, in the exchange format; one way for page and shell."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, BinaryIO

from sqlalchemy.orm import Session

from tril.errors import Invalid
from tril.exchange.formats import (
    MAX_OBJECTS,
    Exchanged,
    from_exchange,
    ranked,
    read_lines,
    to_exchange,
)
from tril.game.console import Console
from tril.game.episode import EndReason
from tril.store import rankings, recordings
from tril.store.database import Database
from tril.store.models import RecordingRow, Source


@dataclass(frozen=True)
class Remark:
    """Something to say about a line of an imported file, counted from 1."""

    line: int
    reason: str


@dataclass
class Imported:
    """What became of a file of recordings.

    Attributes:
        recording_ids: The recordings added, in the file's order.
        notices: What was changed or left out.
        refusals: Lines that were not accepted, and why; nothing of them was stored.
    """

    recording_ids: list[int] = field(default_factory=list)
    notices: list[Remark] = field(default_factory=list)
    refusals: list[Remark] = field(default_factory=list)


def import_recordings(
    database: Database,
    behaviour_id: int,
    file: BinaryIO | bytes | str,
    *,
    rank: bool = False,
    perfect: bool = False,
    player_id: int | None = None,
    max_recordings: int = MAX_OBJECTS,
) -> Imported:
    """Add the recordings of a file, each verified by a replay, in one transaction.

    Args:
        database: Where the library is.
        behaviour_id: The behaviour they are games of.
        file: One object or JSON Lines in the exchange format.
        rank: Whether the file's order, from best to worst, is put below the present ranking's
            last tier as one revision. Equal tiers of the file become ties.
        perfect: Whether all of them are marked as perfect; else those that say so.
        player_id: Who brings them.
        max_recordings: What follows so many recordings is refused.

    Raises:
        Invalid: ``rank`` and ``perfect`` at once.
    """
    if rank and perfect:
        raise Invalid("Choose one: a file in order from best to worst, or perfect games only.")
    outcome = Imported()
    accepted = _read(file, outcome, max_recordings)
    if not accepted:
        return outcome
    with database.writing() as session:
        for _, given in accepted:
            row = recordings.add(
                session,
                behaviour_id,
                given.recording,
                given.replay,
                Source(given.source or Source.PERSON),
                player_id=player_id if given.source in (None, Source.PERSON) else None,
                perfect=perfect or given.perfect,
                notes=given.notes,
                conditions=_conditions(given),
            )
            outcome.recording_ids.append(row.id)
        if rank:
            _rank(session, behaviour_id, [given for _, given in accepted], outcome, player_id)
    return outcome


def export_recording(session: Session, row: RecordingRow) -> dict[str, Any]:
    """Write one recording as an object of the exchange format, with its place in the ranking."""
    tiers = rankings.as_ranking(rankings.current(session, row.behaviour_id)).tier_numbers()
    return as_exchange(row, tiers.get(row.id))


def export_behaviour(
    session: Session, behaviour_id: int, only: Sequence[RecordingRow] | None = None
) -> Iterator[dict[str, Any]]:
    """Write a behaviour's library: the ranked recordings from best to worst, then the others.

    Args:
        session: The transaction.
        behaviour_id: The behaviour.
        only: Which of its recordings; None for all that are not deleted.
    """
    tiers = rankings.as_ranking(rankings.current(session, behaviour_id)).tier_numbers()
    rows = recordings.listing(session, behaviour_id) if only is None else only
    last = len(rows) + 1
    for row in sorted(rows, key=lambda row: (tiers.get(row.id, last), row.id)):
        yield as_exchange(row, tiers.get(row.id))


def _read(
    file: BinaryIO | bytes | str, outcome: Imported, max_recordings: int
) -> list[tuple[int, Exchanged]]:
    console = Console()
    accepted = []
    for line in read_lines(file, max_objects=max_recordings):
        if line.refusal is not None:
            outcome.refusals.append(Remark(line.number, line.refusal))
            continue
        try:
            given = from_exchange(line.content, console)
        except Invalid as error:
            outcome.refusals.append(Remark(line.number, str(error)))
            continue
        outcome.notices += [Remark(line.number, notice) for notice in given.notices]
        accepted.append((line.number, given))
    return accepted


def _rank(
    session: Session,
    behaviour_id: int,
    accepted: list[Exchanged],
    outcome: Imported,
    player_id: int | None,
) -> None:
    order, notices = ranked(accepted)
    outcome.notices += [Remark(1, notice) for notice in notices]
    newest = rankings.current(session, behaviour_id)
    added = [[outcome.recording_ids[index] for index in tier] for tier in order.tiers]
    rankings.save(
        session,
        behaviour_id,
        newest.revision,
        [*newest.tiers, *added],
        player_id,
        change="import",
    )


def _conditions(given: Exchanged) -> dict[str, Any]:
    parent = {} if given.parent is None else {"imported_parent": given.parent}
    return {**given.conditions, **parent}


def as_exchange(row: RecordingRow, tier: int | None = None) -> dict[str, Any]:
    """Write one recording as an object of the exchange format, at this place in a ranking."""
    return to_exchange(
        recordings.as_recording(row),
        hits=recordings.hits_of(row),
        end=None if row.end is None else EndReason(row.end),
        tier=tier,
        perfect=row.perfect,
        source=Source(row.source).value,
        conditions=row.conditions,
        notes=row.notes,
    )
