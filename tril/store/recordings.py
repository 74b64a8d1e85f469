"""The recordings: library, games being played, and the games of policies."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from typing import Any

from sqlalchemy import Select, func, select
from sqlalchemy.orm import Session, load_only

from tril.errors import Conflict, Invalid, NotFound
from tril.games import game_named
from tril.games.base import Cell, Taken
from tril.games.settings import GameSettings
from tril.recording import Recording, Replay
from tril.store import audit, rankings
from tril.store.changes import note_change, note_recordings
from tril.store.models import (
    BehaviourRow,
    RecordingRow,
    RecordingState,
    Source,
    Verification,
    now,
)

MAX_NOTES_LENGTH = 4000

ROWS_IN_MEMORY = 200
"""Recordings that are read at once where a whole library is gone through."""


def as_recording(row: RecordingRow) -> Recording:
    """Return the recording that a row holds."""
    game = game_named(row.game).with_settings(GameSettings(max_steps=row.max_steps))
    return Recording(
        game=game,
        start=game.starts.parse(row.start),
        actions=row.actions,
        hashes=tuple(row.hashes),
        version=row.game_version,
        end_rule=row.end_rule,
    )


def taken_of(row: RecordingRow) -> tuple[Taken, ...]:
    """Return the items that a recording takes, in order of time."""
    return tuple(Taken(row_, column, frame) for row_, column, frame in row.taken)


def cells_of(row: RecordingRow) -> tuple[Cell, ...]:
    """Return the cells of the items that a recording takes, in order of time."""
    return tuple((row_, column) for row_, column, _ in row.taken)


def died(row: RecordingRow) -> bool:
    """Return whether a recording ended with the player's death."""
    return game_named(row.game).is_death(row.end)


def fill(row: RecordingRow, recording: Recording, played: Replay) -> None:
    """Write a recording and what happened in it into its row."""
    for name, value in columns_of(recording, played).items():
        setattr(row, name, value)


def columns_of(recording: Recording, played: Replay) -> dict[str, Any]:
    """Return a recording and what happened in it as the columns of its row."""
    return {
        "game": recording.game.name,
        "game_version": recording.version,
        "max_steps": recording.game.settings.max_steps,
        "start": recording.start.to_json(),
        "end_rule": recording.end_rule,
        "actions": recording.actions,
        "n_frames": recording.n_frames,
        "hashes": list(recording.hashes),
        "taken": [[item.row, item.column, item.frame] for item in played.taken],
        "counters": played.counters,
        "score": played.score,
        "measured": dict(played.measured),
        "end": played.end,
    }


def add(
    session: Session,
    behaviour_id: int,
    recording: Recording,
    played: Replay,
    source: Source,
    *,
    player_id: int | None = None,
    run_id: str | None = None,
    perfect: bool = False,
    notes: str = "",
    conditions: dict[str, Any] | None = None,
) -> RecordingRow:
    """Add a verified recording.

    Args:
        session: The transaction.
        behaviour_id: Behaviour of the recording.
        recording: A verified recording (tril.recording.verify).
        played: Replay of the recording.
        source: Kind of player.
        player_id: Player, for a person's recording.
        run_id: Run, for a policy's recording.
        perfect: Whether the clone learns from it.
        notes: A person's remarks.
        conditions: Conditions of play.
    """
    row = RecordingRow(
        behaviour_id=behaviour_id,
        player_id=player_id,
        run_id=run_id,
        source=source,
        state=RecordingState.KEPT,
        verification=Verification.VERIFIED,
        perfect=perfect,
        notes=notes[:MAX_NOTES_LENGTH],
        conditions=conditions or {},
        finished_at=now(),
    )
    fill(row, recording, played)
    give_number(session, row)
    session.add(row)
    session.flush()
    note_change(session, "recording", row.id)
    return row


def give_number(session: Session, row: RecordingRow) -> None:
    """Give a recording the next number, if it has none; numbers of deleted ones stay taken."""
    if row.number is not None:
        return
    if row.run_id is None:
        # Two games of a behaviour may end at the same time; a run has one worker.
        behaviour = select(BehaviourRow.id).where(BehaviourRow.id == row.behaviour_id)
        session.execute(behaviour.with_for_update(key_share=True))
    taken = select(func.max(RecordingRow.number)).where(
        RecordingRow.behaviour_id == row.behaviour_id, RecordingRow.run_id == row.run_id
    )
    row.number = (session.scalar(taken) or 0) + 1


def get(session: Session, recording_id: int) -> RecordingRow:
    """Return a recording, even a deleted one; raises NotFound if there is none."""
    row = session.get(RecordingRow, recording_id)
    if row is None:
        raise NotFound(f"There is no recording {recording_id}.")
    return row


def file_name(session: Session, row: RecordingRow) -> str:
    """Return the name of a file of a recording, without its ending: "column-1-recording-3"."""
    slug = session.get_one(BehaviourRow, row.behaviour_id).slug
    return f"{slug}-recording-{row.id if row.number is None else row.number}"


