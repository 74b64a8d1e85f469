"""Who makes a request: looked up once, remembered briefly, and forgotten when access changes."""

from __future__ import annotations

import asyncio
import time
from collections import Counter, OrderedDict, defaultdict
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from typing import TypeVar

from sqlalchemy.exc import DBAPIError
from sqlalchemy.orm import Session
from starlette.requests import HTTPConnection

from server.web.problems import explain_database_error
from server.web.security import Secrets, cookie_name, is_token, load_secrets
from tril.errors import Unavailable
from tril.settings import Settings
from tril.store.access import credentials
from tril.store.access.credentials import Identity
from tril.store.database import Database
from tril.store.models import CredentialKind

REMEMBERED_FOR_S = 30.0
"""How long an identity is used without asking the database, if no change of access is heard of."""

MAX_REMEMBERED = 4096

MAX_OPEN = 64
"""Most event streams and WebSockets of one person in a process, of 768 connections."""

SEEN_EVERY_S = 60.0
"""How often it is to be saved when browsers and keys were last used."""

Answer = TypeVar("Answer")

End = Callable[[bool], None]
"""Ends what somebody has open; tells whether they may come in again, with other rights."""


class Access:
    """Tells who makes a request, by its cookie or its key.

    What is looked up is remembered until ``forget`` says that access has changed, which the change
    stream does within its half second. Lookups have a thread and a connection of their own: they
    don't wait for requests that work, and a burst of them takes no more than one connection.

    Args:
        settings: The file of the secrets, and the port.
        database: Where browsers and keys are.
    """

    def __init__(self, settings: Settings, database: Database) -> None:
        self.cookie_name = cookie_name(settings)
        self._token_file = settings.token_file
        self.secrets: Secrets = load_secrets(self._token_file)
        self._database = database
        self._remembered: OrderedDict[str, tuple[float, Identity]] = OrderedDict()
        self._n_forgotten = 0
        self._lookups: dict[str, asyncio.Task[Identity | None]] = {}
        self._thread = ThreadPoolExecutor(1, "access")
        self._seen: set[int] = set()
        self._open: defaultdict[str, set[tuple[Identity, End]]] = defaultdict(set)
        self._n_open: Counter[int] = Counter()
        self._checks: set[asyncio.Task[None]] = set()

    async def stop(self) -> None:
        """Stop looking up."""
        for check in list(self._checks):
            check.cancel()
        await asyncio.to_thread(self._thread.shutdown)

    def is_token(self, token: str) -> bool:
        """Whether this is the installation's token."""
        return is_token(self._token_file, token)

    async def identify(self, connection: HTTPConnection) -> Identity | None:
        """Return the identity of a request; None if nobody is signed in."""
        scheme, _, key = connection.headers.get("authorization", "").partition(" ")
        is_key = scheme.lower() == "bearer"
        credential = key.strip() if is_key else connection.cookies.get(self.cookie_name, "")
        secret = self.secrets.secret_in(credential)
        if secret is None:
            return None
        identity = await self._identity(credentials.hash_of(secret))
        if identity is None or (identity.kind == CredentialKind.KEY) != is_key:
            return None
        self._seen.add(identity.credential_id)
        return identity

    async def query(self, read_answer: Callable[[Session], Answer]) -> Answer:
        """Run a short query about access on the database.

        Raises:
            Unavailable: The database can't be read; says what to do.
        """

        def read() -> Answer:
            try:
                with self._database.reading() as session:
                    return read_answer(session)
            except DBAPIError as error:
                raise explain_database_error(error) or error from error

        return await asyncio.get_running_loop().run_in_executor(self._thread, read)

    def forget(self) -> None:
        """Look everybody up again, and end what is open for those whose rights have changed."""
        self._remembered.clear()
        self._n_forgotten += 1
        if self._open:
            check = asyncio.get_running_loop().create_task(self._end_revoked())
            self._checks.add(check)
            check.add_done_callback(self._checks.discard)

    @contextmanager
    def watch_rights(self, identity: Identity, end: End) -> Iterator[None]:
        """Call ``end`` in the event loop if the identity's rights change within the block."""
        ends = self._open[identity.secret_hash]
        ends.add((identity, end))
        self._n_open[identity.player_id] += 1
        try:
            yield
        finally:
            ends.discard((identity, end))
            if not ends:
                self._open.pop(identity.secret_hash, None)
            self._n_open[identity.player_id] -= 1
            if not self._n_open[identity.player_id]:
                del self._n_open[identity.player_id]

    def refuse_too_many_open(self, identity: Identity) -> None:
        """Raise Unavailable if somebody has as many streams open as one person may."""
        if self._n_open[identity.player_id] >= MAX_OPEN:
            raise Unavailable("Too many pages of yours are open. Close some, and try again.")

    async def _identity(self, secret_hash: str) -> Identity | None:
        until, identity = self._remembered.get(secret_hash, (0.0, None))
        if time.monotonic() < until:
            return identity
        lookup = self._lookups.get(secret_hash)
        if lookup is None:
            lookup = asyncio.create_task(self._look_up(secret_hash))
            self._lookups[secret_hash] = lookup
            lookup.add_done_callback(lambda _: self._lookups.pop(secret_hash, None))
        return await asyncio.shield(lookup)

    async def _look_up(self, secret_hash: str) -> Identity | None:
        n_forgotten = self._n_forgotten
        identity = await self.query(lambda session: credentials.find(session, secret_hash))
        if identity is not None and n_forgotten == self._n_forgotten:
            self._remembered[secret_hash] = (time.monotonic() + REMEMBERED_FOR_S, identity)
            while len(self._remembered) > MAX_REMEMBERED:
                self._remembered.popitem(last=False)
        return identity

    async def _end_revoked(self) -> None:
        for secret_hash in list(self._open):
            current = await self._look_up(secret_hash)
            for identity, end in list(self._open.get(secret_hash, ())):
                if current != identity:
                    end(current is not None)

    async def save_last_use(self) -> None:
        """Save which browsers and keys were used since the last call."""
        credential_ids, self._seen = self._seen, set()
        if not credential_ids:
            return

        def save() -> None:
            with self._database.writing() as session:
                credentials.note_use(session, credential_ids)

        await asyncio.to_thread(save)
