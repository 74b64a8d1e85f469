"""What people may do, and changing it."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass

from sqlalchemy import exists, func, or_, select
from sqlalchemy.orm import Session

from tril.errors import Conflict, Invalid
from tril.store import audit, behaviours, players
from tril.store.access import credentials
from tril.store.changes import note_change
from tril.store.models import (
    CredentialKind,
    CredentialRow,
    MembershipRow,
    PlayerRow,
    Role,
)


@dataclass(frozen=True)
class Person:
    """Somebody who has been let in.

    Attributes:
        id: The person.
        name: Name of the person.
        role: Role of the person.
        behaviour_ids: Behaviours that a participant plays.
    """

    id: int
    name: str
    role: Role
    behaviour_ids: tuple[int, ...]


def people(session: Session, after: int = 0, limit: int | None = None) -> list[Person]:
    """Return the people who have been let in, and the owner; not the players of imported games.

    Args:
        session: The transaction.
        after: Only people with higher ids.
        limit: Most people that are returned.
    """
    was_let_in = exists().where(CredentialRow.player_id == PlayerRow.id)
    query = select(PlayerRow).where(
        or_(was_let_in, PlayerRow.role == Role.OWNER), PlayerRow.id > after
    )
    rows = session.scalars(query.order_by(PlayerRow.id).limit(limit)).all()
    of_them = select(MembershipRow).where(MembershipRow.player_id.in_([row.id for row in rows]))
    memberships = defaultdict(list)
    for membership in session.scalars(of_them.order_by(MembershipRow.behaviour_id)):
        memberships[membership.player_id].append(membership.behaviour_id)
    return [Person(row.id, row.name, Role(row.role), tuple(memberships[row.id])) for row in rows]


def change(
    session: Session,
    player_id: int,
    role: Role,
    behaviour_id: int | None,
    by_player_id: int | None,
) -> None:
    """Make somebody a researcher or a participant, which takes effect within seconds.

    Args:
        session: The transaction.
        player_id: Whom.
        role: New role.
        behaviour_id: Further behaviour of a participant.
        by_player_id: Player that makes the change; None for a command in the terminal.

    Raises:
        NotFound: There is no such person, or no such behaviour.
        Invalid: The role is another one, or a participant would have nothing to play.
        Conflict: It is the last owner.
    """
    row = players.get(session, player_id)
    if role not in {Role.RESEARCHER, Role.PARTICIPANT}:
        raise Invalid("People become researchers or participants.")
    if role is Role.RESEARCHER and behaviour_id is not None:
        raise Invalid("Researchers see all behaviours; name none.")
    if row.role == Role.OWNER and _n_owners(session) == 1:
        raise Conflict("Somebody has to say who gets in: the last owner stays the owner.")
    of_person = select(MembershipRow.behaviour_id).where(MembershipRow.player_id == player_id)
    playable = set(session.scalars(of_person))
    if behaviour_id is not None:
        behaviours.get(session, behaviour_id)
        if behaviour_id not in playable:
            session.add(MembershipRow(behaviour_id=behaviour_id, player_id=player_id))
    elif role is Role.PARTICIPANT and not playable:
        raise Invalid("Name the behaviour that a participant is to play.")
    before, row.role = row.role, role
    for key in credentials.listing(session, CredentialKind.KEY):
        # A key has rights of its own, which may be more than its maker has now.
        if key.player_id == player_id:
            credentials.end(session, CredentialKind.KEY, key.id, by_player_id)
    details = {} if behaviour_id is None else {"behaviour": behaviour_id}
    audit.note(
        session,
        audit.Action.ROLE_CHANGED,
        by_player_id,
        f"player {row.id}",
        name=row.name,
        before=before,
        role=str(role),
        **details,
    )
    note_change(session, credentials.CHANGES, credentials.ALL)
    note_change(session, "player", row.id)


def _n_owners(session: Session) -> int:
    query = select(func.count()).select_from(PlayerRow).where(PlayerRow.role == Role.OWNER)
    return session.scalar(query) or 0
