"""Invitations: links that let people in, as participants of a behaviour or as researchers."""

from __future__ import annotations

from sqlalchemy import select
from sqlalchemy.orm import Session

from tril.errors import Invalid, NotFound
from tril.store import audit, behaviours, players
from tril.store.access import credentials
from tril.store.changes import note_change
from tril.store.models import InvitationRow, MembershipRow, Role, now
from tril.text import clean_line

PATH = "/join"
"""Where links lead to on a server."""


def make(
    session: Session, name: str, role: Role, behaviour_id: int | None, by_player_id: int | None
) -> tuple[InvitationRow, str]:
    """Make an invitation, and return it with the secret for its link.

    Raises:
        Invalid: It has no name, is for another owner, or lacks a participant's behaviour.
        NotFound: There is no such behaviour.
    """
    if not (name := clean_line(name)):
        raise Invalid("Say whom the invitation is for, so that you can tell it from others.")
    if role is Role.OWNER:
        raise Invalid("There is one owner. Invite researchers or participants.")
    if (role is Role.PARTICIPANT) != (behaviour_id is not None):
        raise Invalid(
            "Name the behaviour that a participant is to play; researchers see all behaviours."
        )
    if behaviour_id is not None:
        behaviours.get(session, behaviour_id)
    secret = credentials.new_secret()
    row = InvitationRow(
        name=name,
        role=role,
        behaviour_id=behaviour_id,
        secret_hash=credentials.hash_of(secret),
        created_by=by_player_id,
        n_used=0,
    )
    session.add(row)
    session.flush()
    _log(session, audit.Action.INVITATION_MADE, by_player_id, row)
    return row, secret


def find(session: Session, secret: str) -> InvitationRow | None:
    """Return the invitation of a link; None if it was revoked or is unknown."""
    of_secret = InvitationRow.secret_hash == credentials.hash_of(secret)
    return session.scalar(
        select(InvitationRow).where(of_secret, InvitationRow.revoked_at.is_(None))
    )


def was_revoked(session: Session, secret: str) -> bool:
    """Whether a link has let people in, and does so no more."""
    of_secret = InvitationRow.secret_hash == credentials.hash_of(secret)
    query = select(InvitationRow.id).where(of_secret, InvitationRow.revoked_at.is_not(None))
    return session.scalar(query) is not None


def accept(session: Session, secret: str, name: str, browser: str) -> tuple[str, int | None]:
    """Let somebody in by a link as a new person.

    Returns:
        The secret for their cookie, and the behaviour that they may play; None for researchers.

    Raises:
        NotFound: The invitation was revoked or is unknown.
        Invalid: They gave no name.
        TextRefused: The name can't be accepted.
    """
    row = find(session, secret)
    if row is None:
        raise NotFound("This invitation is not valid any more. Ask for a new link.")
    person = players.add(session, name, Role(row.role))
    if row.behaviour_id is not None:
        session.add(
            MembershipRow(behaviour_id=row.behaviour_id, player_id=person.id, invitation_id=row.id)
        )
    row.n_used += 1
    _log(session, audit.Action.INVITATION_USED, person.id, row)
    return credentials.sign_in(session, person.id, browser, row.id), row.behaviour_id


def listing(session: Session) -> list[InvitationRow]:
    """Return the invitations that are not revoked, newest first."""
    query = select(InvitationRow).where(InvitationRow.revoked_at.is_(None))
    return list(session.scalars(query.order_by(InvitationRow.id.desc())))


def revoke(session: Session, invitation_id: int, by_player_id: int | None) -> None:
    """Revoke a link; those who have used it stay. Harmless when repeated.

    Raises:
        NotFound: There is no such invitation.
    """
    row = session.get(InvitationRow, invitation_id)
    if row is None:
        raise NotFound(f"There is no invitation {invitation_id}.")
    if row.revoked_at is None:
        row.revoked_at = now()
        _log(session, audit.Action.INVITATION_REVOKED, by_player_id, row)


def _log(session: Session, action: audit.Action, player_id: int | None, row: InvitationRow) -> None:
    audit.note(
        session, action, player_id, f"invitation {row.id}", name=row.name, role=str(row.role)
    )
    note_change(session, "invitation", row.id)
