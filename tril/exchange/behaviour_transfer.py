"""Import and export of behaviours with their recordings, rankings and answers to statements.

See docs/behaviour-format.md.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

from sqlalchemy.orm import Session

from tril.errors import Invalid, NotFound
from tril.exchange.formats.behaviour_file import (
    BEHAVIOUR_FORMAT,
    BEHAVIOUR_VERSION,
    AnswerObject,
    BehaviourObject,
    BehaviourRefused,
    NumberedRecording,
    RevisionObject,
    parse_behaviour,
)
from tril.exchange.formats.recording_file import ImportedRecording, load_recording
from tril.exchange.formats.recording_object import RecordingObject
from tril.exchange.formats.run_file import TaughtBehaviour
from tril.exchange.recording_transfer import dump_row
from tril.games import game_of
from tril.games.base import Cell
from tril.games.behaviours import Behaviour
from tril.games.measures import Measure, measures_from_json
from tril.games.measuring import check_measures
from tril.games.settings import GameSettings
from tril.play.consoles import Consoles
from tril.recording import RecordingRefused
from tril.store import answers, audit, behaviours, borrowed, players, rankings, recordings
from tril.store.database import Database
from tril.store.models import (
    BehaviourRow,
    RankingRow,
    RecordingRow,
    RecordingState,
    Source,
    StatementAnswerRow,
    Verification,
    now,
)


@dataclass(frozen=True)
class BehaviourImportResult:
    """The result of importing a behaviour file.

    Attributes:
        slug: The behaviour that was filled or created.
        was_there: Whether an empty built-in behaviour was filled; else the behaviour is new.
        n_recordings: Recordings added, including deleted ones.
        n_revisions: Revisions of the ranking added.
        notices: Changed or ignored values.
    """

    slug: str
    was_there: bool
    n_recordings: int
    n_revisions: int
    notices: list[str] = field(default_factory=list)


def export_behaviour(session: Session, behaviour: BehaviourRow) -> tuple[dict[str, Any], list[str]]:
    """Return a behaviour file, ready for json.dumps, and notices about what it leaves out.

    Deleted recordings and borrowed games are included if a revision of the ranking names them.
    Recordings that are not verified are left out, also of the revisions, since they could not be
    imported.
    """
    revisions = rankings.history(session, behaviour.id)
    named = recordings.by_ids(
        session, (key for row in revisions for tier in row.tiers for key in tier)
    )
    library = {row.id: row for row in recordings.listing(session, behaviour.id)}
    rows = sorted((named | library).values(), key=lambda row: row.id)
    sound = [row for row in rows if row.verification == Verification.VERIFIED]
    notices = [
        f"{row.title} was left out because it is not verified."
        for row in rows
        if row.verification != Verification.VERIFIED
    ]
    recording_ids = {row.id for row in sound}
    borrowed_now = {row.id for row in borrowed.listing(session, behaviour.id)}
    names = players.names(session)
    about = behaviours.as_behaviour(behaviour)
    return {
        "format": BEHAVIOUR_FORMAT,
        "version": BEHAVIOUR_VERSION,
        "game": about.game,
        **describe(about),
        "recordings": [
            _numbered(row, recording_ids, names)
            if row.behaviour_id == behaviour.id and row.run_id is None
            else _numbered_borrowed(session, row, names, row.id in borrowed_now)
            for row in sound
        ],
        "rankings": [_revision(row, recording_ids, names) for row in revisions],
        "answers": [_answer(row, names) for row in answers.current_rows(session, behaviour.id)],
    }, notices


def import_behaviour(
    database: Database, content: bytes, name: str | None = None
) -> BehaviourImportResult:
    """Add a behaviour from a file in one transaction, after replaying every recording.

    A matching built-in behaviour that is still empty is filled; otherwise a new behaviour with a
    free slug is created, and with a number after its name if there is one of that name.

    Args:
        database: The database of the library.
        content: The file.
        name: Name of the new behaviour; None takes the file's, with a number if it is taken.

    Raises:
        BehaviourRefused: The file is invalid or a recording in it does not replay.
        Invalid: The target is invalid.
        NameTaken: There is a behaviour of the name that was asked for.
        Conflict: There are too many behaviours.
    """
    behaviour = parse_behaviour(content)
    measures = _check_game(behaviour)
    numbered = ((game.number, game.recording) for game in behaviour.recordings)
    replayed = replay_all(numbered, BehaviourRefused)
    with database.writing() as session:
        row, was_there = add_behaviour(session, behaviour, behaviour.game, name)
        row.measures = [measure.to_json() for measure in measures]
        ids = _add_recordings(session, row.id, behaviour, replayed)
        revisions = [_ranking_row(session, row.id, saved, ids) for saved in behaviour.rankings]
        rankings.restore_history(session, row.id, revisions)
        session.add_all(_answer_row(session, row.id, answer) for answer in behaviour.answers)
        audit.note(session, audit.Action.IMPORTED, None, f"behaviour {row.id}", recordings=len(ids))
        notices = [
            f"Recording {number}: {notice}"
            for number, recording in replayed.items()
            for notice in recording.notices
        ]
        return BehaviourImportResult(row.slug, was_there, len(ids), len(revisions), notices)


def describe(behaviour: Behaviour) -> dict[str, Any]:
    """Return what files say of a behaviour, ready for JSON."""
    return {
        "slug": behaviour.slug,
        "name": behaviour.name,
        "description": behaviour.description,
        "target": None if behaviour.target is None else [list(cell) for cell in behaviour.target],
        "ordered": behaviour.ordered,
        "settings": behaviour.settings.to_json(),
        "measures": [measure.to_json() for measure in behaviour.measures],
    }


def target_of(described: BehaviourObject | TaughtBehaviour) -> tuple[Cell, ...] | None:
    """Return the target cells that a file names."""
    return None if described.target is None else tuple((r, c) for r, c in described.target)


def add_behaviour(
    session: Session, described: BehaviourObject | TaughtBehaviour, game: str, name: str | None
) -> tuple[BehaviourRow, bool]:
    """Return a behaviour for what a file has: the built-in one if it is empty, else a new one.

    Args:
        session: The transaction.
        described: The behaviour as the file describes it.
        game: Name of its game.
        name: Name of a new behaviour, which is then made in any case; None for the file's, with a
            number if there is one of that name.

    Returns:
        The behaviour, and whether it was there.

    Raises:
        Invalid: Target, settings or measures are invalid.
        NameTaken: There is a behaviour of the name that was asked for.
        Conflict: There are too many behaviours.
    """
    target, settings = target_of(described), GameSettings.from_json(described.settings)
    identity = (described.slug, target, described.ordered, settings)
    for row in behaviours.listing(session) if name is None else ():
        present = behaviours.as_behaviour(row)
        is_same = identity == (present.slug, present.target, present.ordered, present.settings)
        if row.built_in and is_same and _is_empty(session, row.id):
            return row, True
    created = behaviours.create(
        session,
        name or behaviours.free_name(session, described.name),
        described.description,
        target,
        described.ordered,
        game=game,
        settings=settings,
        measures=measures_from_json(described.measures),
    )
    return created, False


def _is_empty(session: Session, behaviour_id: int) -> bool:
    is_ranked = rankings.current(session, behaviour_id).revision > 0
    return not is_ranked and not recordings.has_any(session, behaviour_id)


def replay_all(
    numbered: Iterable[tuple[int, RecordingObject]], refused: type[Invalid]
) -> dict[int, ImportedRecording]:
    """Replay the recordings of a file; return them by their numbers in it.

    Args:
        numbered: Number and recording of each.
        refused: Raised if one does not replay to what the file says.
    """
    consoles = Consoles()
    replayed = {}
    for number, recording in numbered:
        try:
            content = recording.model_dump(mode="json", exclude_none=True)
            replayed[number] = load_recording(content, consoles)
        except RecordingRefused as refusal:
            raise refused(
                f"Nothing was imported. Recording {number} was refused: {refusal}"
            ) from refusal
    return replayed


def _numbered(row: RecordingRow, recording_ids: set[int], names: dict[int, str]) -> dict[str, Any]:
    parent = None
    if row.parent_id in recording_ids and row.parent_frame is not None:
        parent = {"number": row.parent_id, "frame": row.parent_frame}
    return {
        "number": row.id,
        "recording": dump_row(row),
        "player": None if row.player_id is None else names.get(row.player_id),
        "played_at": row.created_at.isoformat(),
        "unfinished": row.state == RecordingState.UNFINISHED,
        "deleted": row.deleted_at is not None,
        "parent": parent,
    }


def _numbered_borrowed(
    session: Session, row: RecordingRow, names: dict[int, str], is_borrowed: bool
) -> dict[str, Any]:
    """Return a borrowed game, which becomes the imported behaviour's own.

    What is said of it as an example of its own behaviour doesn't hold there: that it is perfect,
    its notes, and the conditions by which the demonstrator knows it again.
    """
    origin = session.get_one(BehaviourRow, row.behaviour_id).name
    if row.run_id is not None:
        origin = f"a training of {origin}"
    numbered = _numbered(row, set(), names)
    numbered["recording"] |= {"perfect": False, "notes": f"Borrowed from {origin}."}
    numbered["recording"].pop("conditions", None)
    numbered["deleted"] = not is_borrowed
    return numbered


def _revision(row: RankingRow, recording_ids: set[int], names: dict[int, str]) -> dict[str, Any]:
    ranking = rankings.as_ranking(row).without(
        {key for tier in row.tiers for key in tier if key not in recording_ids}
    )
    return {
        "revision": row.revision,
        "tiers": [list(tier) for tier in ranking.tiers],
        "change": row.change,
        "player": None if row.player_id is None else names.get(row.player_id),
        "saved_at": row.created_at.isoformat(),
        "undo_to": row.undo_to,
        "redo_to": row.redo_to,
    }


def _answer(row: StatementAnswerRow, names: dict[int, str]) -> dict[str, Any]:
    return {
        "subjects": row.subjects,
        "sentence": row.sentence,
        "meant": row.meant,
        "player": None if row.player_id is None else names.get(row.player_id),
        "answered_at": row.created_at.isoformat(),
    }


def _answer_row(session: Session, behaviour_id: int, answer: AnswerObject) -> StatementAnswerRow:
    return StatementAnswerRow(
        behaviour_id=behaviour_id,
        player_id=_player(session, answer.player),
        subjects=sorted(set(answer.subjects)),
        sentence=answer.sentence,
        meant=answer.meant,
        created_at=answer.answered_at,
    )


def _check_game(behaviour_file: BehaviourObject) -> tuple[Measure, ...]:
    """Check that the behaviour's game is here and has what it sets and targets; return measures."""
    for numbered in behaviour_file.recordings:
        if numbered.recording.game != behaviour_file.game:
            raise BehaviourRefused(
                f"Recording {numbered.number} is of {numbered.recording.game}, the behaviour of"
                f" {behaviour_file.game}."
            )
    try:
        measures = measures_from_json(behaviour_file.measures)
        behaviour = Behaviour(
            behaviour_file.slug,
            behaviour_file.name,
            "",
            behaviour_file.game,
            target_of(behaviour_file),
            behaviour_file.ordered,
            GameSettings.from_json(behaviour_file.settings),
            measures,
        )
        game = game_of(behaviour)
        game.check_target(behaviour)
        check_measures(game, measures)
    except (Invalid, NotFound) as refusal:
        raise BehaviourRefused(str(refusal)) from refusal
    return measures