def player_of(session: Session, recording_id: int) -> tuple[int | None, int] | None:
    """Return the person who played a recording and its behaviour; None if there is no such one."""
    query = select(RecordingRow.player_id, RecordingRow.behaviour_id).where(
        RecordingRow.id == recording_id, RecordingRow.source == Source.PERSON
    )
    row = session.execute(query).one_or_none()
    return None if row is None else (row[0], row[1])


def by_ids(session: Session, ids: Iterable[int], *columns: Any) -> dict[int, RecordingRow]:
    """Return recordings by id, even deleted ones; unknown ids are left out.

    Args:
        session: The transaction.
        ids: The recordings.
        *columns: All that will be read of them, such as RecordingRow.state; everything if empty.
    """
    options = [load_only(*columns)] if columns else []
    return {
        row.id: row
        for part in rankings.chunks(sorted(set(ids)), rankings.PART)
        for row in session.scalars(
            select(RecordingRow).where(RecordingRow.id.in_(part)).options(*options)
        )
    }


def in_order(session: Session, ids: Sequence[int]) -> Iterator[RecordingRow]:
    """Yield recordings in the order of their ids, with only some in memory at a time."""
    for part in rankings.chunks(ids, ROWS_IN_MEMORY):
        rows = by_ids(session, part)
        yield from (rows[key] for key in part if key in rows)
        for row in rows.values():
            session.expunge(row)


def listing(
    session: Session,
    behaviour_id: int,
    *,
    with_deleted: bool = False,
    with_policies: bool = False,
    with_undecided: bool = False,
    only_of: int | None = None,
    undecided_only: bool = False,
    before: int | None = None,
    limit: int | None = None,
) -> list[RecordingRow]:
    """Return a behaviour's library, newest first.

    Args:
        session: The transaction.
        behaviour_id: The behaviour.
        with_deleted: Whether to list deleted recordings, too.
        with_policies: Whether to list the recordings of runs, too.
        with_undecided: Whether to list games, too, that ended but were neither kept nor discarded.
        only_of: Only the games that this person played.
        undecided_only: Only games that ended but were neither kept nor discarded.
        before: Only recordings with lower ids.
        limit: Most recordings that are returned.
    """
    query = _library(behaviour_id, with_undecided)
    if undecided_only:
        query = query.where(RecordingRow.state == RecordingState.FINISHED)
    if before is not None:
        query = query.where(RecordingRow.id < before)
    if not with_deleted:
        query = query.where(RecordingRow.deleted_at.is_(None))
    if not with_policies:
        query = query.where(RecordingRow.run_id.is_(None))
    if only_of is not None:
        query = query.where(RecordingRow.player_id == only_of, RecordingRow.source == Source.PERSON)
    return list(session.scalars(query.order_by(RecordingRow.id.desc()).limit(limit)))


def library_ids(session: Session, behaviour_id: int) -> list[int]:
    """Return the recordings of a behaviour's library that are not deleted, newest first."""
    query = _library(behaviour_id).where(
        RecordingRow.deleted_at.is_(None), RecordingRow.run_id.is_(None)
    )
    ids = query.with_only_columns(RecordingRow.id).order_by(RecordingRow.id.desc())
    return list(session.scalars(ids))


def has_any(session: Session, behaviour_id: int) -> bool:
    """Whether a behaviour has any recordings, including deleted ones and those of runs."""
    query = select(RecordingRow.id).where(RecordingRow.behaviour_id == behaviour_id).limit(1)
    return session.scalar(query) is not None


def refuse_too_many(session: Session, player_id: int, limit: int, n_new: int = 1) -> None:
    """Raise Conflict if a person may not store more recordings; deleted ones count as well.

    A recording has at most some kilobytes, so this limits what somebody can store.
    """
    query = select(func.count(RecordingRow.id)).where(RecordingRow.player_id == player_id)
    n_stored = session.scalar(query) or 0
    if n_stored + n_new > limit:
        raise Conflict(
            f"{n_stored} recordings of yours are stored, deleted ones included, and at most"
            f" {limit} may be. Whoever runs this server can allow more"
            " (TRIL_MAX_RECORDINGS_PER_PLAYER)."
        )


def branches(session: Session, recording_id: int, only_of: int | None = None) -> list[RecordingRow]:
    """Return the recordings that continue this one, oldest first.

    Deleted ones and games being played are left out, and those of others than ``only_of``.
    """
    query = select(RecordingRow).where(
        RecordingRow.parent_id == recording_id,
        RecordingRow.deleted_at.is_(None),
        RecordingRow.state != RecordingState.PLAYING,
    )
    if only_of is not None:
        query = query.where(RecordingRow.player_id == only_of)
    return list(session.scalars(query.order_by(RecordingRow.id)))


def own_ids(
    session: Session, player_id: int, behaviour_ids: Collection[int], ids: Iterable[int]
) -> set[int]:
    """Return those of these recordings that a person played, of these behaviours."""
    query = select(RecordingRow.id).where(
        RecordingRow.id.in_(set(ids)),
        RecordingRow.behaviour_id.in_(behaviour_ids),
        RecordingRow.player_id == player_id,
        RecordingRow.source == Source.PERSON,
    )
    return set(session.scalars(query))


