"""Who is signed in, what lets people in, and the log of what they did."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Path, Query, Request, Response

from server.api.schemas.people import (
    AuditEntry,
    Browser,
    Invitation,
    InvitationNew,
    Key,
    KeyNew,
    NewInvitation,
    NewKey,
    Person,
    Player,
    PlayerUpdate,
    RoleUpdate,
)
from server.dependencies import (
    MAX_ID,
    MAX_LISTED,
    PageLimit,
    ReadSession,
    Who,
    WriteSession,
    services_of,
)
from server.web.problems import CONFLICT, NOT_FOUND
from tril.store import audit, players
from tril.store.access import credentials, invitations, roles
from tril.store.models import CredentialKind
from tril.text import shown_json

router = APIRouter(tags=["people"])

Before = Annotated[int | None, Query(ge=1, le=MAX_ID, description="Only those with lower ids.")]
PersonsId = Annotated[int, Path(ge=1, le=MAX_ID)]


@router.get("/player")
def get_player(session: ReadSession, identity: Who) -> Player:
    """Return who is signed in."""
    return Player.of(players.get(session, identity.player_id), role=identity.role)


@router.patch("/player")
def update_player(session: WriteSession, identity: Who, update: PlayerUpdate) -> Player:
    """Change one's own name."""
    row = players.get(session, identity.player_id)
    players.rename(session, row, update.name)
    return Player.of(row, role=identity.role)


@router.post("/sign-out", status_code=204, responses=NOT_FOUND)
def sign_out(request: Request, response: Response, session: WriteSession, identity: Who) -> None:
    """Sign this browser out. A key can't sign out; it is revoked."""
    credentials.end(session, CredentialKind.BROWSER, identity.credential_id, identity.player_id)
    response.delete_cookie(services_of(request).access.cookie_name, path="/", samesite="strict")


@router.get("/people")
def list_people(
    session: ReadSession,
    after: Annotated[int, Query(ge=0, le=MAX_ID, description="Only those with higher ids.")] = 0,
    limit: PageLimit = MAX_LISTED,
) -> list[Person]:
    """Return who has been let in, and the owner.

    At most 200 are returned: ask for further ones with ``after``.
    """
    return [Person.of(person) for person in roles.people(session, after, limit)]


@router.put("/people/{player_id}/role", status_code=204, responses={**NOT_FOUND, **CONFLICT})
def change_role(
    session: WriteSession, identity: Who, player_id: PersonsId, update: RoleUpdate
) -> None:
    """Make somebody a researcher or a participant, which takes effect within seconds."""
    roles.change(session, player_id, update.role, update.behaviour_id, identity.player_id)


@router.get("/browsers")
def list_browsers(
    session: ReadSession, identity: Who, before: Before = None, limit: PageLimit = MAX_LISTED
) -> list[Browser]:
    """Return the browsers that are signed in, the newest first.

    At most 200 are returned: ask for further ones with ``before``.
    """
    rows = credentials.listing(session, CredentialKind.BROWSER, before, limit)
    people = players.by_id(session, {row.player_id for row in rows})
    return [
        Browser.of(
            row,
            player=people[row.player_id].name,
            role=people[row.player_id].role,
            present=row.id == identity.credential_id,
        )
        for row in rows
    ]


@router.delete("/browsers/{browser_id}", status_code=204, responses=NOT_FOUND)
def sign_browser_out(session: WriteSession, identity: Who, browser_id: PersonsId) -> None:
    """Sign a browser out, which takes effect within seconds."""
    credentials.end(session, CredentialKind.BROWSER, browser_id, identity.player_id)


@router.get("/keys")
def list_keys(session: ReadSession) -> list[Key]:
    """Return the keys, 100 at most, the newest first."""
    rows = credentials.listing(session, CredentialKind.KEY)
    people = players.by_id(session, {row.player_id for row in rows})
    return [Key.of(row, player=people[row.player_id].name) for row in rows]


@router.post("/keys", status_code=201, responses=CONFLICT)
def create_key(request: Request, session: WriteSession, identity: Who, new: KeyNew) -> NewKey:
    """Make a key, to be sent as ``Authorization: Bearer KEY``."""
    row, secret = credentials.make_key(session, identity.player_id, new.name, new.role)
    signed = services_of(request).access.secrets.signed(secret)
    return NewKey.of(row, player=players.get(session, identity.player_id).name, key=signed)


@router.delete("/keys/{key_id}", status_code=204, responses=NOT_FOUND)
def revoke_key(session: WriteSession, identity: Who, key_id: PersonsId) -> None:
    """Revoke a key, which takes effect within seconds."""
    credentials.end(session, CredentialKind.KEY, key_id, identity.player_id)


@router.get("/invitations")
def list_invitations(
    session: ReadSession, before: Before = None, limit: PageLimit = MAX_LISTED
) -> list[Invitation]:
    """Return the invitations that were not revoked, the newest first.

    At most 200 are returned: ask for further ones with ``before``.
    """
    rows = invitations.listing(session, before, limit)
    return [Invitation.model_validate(row) for row in rows]


@router.post("/invitations", status_code=201, responses=NOT_FOUND)
def create_invitation(
    request: Request, session: WriteSession, identity: Who, new: InvitationNew
) -> NewInvitation:
    """Make a link that lets people in."""
    row, secret = invitations.make(
        session,
        new.name,
        new.role,
        new.behaviour_id,
        by_player_id=identity.player_id,
        max_uses=new.max_uses,
        days=new.days,
    )
    signed = services_of(request).access.secrets.signed(secret)
    return NewInvitation.of(row, path=f"{invitations.PATH}?invitation={signed}")


@router.delete("/invitations/{invitation_id}", status_code=204, responses=NOT_FOUND)
def revoke_invitation(session: WriteSession, identity: Who, invitation_id: PersonsId) -> None:
    """Revoke a link. Those who have used it stay until they are signed out."""
    invitations.revoke(session, invitation_id, identity.player_id)


@router.get("/audit")
def list_audit(
    session: ReadSession,
    before: Annotated[int | None, Query(ge=1, le=MAX_ID, description="An entry's id.")] = None,
    limit: Annotated[int, Query(ge=1, le=200)] = 50,
) -> list[AuditEntry]:
    """Return who did what, the newest first, only what is older than the entry ``before``."""
    return [
        AuditEntry.of(row, player=row.player_name, details=shown_json(row.details))
        for row in audit.page(session, before, limit)
    ]
