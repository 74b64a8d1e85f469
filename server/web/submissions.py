"""The header Idempotency-Key: a POST that is sent twice with one key is done once."""

from __future__ import annotations

import asyncio
import logging
import re

from fastapi import FastAPI, Request
from sqlalchemy.exc import SQLAlchemyError
from starlette.concurrency import run_in_threadpool
from starlette.datastructures import Headers
from starlette.requests import HTTPConnection
from starlette.responses import Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from server.dependencies import identity_of, services_of
from server.web.permissions import NEEDS, Need
from server.web.problems import problem
from tril.store import submissions
from tril.store.database import WRITE_GUARD
from tril.store.submissions import Submission, SubmittedBefore

HEADER = "Idempotency-Key"
REPLAYED = "Idempotency-Replayed"
"""Header of a response that an earlier request with the same key got."""

_KEY = re.compile(r"[\x21-\x7e]{16,64}")
_SECRET = frozenset({Need.OWNER, Need.WORKER})
"""Operations whose response may have a secret, of which the database only has a hash."""

RESPONSE_WAIT_S = 10.0
"""How long a request waits for the response to an earlier one that is being handled."""
_LOOK_EVERY_S = 0.05

DONE_ALREADY = (
    "This was done when it was first sent, but its response is not known any more. Reload the page"
    " to see what it did. A key or link that it made is shown only once: revoke it and make"
    " another."
)

_LOG = logging.getLogger(__name__)


class Submissions:
    """Has the database refuse what was done already, and keeps the responses to what is done."""

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on."""
        if scope["type"] != "http" or scope["method"] != "POST" or "identity" not in scope:
            await self._app(scope, receive, send)
            return
        key = Headers(scope=scope).get(HEADER)
        if key is None:
            await self._app(scope, receive, send)
            return
        if _KEY.fullmatch(key) is None:
            why = f"Expected 16 to 64 printable characters in {HEADER}."
            await problem(400, why)(scope, receive, send)
            return
        connection = HTTPConnection(scope)
        submission = Submission(identity_of(connection).player_id, key)
        submission.content.update(f"{scope['path']}?".encode() + scope["query_string"] + b"\n")

        async def receive_digested() -> Message:
            message = await receive()
            submission.content.update(message.get("body", b""))
            return message

        messages: list[Message] = []

        async def send_kept(message: Message) -> None:
            if submission.row_id is None:
                await send(message)
                return
            # Whoever gets the response can rely on getting it again.
            messages.append(message)
            if message["type"] == "http.response.body" and not message.get("more_body", False):
                await _keep(connection, submission.row_id, messages)
                for part in messages:
                    await send(part)

        token = WRITE_GUARD.set(submission)
        try:
            await self._app(scope, receive_digested, send_kept)
        finally:
            WRITE_GUARD.reset(token)


async def _keep(connection: HTTPConnection, submission_id: int, sent: list[Message]) -> None:
    status: int = sent[0]["status"]
    body = None
    if status < 300 and NEEDS[connection.scope["endpoint"].__name__] not in _SECRET:
        body = b"".join(part.get("body", b"") for part in sent[1:])
    database = services_of(connection).database
    try:
        await run_in_threadpool(submissions.keep_response, database, submission_id, status, body)
    except SQLAlchemyError as error:
        # What was submitted is done. Sent again, it is said to be.
        _LOG.warning("The response to a submission could not be kept: %s", error)


def install(app: FastAPI) -> None:
    """Answer what was submitted before as it was answered then."""
    app.add_exception_handler(SubmittedBefore, _on_submitted_before)


async def _on_submitted_before(request: Request, error: Exception) -> Response:
    assert isinstance(error, SubmittedBefore)
    database = services_of(request).database
    loop = asyncio.get_running_loop()
    until = loop.time() + RESPONSE_WAIT_S
    while True:
        row = await run_in_threadpool(submissions.find, database, error.submission_id)
        is_awaited = row is not None and row.status is None
        if not is_awaited or loop.time() > until:
            break
        await asyncio.sleep(_LOOK_EVERY_S)
    if row is None or row.status is None or row.response is None:
        return problem(409, DONE_ALREADY)
    return Response(
        row.response,
        row.status,
        {REPLAYED: "true"},
        media_type="application/json" if row.response else None,
    )
