"""Games being played: their owners, and what is saved of them.

A game has one owner at a time, a process and a tab, which hold a lease. Every change of owner
raises the game's epoch, and every write carries the epoch of its owner; an older one is refused.
"""

from __future__ import annotations

import uuid
from dataclasses import dataclass, field
from datetime import datetime, timedelta
from typing import Any

from sqlalchemy import Select, bindparam, func, select, update
from sqlalchemy.orm import Session, joinedload

from tril.errors import Conflict, Invalid, NotFound
from tril.games import game_of
from tril.games.base import Start
from tril.recording import Recording, Replay, Verified
from tril.store.behaviours import as_behaviour
from tril.store.changes import note_change
from tril.store.database import database_now
from tril.store.models import (
    BehaviourRow,
    GameRow,
    RecordingRow,
    RecordingState,
    Source,
    Verification,
)
from tril.store.recordings import as_recording, columns_of, fill, give_number

LEASE = timedelta(seconds=30)
"""How long an owner keeps a game without renewing its lease."""

OPEN_FOR = timedelta(minutes=1)
"""How long after its lease a game still counts as open: while a paused game's page is connected,
its lease lapses every half minute."""


# Games are saved while others are played: prepared once, and without ORM objects, these statements
# take a seventh of the processor time.
_GAME_OF_OWNER = update(GameRow).where(
    GameRow.id == bindparam("of_game"),
    GameRow.epoch == bindparam("of_epoch"),
    GameRow.ended_at.is_(None),
)
_RECORDING_OF_GAME = update(RecordingRow).where(
    RecordingRow.id
    == select(GameRow.recording_id).where(GameRow.id == bindparam("of_game")).scalar_subquery()
)


class GameOver(Conflict):
    """The game has ended; only its recording is left."""


@dataclass(frozen=True)
class Progress:
    """The state of a game as its owner saves it.

    Attributes:
        game_id: The game.
        epoch: The owner's epoch.
        recording: Recording of the game so far.
        played: Replay of the game so far.
        conditions: Conditions of play so far.
    """

    game_id: str
    epoch: int
    recording: Recording
    played: Replay
    conditions: dict[str, Any] = field(default_factory=dict)


def create(session: Session, behaviour_id: int, start: Start, player_id: int | None) -> GameRow:
    """Begin a game without an owner, and its recording."""
    game = game_of(as_behaviour(session.get_one(BehaviourRow, behaviour_id)))
    return _create(session, _playing(behaviour_id, Recording(game, start, b""), player_id))


def create_from(
    session: Session,
    parent: RecordingRow,
    frame: int,
    player_id: int | None,
    conditions: dict[str, Any] | None = None,
) -> GameRow:
    """Begin a game that continues a recording from one of its frames; the recording is kept.

    Args:
        session: The transaction.
        parent: A person's game.
        frame: The frame after which it continues.
        player_id: Player of the game.
        conditions: Conditions of play up to the frame.

    Raises:
        Invalid: The recording has no such frame, or nothing can be played after it.
        Conflict: The recording is still being played, its verification failed, or it is not a
            person's game.
    """
    if parent.source != Source.PERSON:
        raise Conflict(f"{parent.title} is no person's game; only those can be continued.")
    if parent.state == RecordingState.PLAYING:
        raise Conflict(f"{parent.title} is still being played; end the game first.")
    if parent.verification == Verification.FAILED:
        raise Conflict(f"{parent.title} can't be continued, because it does not replay.")
    last = parent.n_frames if parent.end is None else parent.n_frames - 1
    if not 0 <= frame <= last:
        raise Invalid(f"{parent.title} can be continued from frames 0 to {last}, got {frame}.")
    until = as_recording(parent).until(frame)
    row = _playing(parent.behaviour_id, until, player_id)
    row.parent_id, row.parent_frame = parent.id, frame
    row.actions, row.n_frames = until.actions, until.n_frames
    row.hashes = list(until.hashes)
    row.taken = [item for item in parent.taken if item[2] <= frame]
    row.conditions = conditions or {}
    return _create(session, row)


