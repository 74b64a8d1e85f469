"""Error responses: each is a Problem that says what is wrong and what to do."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from itertools import islice
from typing import Any

from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from pydantic import BaseModel, ConfigDict
from sqlalchemy.exc import DBAPIError
from starlette.exceptions import HTTPException
from starlette.responses import JSONResponse, Response

from tril.errors import Conflict, Forbidden, Invalid, NotFound, TrilError, Unavailable
from tril.store.database import DatabaseReplaced, is_busy, is_unreachable
from tril.text import TextRefused, printable

_LOG = logging.getLogger(__name__)

_STATUS: Mapping[type[TrilError], int] = {
    Forbidden: 403,
    NotFound: 404,
    Conflict: 409,
    Invalid: 422,
    Unavailable: 503,
}

MAX_ERRORS = 20
"""Most errors of a request that are listed."""

DISK_FULL = (
    "The disk is full, so nothing more can be saved. What was saved is safe. Free some space and "
    "try again."
)
DATABASE_BUSY = "The database is busy with another change. Try again in a moment."
DATABASE_AWAY = (
    "The database can't be reached, so it is not known whether this was saved. What was saved "
    "before is safe. Look again in a moment."
)
DATABASE_REPLACED = (
    "The data folder was moved, removed or replaced while Tril was running, so nothing more can be "
    "saved. Put it back, or stop Tril and start it again."
)
DISK_FAILED = (
    "The disk reports an error, so nothing more can be saved. What was saved is safe. Check the "
    "disk and try again."
)


class Problem(BaseModel):
    """The body of every error. ``detail`` says what is wrong and what to do."""

    model_config = ConfigDict(extra="forbid")

    detail: str
    errors: list[dict[str, Any]] | None = None


PROBLEMS: dict[int | str, dict[str, Any]] = {
    400: {"model": Problem, "description": "The request can't be read."},
    401: {"model": Problem, "description": "Open the address that Tril printed first."},
    403: {"model": Problem, "description": "You may not do this, or it comes from another site."},
    413: {"model": Problem, "description": "The body is too large."},
    422: {"model": Problem, "description": "What was given can't be accepted."},
    503: {"model": Problem, "description": "A part of Tril is not running or out of room."},
}
"""Errors that any route may answer."""

NOT_FOUND: dict[int | str, dict[str, Any]] = {
    404: {"model": Problem, "description": "It does not exist."}
}
CONFLICT: dict[int | str, dict[str, Any]] = {
    409: {"model": Problem, "description": "The current state does not allow it."}
}


def problem(status: int, detail: str, errors: list[dict[str, Any]] | None = None) -> JSONResponse:
    """Build an error response."""
    # They quote what was sent, which need not be text that UTF-8 can hold.
    printable_errors = None if errors is None else _printable_errors(errors)
    body = Problem(detail=printable(detail, keep="\n"), errors=printable_errors).model_dump()
    return JSONResponse(body, status_code=status)


def _printable_errors(errors: list[dict[str, Any]]) -> list[dict[str, Any]]:
    return [
        {"where": [printable(part) for part in error["where"]], "what": printable(error["what"])}
        for error in errors
    ]


def explain_database_error(error: DBAPIError) -> Unavailable | None:
    """Return the user's remedy for a database error, None if it is unknown."""
    text = str(error.orig).lower()
    if "disk is full" in text or "no space left" in text:
        return Unavailable(DISK_FULL)
    if isinstance(error, DatabaseReplaced):
        return Unavailable(DATABASE_REPLACED)
    if is_busy(error):
        return Unavailable(DATABASE_BUSY)
    if "disk i/o error" in text or "unable to open database file" in text:
        return Unavailable(DISK_FAILED)
    if is_unreachable(error):
        return Unavailable(DATABASE_AWAY)
    return None


def describe_once(document: dict[str, Any]) -> None:
    """Remove from an OpenAPI document what it says again: errors of each operation, titles.

    Errors that are alike become references to one description. Titles repeat names.

    Args:
        document: The document, which is changed.
    """
    shared: dict[str, Any] = document["components"].setdefault("responses", {})
    for operations in document["paths"].values():
        for operation in operations.values():
            for status, response in operation["responses"].items():
                if status >= "4" and shared.setdefault(status, response) == response:
                    operation["responses"][status] = {"$ref": f"#/components/responses/{status}"}
    _drop_titles(document["components"])
    _drop_titles(document["paths"])


