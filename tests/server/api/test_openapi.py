"""Every answer of the API conforms to its OpenAPI document.

    API_EXAMPLES=64 python -m pytest -s --timeout 0 tests/server/api/test_openapi.py

asks more, up to 64 times for every operation beside its corner cases, and prints how many calls
that came to.
"""

from __future__ import annotations

import json
import os
import random
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from uuid import UUID

import pytest
import schemathesis
from hypothesis import HealthCheck, settings
from schemathesis import Case, SerializationContext
from schemathesis.checks import not_a_server_error
from schemathesis.specs.openapi.checks import (
    content_type_conformance,
    negative_data_rejection,
    response_schema_conformance,
    status_code_conformance,
    unsupported_method,
)
from sqlalchemy import select

from server.app import create_app
from testsupport.finished_runs import make_finished_run
from testsupport.live import LiveServer, live_server
from testsupport.watching import running_inference
from testsupport.workplace import make_workplace
from tril.settings import Settings
from tril.store import players
from tril.store.models import ArtifactRow, Role

DOCUMENT = Path(__file__).resolve().parents[3] / "frontend" / "openapi.json"
CHECKS = (
    not_a_server_error,
    status_code_conformance,
    content_type_conformance,
    response_schema_conformance,
    negative_data_rejection,
    unsupported_method,
)

MANY_GAMES, DEFAULT_GAMES = range(3, 61), 24
EXAMPLES = int(os.environ.get("API_EXAMPLES", "8"))
"""Of each operation."""
REAL = 0.75
"""Share of the valid ids in paths in whose place one of a thing that exists is sent."""

ANSWER_TIMEOUT_S = 240
"""A recording as a GIF is drawn when it is first asked for, on whatever core is left."""


def test_the_document_that_the_frontend_is_generated_from_is_current() -> None:
    current = create_app(Settings.model_construct()).openapi()
    assert json.loads(DOCUMENT.read_text()) == json.loads(json.dumps(current)), (
        "write it anew: python -m server.openapi > frontend/openapi.json"
    )


@schemathesis.serializer("application/x-ndjson")
def _json_lines(_context: SerializationContext, value: Any) -> bytes:
    return b"\n".join(json.dumps(line).encode() for line in [value, value])


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


@dataclass
class World:
    """A server with something of everything.

    Attributes:
        live: The server.
        ids: Of what there is, by the name of the path's parameter.
        answers: How often it answered what.
    """

    live: LiveServer
    ids: dict[str, list[int] | list[str]]
    answers: Counter[int] = field(default_factory=Counter)
    _draws: random.Random = field(default_factory=lambda: random.Random(0))

    def ask_for_few_games(self, case: Case[Any]) -> None:
        """Ask for two varied games instead of sixty, which take half a minute, or of the default.

        A hook of schemathesis would not see the corner cases, sixty among them.
        """
        body = case.body
        if isinstance(body, dict) and body.get("count", DEFAULT_GAMES) in MANY_GAMES:
            case.body = body | {"count": 2}

    def name_real_things(self, case: Case[Any]) -> None:
        """Put ids of what there is in the place of most of a path's valid ones."""
        for name, given in (case.path_parameters or {}).items():
            if name in self.ids and _is_valid(given) and self._draws.random() < REAL:
                case.path_parameters[name] = self._draws.choice(self.ids[name])


def _is_valid(given: Any) -> bool:
    if isinstance(given, int):
        return 1 <= given < 2**31
    try:
        UUID(given)
    except (ValueError, AttributeError, TypeError):
        return False
    return True


@pytest.fixture(scope="module")
def world(tmp_path_factory: pytest.TempPathFactory) -> Iterator[World]:
    """Return a running server with a finished run, and an inference process."""
    made = make_workplace(tmp_path_factory.mktemp("world") / "data")
    run_ids = [make_finished_run(made), made.make_run(), made.make_run()]
    with made.database.writing() as session:
        person_ids = [players.add(session, name, Role.PARTICIPANT).id for name in ("Ada", "Ben")]
        artifact_ids = list(session.scalars(select(ArtifactRow.id)))
    with running_inference(made), live_server(made.settings.data) as live:
        games = [live.new_game() for _ in range(3)]
        invited = {"name": "5b", "role": "participant", "behaviour_id": 1}
        keys = [live.http.post("/api/keys", json={"name": name}).json() for name in "ab"]
        invitations = [live.http.post("/api/invitations", json=invited).json() for _ in "ab"]
        recordings = live.http.get("/api/behaviours/1/recordings?include=policy").json()
        world = World(
            live,
            {
                "behaviour_id": [1, 2, 3],
                "recording_id": [one["id"] for one in recordings],
                "run_id": run_ids,
                "artifact_id": artifact_ids,
                "player_id": person_ids,
                "game_id": [game["id"] for game in games],
                "key_id": [key["id"] for key in keys],
                "invitation_id": [invitation["id"] for invitation in invitations],
            },
        )
        yield world
    made.database.close()
    print(f"\n{world.answers.total()} calls: {dict(sorted(world.answers.items()))}")


@schema.parametrize()
@settings(
    max_examples=EXAMPLES,
    derandomize=True,
    database=None,
    suppress_health_check=list(HealthCheck),
)
def test_every_answer_is_one_that_the_document_describes(case: Case[Any], world: World) -> None:
    world.name_real_things(case)
    if case.operation.path.endswith("/borrowed"):
        world.ask_for_few_games(case)
    answer = case.call_and_validate(
        base_url=f"http://{world.live.authority}",
        headers={"Cookie": str(world.live.http.headers["Cookie"])},
        checks=list(CHECKS),
        timeout=ANSWER_TIMEOUT_S,
    )
    world.answers[answer.status_code] += 1