def create_taken_over(
    session: Session,
    behaviour_id: int,
    begun: Verified,
    player_id: int | None,
    conditions: dict[str, Any],
) -> GameRow:
    """Begin a game that continues what a policy has played so far.

    There is no recording of that part; the game's own holds it from the start.

    Args:
        session: The transaction.
        behaviour_id: Behaviour to demonstrate.
        begun: Recording of the policy's game.
        player_id: Player that takes over.
        conditions: Conditions of play up to the takeover.

    Raises:
        Conflict: The policy's game is over.
    """
    if begun.replay.end is not None:
        raise Conflict("This game is over, so nobody can play on.")
    row = _playing(behaviour_id, begun.recording, player_id)
    fill(row, begun.recording, begun.replay)
    # Without a parent: nothing was played yet that an abandoned game would be kept for.
    row.parent_frame = begun.recording.n_frames
    row.conditions = conditions
    return _create(session, row)


def _playing(behaviour_id: int, begun: Recording, player_id: int | None) -> RecordingRow:
    return RecordingRow(
        behaviour_id=behaviour_id,
        player_id=player_id,
        source=Source.PERSON,
        state=RecordingState.PLAYING,
        game=begun.game.name,
        game_version=begun.version,
        max_steps=begun.game.settings.max_steps,
        start=begun.start.to_json(),
        end_rule=begun.end_rule,
    )


def _create(session: Session, recording: RecordingRow) -> GameRow:
    session.add(recording)
    session.flush()
    row = GameRow(id=str(uuid.uuid4()), recording_id=recording.id)
    row.recording = recording
    row.lease_expires_at = database_now(session) + LEASE
    session.add(row)
    session.flush()
    return row


def get(session: Session, game_id: str) -> GameRow:
    """Return a game with its recording; raises NotFound if there is none."""
    row = session.scalar(
        select(GameRow).where(GameRow.id == game_id).options(joinedload(GameRow.recording))
    )
    if row is None:
        raise NotFound("There is no such game; start a new one.")
    return row


def acquire(session: Session, game_id: str, owner: str, tab: str) -> GameRow:
    """Make a process and a tab the owner of a game, whoever owns it.

    Raises:
        NotFound: There is no such game.
        GameOver: It has ended.
    """
    session.execute(select(GameRow.id).where(GameRow.id == game_id).with_for_update())
    row = get(session, game_id)
    if row.ended_at is not None:
        raise GameOver("This game is over.")
    row.epoch += 1
    row.owner, row.tab = owner, tab
    row.lease_expires_at = database_now(session) + LEASE
    return row


def acquire_abandoned(
    session: Session, game_id: str, owner: str, after: timedelta
) -> GameRow | None:
    """Take over a game if its lease ended some time ago; returns None otherwise."""
    session.execute(select(GameRow.id).where(GameRow.id == game_id).with_for_update())
    row = get(session, game_id)
    if row.ended_at is not None or _lease_end(row) >= database_now(session) - after:
        return None
    return acquire(session, game_id, owner, "")


def hold(session: Session, game_id: str, epoch: int) -> bool:
    """Renew an owner's lease; returns whether it is still the owner."""
    return _as_owner(session, game_id, epoch, LEASE)


def release(session: Session, game_id: str, epoch: int) -> None:
    """End an owner's lease now."""
    _as_owner(session, game_id, epoch, timedelta(0))


def save(session: Session, progress: Progress) -> bool:
    """Save a game and renew its lease; returns whether the owner is still its owner."""
    if not hold(session, progress.game_id, progress.epoch):
        return False
    columns = columns_of(progress.recording, progress.played)
    columns["conditions"] = progress.conditions
    session.connection().execute(_RECORDING_OF_GAME, {"of_game": progress.game_id, **columns})
    session.expire_all()
    return True


def branch(
    session: Session, before: Progress, after: Progress, refusal: str | None
) -> RecordingRow | None:
    """Keep a game as a recording of its own and let it continue from an earlier frame.

    Nothing is kept if nothing was played since the game continued from another recording. The
    game's own recording names what is kept as its parent.

    Args:
        session: The transaction.
        before: The game as it was played.
        after: The same game up to the frame from which it continues.
        refusal: Why verification failed; None if it passed.

    Returns:
        The recording that the game continues; None if the game has another owner by now.
    """
    if not hold(session, before.game_id, before.epoch):
        return None
    row = get(session, before.game_id).recording
    if row.parent_id is None or before.recording.n_frames > (row.parent_frame or 0):
        row_of_branch = RecordingRow(
            behaviour_id=row.behaviour_id,
            player_id=row.player_id,
            source=row.source,
            state=RecordingState.KEPT,
            parent_id=row.parent_id,
            parent_frame=row.parent_frame,
            conditions=before.conditions,
            finished_at=database_now(session),
        )
        fill(row_of_branch, before.recording, before.played)
        give_number(session, row_of_branch)
        _judge(row_of_branch, refusal)
        session.add(row_of_branch)
        session.flush()
        note_change(session, "recording", row_of_branch.id)
        row.parent_id = row_of_branch.id
    row.parent_frame = after.recording.n_frames
    fill(row, after.recording, after.played)
    row.conditions = after.conditions
    return session.get_one(RecordingRow, row.parent_id)