def _drop_titles(part: Any) -> None:
    if isinstance(part, dict) and isinstance(part.get("title"), str):
        del part["title"]
    inner = part.values() if isinstance(part, dict) else part if isinstance(part, list) else ()
    for value in inner:
        _drop_titles(value)


def install(app: FastAPI, headers: Mapping[str, str]) -> None:
    """Answer every error of an application with a Problem.

    Args:
        app: The application.
        headers: Headers of the answer to an unexpected error, which no middleware sees.
    """

    async def on_unexpected_error(_request: Request, _error: Exception) -> Response:
        answer = problem(500, "An unexpected error occurred. The server's log says more.")
        answer.headers.update({**headers, "Cache-Control": "no-store"})
        return answer

    app.add_exception_handler(Exception, on_unexpected_error)
    app.add_exception_handler(TrilError, _on_tril_error)
    app.add_exception_handler(HTTPException, _on_http_exception)
    app.add_exception_handler(RequestValidationError, _on_validation_error)
    app.add_exception_handler(DBAPIError, _on_database_error)


def status_of(error: TrilError) -> int:
    """Return the HTTP status of an error."""
    for kind, status in _STATUS.items():
        if isinstance(error, kind):
            return status
    return 400


async def _on_tril_error(_request: Request, error: Exception) -> Response:
    assert isinstance(error, TrilError)
    about = error.field
    errors = None if about is None else [{"where": ["body", about], "what": str(error)}]
    return problem(status_of(error), str(error), errors)


async def _on_http_exception(_request: Request, error: Exception) -> Response:
    assert isinstance(error, HTTPException)
    answer = problem(error.status_code, str(error.detail))
    answer.headers.update(error.headers or {})
    return answer


async def _on_validation_error(_request: Request, error: Exception) -> Response:
    assert isinstance(error, RequestValidationError)
    errors: list[dict[str, Any]] = [
        {"where": [str(part) for part in item["loc"]], "what": validation_message(item)}
        for item in islice(error.errors(), MAX_ERRORS)
    ]
    detail = errors[0]["what"] if errors else "The request can't be read."
    return problem(422, detail, errors)


_WRONG: Mapping[str, str] = {
    "missing": "is missing",
    "extra_forbidden": "is not known here",
    "string_too_short": "is too short",
    "string_too_long": "can have at most {max_length} characters",
    "too_short": "has too few entries",
    "too_long": "can have at most {max_length} entries",
    "greater_than": "has to be more than {gt}",
    "greater_than_equal": "has to be at least {ge}",
    "less_than": "has to be less than {lt}",
    "less_than_equal": "has to be at most {le}",
    "int_type": "has to be a whole number",
    "int_parsing": "has to be a whole number",
    "int_from_float": "has to be a whole number",
    "float_type": "has to be a number",
    "float_parsing": "has to be a number",
    "finite_number": "has to be a number",
    "bool_type": "has to be true or false",
    "bool_parsing": "has to be true or false",
    "string_type": "has to be text",
    "list_type": "has to be a list",
    "tuple_type": "has to be a list",
    "literal_error": "has to be one of {expected}",
    "enum": "has to be one of {expected}",
    "uuid_parsing": "is not an id",
    "uuid_type": "is not an id",
}
"""What is wrong, by Pydantic's kind of error."""


def validation_message(error: Mapping[str, Any]) -> str:
    """Describe a Pydantic error in plain words: "Name is missing."."""
    if error["type"] == "json_invalid":
        return "The request is not valid JSON."
    names = [part for part in error["loc"][1:] if isinstance(part, str)]
    field = names[-1].replace("_", " ").capitalize() if names else "The request"
    if isinstance(reason := error.get("ctx", {}).get("error"), TextRefused):
        return f"{field}: {str(reason)[:1].lower()}{str(reason)[1:]}"
    # Bounds of a text that is cleaned first are checked as those of any sequence.
    is_text = error["type"] in {"too_short", "too_long"} and isinstance(error.get("input"), str)
    wrong = _WRONG.get(f"string_{error['type']}" if is_text else error["type"])
    if wrong is None:
        return f"{field} can't be accepted: {error['msg']}."
    return f"{field} {wrong.format_map(error.get('ctx', {}))}."


async def _on_database_error(request: Request, error: Exception) -> Response:
    assert isinstance(error, DBAPIError)
    explained = explain_database_error(error)
    if explained is None:
        raise error
    _LOG.error("%s %s: %s", request.method, request.url.path, explained)
    return problem(503, str(explained))
