"""Invitations: links that let people in, as participants of a behaviour or as researchers."""

from __future__ import annotations

from datetime import timedelta

from sqlalchemy import ColumnElement, or_, select
from sqlalchemy.orm import Session

from tril.errors import Conflict, Invalid, NotFound
from tril.store import audit, behaviours, players
from tril.store.access import credentials
from tril.store.changes import note_change
from tril.store.models import CredentialRow, InvitationRow, MembershipRow, Role, now
from tril.text import clean_line

PATH = "/join"
"""Where links lead to on a server."""

FORM_KEY_LENGTH = 22
"""Characters of a random key of 128 bits; a shorter one is none."""

DEFAULT_USES = 30
"""A class."""

MAX_USES = 1000

MAX_INVITATIONS = 500
"""Most links that are not revoked."""

DEFAULT_DAYS = 30

MAX_DAYS = 366


def make(
    session: Session,
    name: str,
    role: Role,
    behaviour_id: int | None,
    by_player_id: int | None,
    max_uses: int = DEFAULT_USES,
    days: int = DEFAULT_DAYS,
) -> tuple[InvitationRow, str]:
    """Make an invitation, and return it with the secret for its link.

    Args:
        session: The transaction.
        name: Whom it is for.
        role: Role of invited people.
        behaviour_id: Behaviour that a participant plays.
        by_player_id: Player that makes the invitation; None for a command in the terminal.
        max_uses: Most people that may use the invitation.
        days: Lifetime in days.

    Raises:
        Invalid: It has no name, is for another owner, lacks a participant's behaviour, or a bound
            is out of range.
        NotFound: There is no such behaviour.
        Conflict: There are MAX_INVITATIONS already.
    """
    if not (name := clean_line(name)):
        raise Invalid("Say whom the invitation is for, so that you can tell it from others.")
    if role is Role.OWNER:
        raise Invalid("There is one owner. Invite researchers or participants.")
    if (role is Role.PARTICIPANT) != (behaviour_id is not None):
        raise Invalid(
            "Name the behaviour that a participant is to play; researchers see all behaviours."
        )
    for value, maximum, unit in ((max_uses, MAX_USES, "people"), (days, MAX_DAYS, "days")):
        if not 1 <= value <= maximum:
            raise Invalid(f"A link lets people in for 1 to {maximum} {unit}, got {value}.")
    if behaviour_id is not None:
        behaviours.get(session, behaviour_id)
    if len(listing(session, limit=MAX_INVITATIONS)) >= MAX_INVITATIONS:
        raise Conflict(f"There are {MAX_INVITATIONS} links already; revoke some first.")
    secret = credentials.new_secret()
    row = InvitationRow(
        name=name,
        role=role,
        behaviour_id=behaviour_id,
        secret_hash=credentials.hash_of(secret),
        created_by=by_player_id,
        n_used=0,
        max_uses=max_uses,
        expires_at=now() + timedelta(days=days),
    )
    session.add(row)
    session.flush()
    _log(session, audit.Action.INVITATION_MADE, by_player_id, row)
    return row, secret


def find(session: Session, secret: str) -> InvitationRow | None:
    """Return the invitation of a link; None if it lets nobody in any more or is unknown."""
    return session.scalar(select(InvitationRow).where(_of(secret), _is_valid()))


def is_over(session: Session, secret: str) -> bool:
    """Whether a link was revoked, has expired or is used up."""
    query = select(InvitationRow.id).where(_of(secret), ~_is_valid())
    return session.scalar(query) is not None


def _of(secret: str) -> ColumnElement[bool]:
    return InvitationRow.secret_hash == credentials.hash_of(secret)


def _is_valid() -> ColumnElement[bool]:
    return (
        InvitationRow.revoked_at.is_(None)
        & or_(InvitationRow.max_uses.is_(None), InvitationRow.n_used < InvitationRow.max_uses)
        & or_(InvitationRow.expires_at.is_(None), InvitationRow.expires_at > now())
    )


def accept(
    session: Session, secret: str, name: str, browser: str, form_key: str = ""
) -> tuple[str, int | None]:
    """Let somebody in by a link as a new person, once for each form that is sent.

    The cookie's secret follows from the form's key. Sent again, a form signs the same person in,
    also if the link lets nobody else in by now.

    Returns:
        The secret for their cookie, and the behaviour that they may play; None for researchers.

    Raises:
        NotFound: The invitation lets nobody in any more, or is unknown.
        Invalid: They gave no name.
        TooManyPeople: There are players.MAX_PEOPLE already.
        TextRefused: The name can't be accepted.
    """
    # Locked, so that no more people come by it at once than it is for.
    session.execute(select(InvitationRow.id).where(_of(secret)).with_for_update())
    browser_secret = None
    if len(form_key) >= FORM_KEY_LENGTH:
        browser_secret = credentials.secret_from(secret, form_key)
        invitation = session.execute(
            select(InvitationRow.behaviour_id)
            .join(CredentialRow, CredentialRow.invitation_id == InvitationRow.id)
            .where(
                _of(secret),
                CredentialRow.secret_hash == credentials.hash_of(browser_secret),
                CredentialRow.ended_at.is_(None),
            )
        ).one_or_none()
        if invitation is not None:
            return browser_secret, invitation.behaviour_id
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
    signed_in = credentials.sign_in(session, person.id, browser, row.id, browser_secret)
    return signed_in, row.behaviour_id


def listing(
    session: Session, before: int | None = None, limit: int | None = None
) -> list[InvitationRow]:
    """Return the invitations that are not revoked, newest first.

    Args:
        session: The transaction.
        before: Only those with lower ids.
        limit: Most of them that are returned.
    """
    query = select(InvitationRow).where(InvitationRow.revoked_at.is_(None))
    if before is not None:
        query = query.where(InvitationRow.id < before)
    return list(session.scalars(query.order_by(InvitationRow.id.desc()).limit(limit)))


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
