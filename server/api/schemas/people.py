"""Who gets in, and what they did."""

from __future__ import annotations

from datetime import datetime
from typing import Any, Literal

from pydantic import Field

from server.api.schemas.base import Id, Schema
from tril.store.access.invitations import DEFAULT_DAYS, DEFAULT_USES, MAX_DAYS, MAX_USES
from tril.store.audit import Action
from tril.store.models import Role
from tril.text import Line


class Player(Schema):
    """A person, and what they may do here."""

    id: int
    name: str
    role: Role


class PlayerUpdate(Schema):
    """A player's new name."""

    name: Line = Field(min_length=1, max_length=80)


class Person(Player):
    """Somebody who has been let in. ``behaviour_ids`` is what they play as a participant."""

    behaviour_ids: list[int]


class RoleUpdate(Schema):
    """What somebody is to be; a participant plays ``behaviour_id`` besides what they did before."""

    role: Literal[Role.RESEARCHER, Role.PARTICIPANT]
    behaviour_id: Id | None = None


class Credential(Schema):
    """What lets a person in."""

    id: int
    name: str
    player: str
    role: Role
    created_at: datetime
    seen_at: datetime | None


class Browser(Credential):
    """A browser that is signed in. ``present`` is the one that asks."""

    present: bool


class Key(Credential):
    """A key with which scripts and workers act for a person."""


class KeyNew(Schema):
    """A key to make."""

    name: Line = Field(min_length=1, max_length=80)
    role: Literal[Role.OWNER, Role.RESEARCHER, Role.WORKER] = Role.RESEARCHER


class NewKey(Key):
    """A key that was made; ``key`` is shown only now."""

    key: str


class Invitation(Schema):
    """A link that lets people in, until it is revoked, used up or expired.

    ``max_uses`` and ``expires_at`` are null for links of earlier versions, which have no bounds.
    """

    id: int
    name: str
    role: Role
    behaviour_id: int | None
    created_at: datetime
    n_used: int
    max_uses: int | None
    expires_at: datetime | None


class InvitationNew(Schema):
    """An invitation to make; participants are invited to one behaviour.

    It lets ``max_uses`` people in, and nobody after some days.
    """

    name: Line = Field(min_length=1, max_length=80)
    role: Literal[Role.RESEARCHER, Role.PARTICIPANT] = Role.PARTICIPANT
    behaviour_id: Id | None = None
    max_uses: int = Field(default=DEFAULT_USES, strict=True, ge=1, le=MAX_USES)
    days: int = Field(default=DEFAULT_DAYS, strict=True, ge=1, le=MAX_DAYS)


class NewInvitation(Invitation):
    """An invitation that was made; ``path``, its link on this server, is shown only now."""

    path: str


class AuditEntry(Schema):
    """Something that somebody did; ``player`` is what they were called then.

    It and ``player_id`` are null for commands in the terminal.
    """

    id: int
    at: datetime
    player_id: int | None
    player: str | None
    action: Action
    subject: str
    details: dict[str, Any]
