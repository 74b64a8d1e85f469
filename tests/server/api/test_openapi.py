"""Every answer of the API conforms to its OpenAPI document."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import schemathesis
from hypothesis import HealthCheck, settings
from schemathesis import Case, HookContext, SerializationContext
from schemathesis.checks import not_a_server_error
from schemathesis.specs.openapi.checks import (
    content_type_conformance,
    negative_data_rejection,
    response_schema_conformance,
    status_code_conformance,
    unsupported_method,
)

from server.app import create_app
from testsupport.live import LiveServer
from tril.settings import Settings

DOCUMENT = Path(__file__).resolve().parents[3] / "frontend" / "openapi.json"
CHECKS = (
    not_a_server_error,
    status_code_conformance,
    content_type_conformance,
    response_schema_conformance,
    negative_data_rejection,
    unsupported_method,
)

MANY_GAMES = range(3, 61)
ANSWER_TIMEOUT_S = 60
"""A recording as a GIF is drawn when it is first asked for, on whatever core is left."""


def test_the_document_that_the_frontend_is_generated_from_is_current() -> None:
    current = create_app(Settings.model_construct()).openapi()
    assert json.loads(DOCUMENT.read_text()) == json.loads(json.dumps(current)), (
        "write it anew: python -m server.openapi > frontend/openapi.json"
    )


@schemathesis.serializer("application/x-ndjson")
def _json_lines(_context: SerializationContext, value: Any) -> bytes:
    return b"\n".join(json.dumps(line).encode() for line in [value, value])


@schemathesis.hook
def map_body(context: HookContext, body: Any) -> Any:
    """Ask for two varied games where it would be up to sixty, which take half a minute to play."""
    path = context.operation.path if context.operation else ""
    if path.endswith("/borrowed") and isinstance(body, dict) and body.get("count") in MANY_GAMES:
        return body | {"count": 2}
    return body


def _readable(document: Any) -> Any:
    """Say ``items`` for ``prefixItems``, whose kinds are equal here: schemathesis 4.32 writes them
    as a list of items, which it then refuses itself.
    """
    if isinstance(document, list):
        return [_readable(item) for item in document]
    if not isinstance(document, dict):
        return document
    written = {key: _readable(value) for key, value in document.items()}
    if "prefixItems" in written:
        kinds = written.pop("prefixItems")
        written["items"] = kinds[-1]
    return written


# A stream of events never ends; tests/server/api/test_events.py reads it. Who is signed out gets
# 401 from then on; tests/server/web/test_access.py does so.
schema = schemathesis.openapi.from_dict(_readable(json.loads(DOCUMENT.read_text()))).exclude(
    path=["/api/events", "/api/sign-out", "/api/browsers/{browser_id}"]
)


@schema.parametrize()
@settings(
    max_examples=8,
    deadline=None,
    derandomize=True,
    database=None,
    suppress_health_check=list(HealthCheck),
)
def test_every_answer_is_one_that_the_document_describes(case: Case[Any], live: LiveServer) -> None:
    case.call_and_validate(
        base_url=f"http://{live.authority}",
        headers={"Cookie": str(live.http.headers["Cookie"])},
        checks=list(CHECKS),
        timeout=ANSWER_TIMEOUT_S,
    )
