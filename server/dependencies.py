"""FastAPI dependencies: the services, one transaction per request, and a slot to work in."""

from __future__ import annotations

from collections.abc import AsyncIterator, Callable, Hashable, Iterator
from typing import TYPE_CHECKING, Annotated, Any
from uuid import UUID

from fastapi import Depends, Path, Query
from sqlalchemy.orm import Session
from starlette.requests import HTTPConnection

from tril.store.access.credentials import Identity

if TYPE_CHECKING:
    from server.concurrency import ConcurrencyLimit
    from server.services import Services

MAX_ID = 2**31 - 1
MAX_LISTED = 200
"""Most entries of a list in one response, of about a kilobyte each."""


def services_of(connection: HTTPConnection) -> Services:
    """Return the services of the application that handles a request."""
    services: Services = connection.app.state.services
    return services


def _read_session(connection: HTTPConnection) -> Iterator[Session]:
    with services_of(connection).database.reading() as session:
        yield session


def _write_session(connection: HTTPConnection) -> Iterator[Session]:
    with services_of(connection).database.writing() as session:
        yield session


# With scope="function" a transaction is committed before the answer is sent, so that no answer
# tells of something that can still fail.
ReadSession = Annotated[Session, Depends(_read_session, scope="function")]
"""A session that sees one consistent state."""

WriteSession = Annotated[Session, Depends(_write_session, scope="function")]
"""A session whose transaction is committed when the route returns."""

BehaviourId = Annotated[int, Path(ge=1, le=MAX_ID)]
RecordingId = Annotated[int, Path(ge=1, le=MAX_ID)]
ArtifactId = Annotated[int, Path(ge=1, le=MAX_ID)]
RunId = Annotated[UUID, Path()]
GameId = Annotated[UUID, Path()]
PageLimit = Annotated[int, Query(ge=1, le=MAX_LISTED)]


def identity_of(connection: HTTPConnection) -> Identity:
    """Return the identity of an admitted request."""
    identity: Identity = connection.scope["identity"]
    return identity


Who = Annotated[Identity, Depends(identity_of)]
"""Who makes the request."""


def client_of(connection: HTTPConnection) -> Hashable:
    """Return whose turn a request takes: that of a person, or of an address."""
    identity: Identity | None = connection.scope.get("identity")
    if identity is not None:
        return identity.player_id
    return connection.client and connection.client.host


def limited_by(limit_of: Callable[[Services, bool], ConcurrencyLimit]) -> Any:
    """Return a dependency that holds a slot of a limit while a request is handled.

    The slot is taken after FastAPI has read the body and released before the answer is sent.
    People wait in turn, whatever number of browsers and keys they have.

    Args:
        limit_of: Chooses the limit, told whether the request may write.
    """

    async def hold_slot(connection: HTTPConnection) -> AsyncIterator[None]:
        writes = connection.scope["method"] not in {"GET", "HEAD"}
        async with limit_of(services_of(connection), writes).slot(client_of(connection)):
            yield

    return Depends(hold_slot, scope="function")
