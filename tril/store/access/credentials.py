"""What lets browsers and scripts in. Secrets are random; only their hashes are stored."""

from __future__ import annotations

import base64
import hashlib
import hmac
import secrets
from collections.abc import Collection
from dataclasses import dataclass, field
from datetime import timedelta

from sqlalchemy import ColumnElement, or_, select, update
from sqlalchemy.orm import Session

from tril.errors import Conflict, Invalid, NotFound
from tril.store import audit
from tril.store.changes import note_change
from tril.store.models import (
    CredentialKind,
    CredentialRow,
    MembershipRow,
    PlayerRow,
    Role,
    now,
)
from tril.text import clean_line, shown_line

BROWSER_LIFETIME = timedelta(days=180)

CHANGES = "access"
"""Topic of what shuts somebody out; the key is a credential's id, or ALL."""
ALL = "all"

MAX_KEYS = 100


@dataclass(frozen=True)
class Identity:
    """Who makes a request.

    Attributes:
        credential_id: The browser or key that shows who it is.
        kind: Kind of the credential.
        player_id: The person.
        role: Role of the player.
        behaviour_ids: Behaviours that a participant plays.
        secret_hash: The hash of the credential's secret.
    """

    credential_id: int
    kind: CredentialKind
    player_id: int
    role: Role
    behaviour_ids: frozenset[int]
    secret_hash: str = field(repr=False)

    @property
    def is_participant(self) -> bool:
        """Whether only their own games concern them."""
        return self.role is Role.PARTICIPANT

    @property
    def visible_player_id(self) -> int | None:
        """The only player whose recordings this identity sees; None for all players."""
        return self.player_id if self.is_participant else None


def new_secret() -> str:
    """Return a random secret."""
    return secrets.token_urlsafe(24)


def secret_from(secret: str, key: str) -> str:
    """Return the secret that a link's secret and a random key make, always the same one."""
    digest = hmac.digest(secret.encode(), key.encode(), "sha256")
    return base64.urlsafe_b64encode(digest[:24]).decode()


def hash_of(secret: str) -> str:
    """Return the stored hash of a secret; it is random, so it needs no slow hash."""
    return hashlib.sha256(secret.encode()).hexdigest()


def sign_in(
    session: Session,
    player_id: int,
    browser: str,
    invitation_id: int | None = None,
    secret: str | None = None,
) -> str:
    """Let a browser in as a person, and return the secret for its cookie, by default a new one."""
    secret = secret or new_secret()
    row = CredentialRow(
        kind=CredentialKind.BROWSER,
        player_id=player_id,
        invitation_id=invitation_id,
        name=shown_line(browser, 80) or "Unknown browser",
        secret_hash=hash_of(secret),
        seen_at=now(),
    )
    session.add(row)
    session.flush()
    audit.note(session, audit.Action.SIGNED_IN, player_id, f"browser {row.id}", browser=row.name)
    return secret


def make_key(session: Session, player_id: int, name: str, role: Role) -> tuple[CredentialRow, str]:
    """Make a key with which a script acts for a person, and return it with its secret.

    Raises:
        Invalid: It has no name, or a participant's role.
        Conflict: There are MAX_KEYS already.
    """
    if not (name := clean_line(name)):
        raise Invalid("Say what the key is for, so that you can tell it from others.")
    if role is Role.PARTICIPANT:
        raise Invalid("A key is an owner's or a researcher's; participants play in a browser.")
    if len(listing(session, CredentialKind.KEY)) >= MAX_KEYS:
        raise Conflict(f"There are {MAX_KEYS} keys already; revoke some first.")
    secret = new_secret()
    row = CredentialRow(
        kind=CredentialKind.KEY,
        player_id=player_id,
        role=role,
        name=name,
        secret_hash=hash_of(secret),
    )
    session.add(row)
    session.flush()
    audit.note(session, audit.Action.KEY_MADE, player_id, f"key {row.id}", name=row.name, role=role)
    return row, secret


def find(session: Session, secret_hash: str) -> Identity | None:
    """Return whom a credential lets in; None if it was ended, is too old or unknown."""
    query = (
        select(CredentialRow, PlayerRow.role)
        .join(PlayerRow, CredentialRow.player_id == PlayerRow.id)
        .where(CredentialRow.secret_hash == secret_hash, _is_valid())
    )
    match = session.execute(query).one_or_none()
    if match is None:
        return None
    row, persons_role = match
    memberships = select(MembershipRow.behaviour_id).where(MembershipRow.player_id == row.player_id)
    return Identity(
        row.id,
        CredentialKind(row.kind),
        row.player_id,
        Role(row.role or persons_role),
        frozenset(session.scalars(memberships)),
        secret_hash,
    )


def listing(
    session: Session,
    kind: CredentialKind,
    before: int | None = None,
    limit: int | None = None,
) -> list[CredentialRow]:
    """Return the credentials of a kind that still let somebody in, newest first.

    Args:
        session: The transaction.
        kind: Browsers or keys.
        before: Only those with lower ids.
        limit: Most of them that are returned.
    """
    query = select(CredentialRow).where(CredentialRow.kind == kind, _is_valid())
    if before is not None:
        query = query.where(CredentialRow.id < before)
    return list(session.scalars(query.order_by(CredentialRow.id.desc()).limit(limit)))


def end(
    session: Session, kind: CredentialKind, credential_id: int, by_player_id: int | None
) -> None:
    """Sign a browser out or revoke a key; harmless if that is done already.

    Raises:
        NotFound: There is none of this kind.
    """
    row = session.get(CredentialRow, credential_id)
    if row is None or row.kind != kind:
        raise NotFound(f"There is no {kind} {credential_id}.")
    if row.ended_at is not None:
        return
    row.ended_at = now()
    is_browser = kind is CredentialKind.BROWSER
    action = audit.Action.SIGNED_OUT if is_browser else audit.Action.KEY_REVOKED
    audit.note(session, action, by_player_id, f"{kind} {row.id}", name=row.name)
    note_change(session, CHANGES, row.id)


def sign_out_all_browsers(session: Session, by_player_id: int | None = None) -> int:
    """Sign every browser out and return their number; keys stay valid."""
    rows = listing(session, CredentialKind.BROWSER)
    for row in rows:
        row.ended_at = now()
    audit.note(session, audit.Action.ALL_SIGNED_OUT, by_player_id, "", browsers=len(rows))
    note_change(session, CHANGES, ALL)
    return len(rows)


def note_use(session: Session, credential_ids: Collection[int]) -> None:
    """Note the current time as the last use of credentials."""
    query = update(CredentialRow).where(CredentialRow.id.in_(credential_ids))
    session.execute(query.values(seen_at=now()))


def _is_valid() -> ColumnElement[bool]:
    is_young = CredentialRow.created_at > now() - BROWSER_LIFETIME
    return CredentialRow.ended_at.is_(None) & or_(
        CredentialRow.kind == CredentialKind.KEY, is_young
    )