def _ranking_row(
    session: Session, behaviour_id: int, saved: RevisionObject, ids: dict[int, int]
) -> RankingRow:
    return RankingRow(
        behaviour_id=behaviour_id,
        player_id=_player(session, saved.player),
        revision=saved.revision,
        tiers=[[ids[number] for number in tier] for tier in saved.tiers],
        change=saved.change,
        undo_to=saved.undo_to,
        redo_to=saved.redo_to,
        created_at=saved.saved_at,
    )


def _add_recordings(
    session: Session,
    behaviour_id: int,
    behaviour: BehaviourObject,
    replayed: dict[int, ImportedRecording],
) -> dict[int, int]:
    """Add the recordings; return their ids by number in the file."""
    rows = {
        numbered.number: _add(session, behaviour_id, numbered, replayed[numbered.number])
        for numbered in behaviour.recordings
    }
    for numbered in behaviour.recordings:
        if numbered.parent is not None:
            row = rows[numbered.number]
            row.parent_id = rows[numbered.parent.number].id
            row.parent_frame = numbered.parent.frame
    return {number: row.id for number, row in rows.items()}


def _add(
    session: Session, behaviour_id: int, numbered: NumberedRecording, imported: ImportedRecording
) -> RecordingRow:
    row = recordings.add(
        session,
        behaviour_id,
        imported.recording,
        imported.replay,
        Source(imported.source or Source.PERSON),
        player_id=_player(session, numbered.player),
        perfect=imported.perfect,
        notes=imported.notes,
        conditions=imported.conditions,
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