def perfect_ids(session: Session, behaviour_id: int) -> list[int]:
    """Return the recordings of the library that are marked as perfect, oldest first."""
    query = _library(behaviour_id).where(
        RecordingRow.deleted_at.is_(None),
        RecordingRow.run_id.is_(None),
        RecordingRow.perfect.is_(True),
    )
    ids = query.with_only_columns(RecordingRow.id).order_by(RecordingRow.id)
    return list(session.scalars(ids))


def keep(session: Session, row: RecordingRow) -> None:
    """Put a finished or abandoned game into the library.

    Raises:
        Conflict: It is still being played.
    """
    _refuse_while_playing(row)
    row.state = RecordingState.KEPT
    row.deleted_at = None
    give_number(session, row)
    note_change(session, "recording", row.id)


def delete(session: Session, rows: Sequence[RecordingRow], player_id: int | None) -> None:
    """Take recordings out of the lists and the rankings; ``restore`` brings them back.

    Trainings that used them keep them. Each ranking they were in gets one new revision. Those that
    are deleted already are passed over.

    Raises:
        Conflict: One is still being played, or is a result of a training.
    """
    for row in rows:
        _refuse_while_playing(row)
        if row.run_id is not None:
            raise Conflict(
                f"{row.title} is a result of a training and belongs to it; delete the "
                "training instead."
            )
    deleted = [row for row in rows if row.deleted_at is None]
    for row in deleted:
        row.deleted_at = now()
        _note(session, audit.Action.DELETED, player_id, row)
    note_recordings(session, deleted)
    session.flush()
    rankings.remove_recordings(session, [row.id for row in deleted], player_id)


def restore(session: Session, rows: Sequence[RecordingRow], player_id: int | None = None) -> None:
    """Restore deleted recordings, in the rankings too; discarded games go into the library.

    Each ranking that their deletion took them out of gets one new revision. Those that are not
    deleted are passed over.
    """
    deleted_at = {row.id: row.deleted_at for row in rows if row.deleted_at is not None}
    for row in rows:
        if row.id not in deleted_at:
            continue
        row.deleted_at = None
        give_number(session, row)
        if row.state == RecordingState.FINISHED:
            row.state = RecordingState.KEPT
        _note(session, audit.Action.RESTORED, player_id, row)
    note_recordings(session, [row for row in rows if row.id in deleted_at])
    session.flush()
    rankings.restore_recordings(session, deleted_at, player_id)


def mark(
    session: Session, rows: Sequence[RecordingRow], perfect: bool, player_id: int | None = None
) -> None:
    """Mark recordings as perfect, or take the marks off; all or none.

    Raises:
        Invalid: One is to be perfect but is not verified.
        Conflict: One is to be perfect but is a result of a training, which nothing learns from.
    """
    for row in rows:
        _mark(session, row, perfect, player_id)
    note_recordings(session, rows)


def update(
    session: Session,
    row: RecordingRow,
    perfect: bool | None = None,
    notes: str | None = None,
    player_id: int | None = None,
) -> None:
    """Change whether a recording is perfect, or its notes; None leaves them as they are.

    Args:
        session: The transaction.
        row: The recording.
        perfect: New mark, None to keep it.
        notes: New notes, None to keep them.
        player_id: Player that makes the change.

    Raises:
        Invalid: It is to be perfect but is not verified.
        TextRefused: The notes can't be accepted.
        Conflict: It is to be perfect but is a result of a training, which nothing learns from.
    """
    if perfect is not None:
        _mark(session, row, perfect, player_id)
    before = row.notes
    row.notes = before if notes is None else notes
    if row.notes != before:
        _note(session, audit.Action.NOTES_WRITTEN, player_id, row)
    note_change(session, "recording", row.id)


def _mark(session: Session, row: RecordingRow, perfect: bool, player_id: int | None) -> None:
    if perfect and row.run_id is not None:
        raise Conflict(
            f"{row.title} is a result of a training, so it can't be marked as perfect: the "
            "clone copies only the behaviour's own games."
        )
    if perfect and row.verification != Verification.VERIFIED:
        raise Invalid(
            "Only a verified recording can be marked as perfect, because learning replays it: "
            f"{row.verification_note or 'its replay is not done yet.'}"
        )
    if perfect == row.perfect:
        return
    row.perfect = perfect
    action = audit.Action.MARKED if perfect else audit.Action.UNMARKED
    _note(session, action, player_id, row)


def _note(session: Session, action: audit.Action, player_id: int | None, row: RecordingRow) -> None:
    audit.note(session, action, player_id, f"recording {row.id}", **audit.of_recording(row))


def _library(behaviour_id: int, with_undecided: bool = False) -> Select[RecordingRow]:
    states = [RecordingState.KEPT, RecordingState.UNFINISHED]
    if with_undecided:
        states.append(RecordingState.FINISHED)
    return select(RecordingRow).where(
        RecordingRow.behaviour_id == behaviour_id, RecordingRow.state.in_(states)
    )


def _refuse_while_playing(row: RecordingRow) -> None:
    if row.state == RecordingState.PLAYING:
        raise Conflict(f"{row.title} is still being played; end the game first.")