def end(
    session: Session,
    game_id: str,
    epoch: int,
    state: RecordingState,
    refusal: str | None,
) -> bool:
    """End a game whose last frame is saved.

    Args:
        session: The transaction.
        game_id: The game.
        epoch: The owner's epoch.
        state: FINISHED if it was played to its end, UNFINISHED if it was abandoned.
        refusal: Why verification failed; None if it passed.

    Returns:
        Whether it was ended, which only its owner can.
    """
    if not hold(session, game_id, epoch):
        return False
    row = get(session, game_id)
    row.ended_at = database_now(session)
    recording = row.recording
    recording.state = state
    recording.finished_at = row.ended_at
    _judge(recording, refusal)
    # An abandoned game in which nothing was played since it continued another one is dropped.
    was_abandoned = state == RecordingState.UNFINISHED
    if recording.n_frames == 0 or (was_abandoned and recording.n_frames == recording.parent_frame):
        recording.deleted_at = row.ended_at
    else:
        give_number(session, recording)
    note_change(session, "recording", recording.id)
    return True


def _judge(recording: RecordingRow, refusal: str | None) -> None:
    recording.verification = Verification.VERIFIED if refusal is None else Verification.FAILED
    recording.verification_note = refusal or ""


def abandoned(session: Session, after: timedelta, limit: int = 100) -> list[GameRow]:
    """Return games whose lease ended some time ago, with their recordings, oldest first."""
    query = (
        select(GameRow)
        .where(GameRow.ended_at.is_(None), GameRow.lease_expires_at < database_now(session) - after)
        .options(joinedload(GameRow.recording))
        .order_by(GameRow.created_at)
        .limit(limit)
    )
    return list(session.scalars(query))


def player_of(session: Session, game_id: str) -> tuple[int | None, int] | None:
    """Return the person who plays a game and its behaviour; None if there is no such game."""
    query = (
        select(RecordingRow.player_id, RecordingRow.behaviour_id)
        .join(GameRow, GameRow.recording_id == RecordingRow.id)
        .where(GameRow.id == game_id)
    )
    row = session.execute(query).one_or_none()
    return None if row is None else (row[0], row[1])


def is_open(session: Session, game_id: str) -> bool:
    """Whether a game is played or about to be."""
    return bool(session.scalar(_open(session).where(GameRow.id == game_id)))


def count_open(session: Session, player_id: int | None = None) -> int:
    """Count the games that are played or about to be, of a player or of all."""
    query = _open(session)
    if player_id is not None:
        query = query.join(RecordingRow, GameRow.recording_id == RecordingRow.id).where(
            RecordingRow.player_id == player_id
        )
    return session.scalar(query) or 0


def _open(session: Session) -> Select[int]:
    moment = database_now(session)
    # A lease that ends later than any can was written before the clock was set back.
    return select(func.count(GameRow.id)).where(
        GameRow.ended_at.is_(None),
        GameRow.lease_expires_at > moment - OPEN_FOR,
        GameRow.lease_expires_at < moment + LEASE + OPEN_FOR,
    )


def keep_undecided(session: Session, after: timedelta) -> None:
    """Keep games that were neither kept nor discarded for some time after they finished."""
    query = select(RecordingRow).where(
        RecordingRow.state == RecordingState.FINISHED,
        RecordingRow.deleted_at.is_(None),
        RecordingRow.finished_at < database_now(session) - after,
    )
    for row in session.scalars(query):
        row.state = RecordingState.KEPT
        note_change(session, "recording", row.id)


def _lease_end(row: GameRow) -> datetime:
    return row.lease_expires_at or row.created_at


def _as_owner(session: Session, game_id: str, epoch: int, lease: timedelta) -> bool:
    session.flush()
    result = session.connection().execute(
        _GAME_OF_OWNER,
        {
            "of_game": game_id,
            "of_epoch": epoch,
            "lease_expires_at": database_now(session) + lease,
        },
    )
    return result.rowcount > 0
