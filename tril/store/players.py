"""The people who play and rank: the owner, those invited, those whose games were imported."""

from __future__ import annotations

from collections.abc import Collection

from sqlalchemy import exists, func, or_, select
from sqlalchemy.orm import Session

from tril.errors import Conflict, Invalid, NotFound
from tril.store import audit
from tril.store.changes import note_change
from tril.store.models import CredentialRow, PlayerRow, Role
from tril.text import clean_line, folded

MAX_PEOPLE = 10_000
"""Most people that there can be, those of imported games included."""

OWNER_NAME = "Player"
"""Name of the owner until it is changed."""


class TooManyPeople(Conflict):
    """There are as many people as there can be."""


def owner(session: Session) -> PlayerRow:
    """Return the owner; raises NotFound in a database without one."""
    row = session.scalar(
        select(PlayerRow).where(PlayerRow.role == Role.OWNER).order_by(PlayerRow.id).limit(1)
    )
    if row is None:
        raise NotFound("The database has no owner yet; run `tril migrate`.")
    return row


def count(session: Session) -> int:
    """Return the number of people."""
    return session.scalar(select(func.count()).select_from(PlayerRow)) or 0


def lock(session: Session, player_id: int) -> None:
    """Make other transactions that lock this player wait until this one is over."""
    session.execute(select(PlayerRow.id).where(PlayerRow.id == player_id).with_for_update())


def seed_owner(session: Session) -> None:
    """Add the owner where there is none."""
    if session.scalar(select(PlayerRow.id).where(PlayerRow.role == Role.OWNER)) is None:
        session.add(PlayerRow(name=OWNER_NAME, role=Role.OWNER))
        session.flush()


def get(session: Session, player_id: int) -> PlayerRow:
    """Return a person; raises NotFound if there is none."""
    row = session.get(PlayerRow, player_id)
    if row is None:
        raise NotFound(f"There is no player {player_id}.")
    return row


def add(session: Session, name: str, role: Role) -> PlayerRow:
    """Add a person.

    Raises:
        Invalid: They have no name.
        TextRefused: The name can't be accepted.
        TooManyPeople: There are MAX_PEOPLE already.
    """
    if not (name := clean_line(name)):
        raise Invalid("A player needs a name.")
    if count(session) >= MAX_PEOPLE:
        raise TooManyPeople(f"There are {MAX_PEOPLE:,} people already, and no more can be added.")
    row = PlayerRow(name=name, role=role)
    session.add(row)
    session.flush()
    note_change(session, "player", row.id)
    return row


def rename(session: Session, player: PlayerRow, name: str) -> None:
    """Give a player another name.

    Raises:
        Invalid: It is empty.
        TextRefused: It can't be accepted.
    """
    if not (name := clean_line(name)):
        raise Invalid("A player needs a name.")
    if name != player.name:
        # Before it is changed, so that the entry has the name of then.
        names = {"before": player.name, "after": name}
        audit.note(session, audit.Action.RENAMED, player.id, f"player {player.id}", **names)
    player.name = name
    note_change(session, "player", player.id)


def named(session: Session, name: str, *, owner_counts: bool = True) -> PlayerRow:
    """Return the person of this name who played imported games; added if there is none.

    Nobody who has signed in counts: they would be shown what a namesake did. The owner does, whose
    own games they are as a rule.

    Args:
        session: The transaction.
        name: The name.
        owner_counts: False where it must not be taken for the owner's what a namesake did.
    """
    has_signed_in = exists().where(CredentialRow.player_id == PlayerRow.id)
    is_owner = PlayerRow.role == Role.OWNER
    is_meant = or_(is_owner, ~has_signed_in) if owner_counts else ~is_owner & ~has_signed_in
    rows = session.scalars(select(PlayerRow).where(is_meant).order_by(PlayerRow.id))
    namesakes = (row for row in rows if folded(row.name) == folded(name))
    return next(namesakes, None) or add(session, name, Role.PARTICIPANT)


def by_id(session: Session, ids: Collection[int]) -> dict[int, PlayerRow]:
    """Return people by id."""
    query = select(PlayerRow).where(PlayerRow.id.in_(ids))
    return {row.id: row for row in session.scalars(query)}


def names(session: Session) -> dict[int, str]:
    """Return every player's name by id."""
    return {row.id: row.name for row in session.scalars(select(PlayerRow))}
