"""The people who play and rank: the owner, and those whose games were imported."""

from __future__ import annotations

from sqlalchemy import select
from sqlalchemy.orm import Session

from tril.errors import Invalid, NotFound
from tril.store.changes import note_change
from tril.store.models import PlayerRow, Role

OWNER_NAME = "Player"
"""Name of the owner until it is changed."""


def owner(session: Session) -> PlayerRow:
    """Return the owner; raises NotFound in a database without one."""
    row = session.scalar(
        select(PlayerRow).where(PlayerRow.role == Role.OWNER).order_by(PlayerRow.id).limit(1)
    )
    if row is None:
        raise NotFound("The database has no owner yet; run `tril migrate`.")
    return row


def lock(session: Session, player_id: int) -> None:
    """Make other transactions that lock this player wait until this one is over."""
    session.execute(select(PlayerRow.id).where(PlayerRow.id == player_id).with_for_update())


def seed_owner(session: Session) -> None:
    """Add the owner where there is none."""
    if session.scalar(select(PlayerRow.id).where(PlayerRow.role == Role.OWNER)) is None:
        session.add(PlayerRow(name=OWNER_NAME, role=Role.OWNER))
        session.flush()


def rename(session: Session, player: PlayerRow, name: str) -> None:
    """Give a player another name."""
    if not name.strip():
        raise Invalid("A player needs a name.")
    player.name = name.strip()
    note_change(session, "player", player.id)


def named(session: Session, name: str) -> PlayerRow:
    """Return the oldest player of this name; without one a participant is added."""
    row = session.scalar(
        select(PlayerRow).where(PlayerRow.name == name).order_by(PlayerRow.id).limit(1)
    )
    if row is None:
        row = PlayerRow(name=name, role=Role.PARTICIPANT)
        session.add(row)
        session.flush()
        note_change(session, "player", row.id)
    return row


def names(session: Session) -> dict[int, str]:
    """Return every player's name by id."""
    return {row.id: row.name for row in session.scalars(select(PlayerRow))}
