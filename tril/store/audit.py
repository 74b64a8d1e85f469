"""The audit log: who did what, and when. It is only ever added to."""

from __future__ import annotations

from enum import StrEnum
from typing import Any

from sqlalchemy import select
from sqlalchemy.orm import Session

from tril.store.models import AuditRow, PlayerRow, RecordingRow


class Action(StrEnum):
    """What is logged."""

    SIGNED_IN = "signed in"
    SIGNED_OUT = "signed out"
    ALL_SIGNED_OUT = "signed everybody out"
    INVITATION_MADE = "made an invitation"
    INVITATION_USED = "used an invitation"
    INVITATION_REVOKED = "revoked an invitation"
    KEY_MADE = "made a key"
    KEY_REVOKED = "revoked a key"
    ROLE_CHANGED = "changed a role"
    WORKER_LET_IN = "let a worker in"
    DELETED = "deleted"
    RESTORED = "restored"
    RENAMED = "renamed"
    CHANGED = "changed"
    MARKED = "marked as perfect"
    UNMARKED = "unmarked as perfect"
    NOTES_WRITTEN = "wrote notes"
    IMPORTED = "imported"
    EXPORTED = "exported"
    BACKED_UP = "backed up"
    RANKED = "ranked"
    ANSWERED = "answered a statement"
    COMPARED = "compared games blind"
    RUN_QUEUED = "queued a run"
    RUN_CANCELLED = "cancelled a run"


def note(
    session: Session, action: Action, player_id: int | None, subject: str, **details: Any
) -> None:
    """Log, in the transaction that does it, what somebody does.

    Args:
        session: The transaction.
        action: Action to log.
        player_id: Player that acts; None for a command in the terminal, or Tril itself.
        subject: Object of the action: "recording 12".
        **details: More about it, as JSON; no secrets.
    """
    person = None if player_id is None else session.get(PlayerRow, player_id)
    session.add(
        AuditRow(
            action=action,
            player_id=player_id,
            player_name=None if person is None else person.name,
            subject=subject,
            details=details,
        )
    )


def of_recording(row: RecordingRow) -> dict[str, int | None]:
    """Return the details that name a recording: its number and its behaviour's id."""
    return {"number": row.number, "behaviour": row.behaviour_id}


def page(session: Session, before: int | None = None, limit: int = 50) -> list[AuditRow]:
    """Return entries, newest first.

    Args:
        session: The transaction.
        before: Only entries that are older than the one of this id.
        limit: Most entries to return.
    """
    query = select(AuditRow).order_by(AuditRow.id.desc()).limit(limit)
    if before is not None:
        query = query.where(AuditRow.id < before)
    return list(session.scalars(query))
