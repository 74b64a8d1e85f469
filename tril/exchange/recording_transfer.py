"""Import and export of recordings in the exchange format, for the page and the command line."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass, field
from functools import partial
from typing import Any, BinaryIO

from sqlalchemy.orm import Session

from tril.errors import Invalid
from tril.exchange.formats.action_list import with_defaults
from tril.exchange.formats.jsonl import MAX_OBJECTS, read_lines
from tril.exchange.formats.recording_file import (
    ImportedRecording,
    dump_recording,
    load_recording,
    ranking_of,
)
from tril.games import game_of
from tril.games.base import Game, Start
from tril.play.consoles import Consoles
from tril.recording import Recording
from tril.store import audit, behaviours, library, rankings, recordings
from tril.store.database import Database
from tril.store.models import RecordingRow, Source
from tril.text import shown_json

MAX_EXAMPLES = 20
"""Most messages that are kept of a file, of each kind; the others are counted."""


@dataclass(frozen=True)
class LineMessage:
    """A message about a line of an imported file, counted from 1."""

    line: int
    reason: str


@dataclass
class RecordingImportResult:
    """The result of importing a file of recordings.

    Attributes:
        recording_ids: The recordings added, in the file's order.
        already_there: Recordings of the library that the file contains; they are not added again.
        notices: Changed or ignored values; at most MAX_EXAMPLES of them.
        refusals: Lines that were refused, with the reason; at most MAX_EXAMPLES of them.
        n_notices: Number of notices.
        n_refused: Number of lines that were refused.
    """

    recording_ids: list[int] = field(default_factory=list)
    already_there: list[int] = field(default_factory=list)
    notices: list[LineMessage] = field(default_factory=list)
    refusals: list[LineMessage] = field(default_factory=list)
    n_notices: int = 0
    n_refused: int = 0


def import_recordings(
    database: Database,
    behaviour_id: int,
    file: BinaryIO | bytes | str,
    *,
    rank: bool = False,
    perfect: bool = False,
    player_id: int | None = None,
    max_recordings: int = MAX_OBJECTS,
    max_of_player: int | None = None,
    load: Callable[[object], ImportedRecording] | None = None,
) -> RecordingImportResult:
    """Add the recordings of a file, each verified by a replay, in one transaction.

    Games that the library has already are not added again, nor ranked, nor is one that is in the
    file twice.

    Args:
        database: The database of the library.
        behaviour_id: The behaviour they show.
        file: One object or JSON Lines, each in the exchange format or an action list, which
            gets the behaviour's length and end rule where it names none.
        rank: Append the file's order, from best to worst, to the current ranking as one revision.
            Equal tiers become ties.
        perfect: Mark all of them as perfect, else those marked in the file.
        player_id: The player of recordings by a person.
        max_recordings: Further recordings are refused.
        max_of_player: Most stored recordings of the player; None for any number.
        load: Loads and verifies a recording, as ``load_recording`` does; None for doing it here.

    Raises:
        NotFound: There is no such behaviour.
        Conflict: The player would have too many recordings.
        Invalid: ``rank`` and ``perfect`` at once.
    """
    if rank and perfect:
        raise Invalid("Choose either ranking the recordings or marking all of them as perfect.")
    outcome = RecordingImportResult()
    with database.reading() as session:
        game = game_of(behaviours.as_behaviour(behaviours.get(session, behaviour_id)))
    load = load or partial(load_recording, consoles=Consoles())
    accepted = _read(file, outcome, max_recordings, game, load)
    if not accepted:
        outcome.n_notices = len(outcome.notices)
        return outcome
    with database.writing() as session:
        present = library.same_games(
            session, behaviour_id, [imported.recording for _, imported in accepted]
        )
        present_ids = [present.get(_identity(imported.recording)) for _, imported in accepted]
        outcome.already_there += [key for key in present_ids if key is not None]
        accepted = [
            imported for imported, key in zip(accepted, present_ids, strict=True) if key is None
        ]
        if player_id is not None and max_of_player is not None:
            recordings.refuse_too_many(session, player_id, max_of_player, len(accepted))
        for _, imported in accepted:
            row = recordings.add(
                session,
                behaviour_id,
                imported.recording,
                imported.replay,
                Source(imported.source or Source.PERSON),
                player_id=player_id if imported.source in (None, Source.PERSON) else None,
                perfect=perfect or imported.perfect,
                notes=imported.notes,
                conditions=_conditions(imported),
            )
            outcome.recording_ids.append(row.id)
        if outcome.recording_ids:
            audit.note(
                session,
                audit.Action.IMPORTED,
                player_id,
                f"behaviour {behaviour_id}",
                recordings=len(outcome.recording_ids),
            )
        if rank and accepted:
            _rank(session, behaviour_id, [imported for _, imported in accepted], outcome, player_id)
    outcome.n_notices = len(outcome.notices)
    # Notices about the whole file come last.
    del outcome.notices[MAX_EXAMPLES - 1 : -1]
    return outcome


def _identity(recording: Recording) -> tuple[str, Start, bytes, str]:
    """Return the identity of a game: everything that determines its replay."""
    return recording.game.name, recording.start, recording.actions, recording.version


def export_recording(session: Session, row: RecordingRow) -> dict[str, Any]:
    """Return a recording in the exchange format, with its place in the ranking."""
    tiers = rankings.as_ranking(rankings.current(session, row.behaviour_id)).tier_numbers()
    return dump_row(row, tiers.get(row.id))


def export_recordings(
    session: Session, behaviour_id: int, only: Collection[int] | None = None
) -> Iterator[dict[str, Any]]:
    """Yield a behaviour's recordings: the ranked ones from best to worst, then the others.

    Args:
        session: The transaction.
        behaviour_id: The behaviour.
        only: The recordings to export; None for all that are not deleted.
    """
    tiers = rankings.as_ranking(rankings.current(session, behaviour_id)).tier_numbers()
    ids = set(recordings.library_ids(session, behaviour_id) if only is None else only)
    last = len(tiers) + 1
    order = sorted(ids, key=lambda key: (tiers.get(key, last), key))
    for row in recordings.in_order(session, order):
        yield dump_row(row, tiers.get(row.id))


def _read(
    file: BinaryIO | bytes | str,
    outcome: RecordingImportResult,
    max_recordings: int,
    game: Game,
    load: Callable[[object], ImportedRecording],
) -> list[tuple[int, ImportedRecording]]:
    accepted: dict[tuple[str, Start, bytes, str], tuple[int, ImportedRecording]] = {}
    refusals = outcome.refusals
    for line in read_lines(file, max_objects=max_recordings):
        try:
            if line.refusal is not None:
                raise Invalid(line.refusal)
            imported = load(with_defaults(line.content, game))
            _refuse_other_game(imported.recording, game)
        except Invalid as error:
            refusals.append(LineMessage(line.number, str(error)))
            continue
        first, _ = accepted.setdefault(_identity(imported.recording), (line.number, imported))
        if first != line.number:
            notice = f"It is the same game as in line {first}, so it was not imported again."
            outcome.notices.append(LineMessage(line.number, notice))
            continue
        outcome.notices += [LineMessage(line.number, notice) for notice in imported.notices]
    outcome.n_refused = len(refusals)
    # The last one may say that the file is too long.
    del refusals[MAX_EXAMPLES - 1 : -1]
    return [*accepted.values()]


def _refuse_other_game(recording: Recording, game: Game) -> None:
    if recording.game.name != game.name:
        raise Invalid(
            f"It is a game of {recording.game.title}, but the behaviour is one of {game.title}."
            f" Import it into a behaviour of {recording.game.title}."
        )


def _rank(
    session: Session,
    behaviour_id: int,
    accepted: list[ImportedRecording],
    outcome: RecordingImportResult,
    player_id: int | None,
) -> None:
    order, notices = ranking_of(accepted)
    outcome.notices += [LineMessage(1, notice) for notice in notices]
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


def _conditions(recording: ImportedRecording) -> dict[str, Any]:
    parent = {} if recording.parent is None else {"imported_parent": recording.parent}
    return {**recording.conditions, **parent}


def dump_row(row: RecordingRow, tier: int | None = None) -> dict[str, Any]:
    """Return a recording in the exchange format."""
    return dump_recording(
        recordings.as_recording(row),
        taken=recordings.taken_of(row),
        end=row.end,
        tier=tier,
        perfect=row.perfect,
        source=Source(row.source).value,
        conditions=shown_json(row.conditions),
        notes=row.notes,
    )
