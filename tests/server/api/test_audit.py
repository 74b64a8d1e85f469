"""The audit log: who did what, and what they were called then."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from starlette.testclient import TestClient
from typer.testing import CliRunner

from cli.main import app
from tests.server.clients import build_frontend, signed_in
from testsupport.databases import on_postgresql
from testsupport.workplace import Workplace, make_workplace
from tril.store import audit


@pytest.fixture(scope="module")
def workplace(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Workplace]:
    made = make_workplace(tmp_path_factory.mktemp("audit") / "data")
    yield made
    made.database.close()


@pytest.fixture(scope="module")
def client(workplace: Workplace, tmp_path_factory: pytest.TempPathFactory) -> Iterator[TestClient]:
    with signed_in(workplace, build_frontend(tmp_path_factory.mktemp("page"))) as found:
        yield found


def _newest(client: TestClient, n: int = 1) -> list[dict[str, Any]]:
    return list(client.get("/api/audit", params={"limit": n}).json())


def test_an_entry_keeps_the_name_of_then(client: TestClient) -> None:
    client.patch("/api/player", json={"name": "Ada"})
    client.post("/api/keys", json={"name": "x"})
    client.patch("/api/player", json={"name": "Ben"})
    renamed, made = _newest(client, 2)
    assert (made["player"], made["action"]) == ("Ada", "made a key")
    assert (renamed["action"], renamed["player"]) == ("renamed", "Ada")
    assert renamed["details"] == {"before": "Ada", "after": "Ben"}
    assert renamed["player_id"] == made["player_id"] is not None
    client.patch("/api/player", json={"name": "Ben"})
    assert _newest(client) == [renamed]


def test_marks_notes_and_renamings_are_logged(client: TestClient, workplace: Workplace) -> None:
    recording, _, other, _ = workplace.ranked
    run_id = workplace.make_run()
    path = f"/api/recordings/{recording}"
    for method, url, body, said in (
        ("PATCH", path, {"perfect": False}, ("unmarked as perfect", f"recording {recording}")),
        ("PATCH", path, {"perfect": True}, ("marked as perfect", f"recording {recording}")),
        ("PATCH", path, {"notes": "x"}, ("wrote notes", f"recording {recording}")),
        (
            "POST",
            "/api/behaviours/1/recordings/change",
            {"recording_ids": [other], "change": "mark_perfect"},
            ("marked as perfect", f"recording {other}"),
        ),
        ("PATCH", f"/api/runs/{run_id}", {"name": "x"}, ("renamed", f"run {run_id}")),
        ("PATCH", f"/api/runs/{run_id}", {"notes": "x"}, ("wrote notes", f"run {run_id}")),
        ("PATCH", "/api/behaviours/1", {"name": "Left"}, ("renamed", "behaviour 1")),
        ("PATCH", "/api/behaviours/1", {"description": "x"}, ("changed", "behaviour 1")),
    ):
        if body == {"perfect": False}:
            client.patch(path, json={"perfect": True})
        assert client.request(method, url, json=body).is_success
        (entry,) = _newest(client)
        assert (entry["action"], entry["subject"]) == said
        if said[1].startswith("recording"):
            assert entry["details"] == {"number": int(said[1].split()[1]), "behaviour": 1}
        assert entry["player_id"] is not None
        client.request(method, url, json=body)
        assert _newest(client) == [entry], "nothing was changed, so nothing is logged"


def test_exports_are_logged(client: TestClient, workplace: Workplace) -> None:
    recording = workplace.ranked[0]
    client.get(f"/api/recordings/{recording}/export")
    client.get("/api/behaviours/1/recordings/export")
    behaviour, one = _newest(client, 2)
    assert (one["action"], one["subject"]) == ("exported", f"recording {recording}")
    assert (behaviour["action"], behaviour["subject"]) == ("exported", "behaviour 1")
    assert behaviour["details"] == {"recordings": 4}


def test_what_commands_take_away_is_logged(
    workplace: Workplace, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("TRIL_DATA", str(workplace.settings.data))
    monkeypatch.setenv("TRIL_DATABASE_URL", workplace.settings.database_url)
    out = str(tmp_path / "out")
    commands = [
        ["recordings", "export", "-b", "column-1", "-o", out],
        ["behaviours", "export", "column-1", "-o", out],
    ]
    if not on_postgresql():
        commands.append(["backup", str(tmp_path / "backup")])
    for command in commands:
        done = CliRunner().invoke(app, command)
        assert done.exit_code == 0, done.output
    with workplace.database.reading() as session:
        said = [(row.action, row.player_id) for row in audit.page(session, limit=len(commands))]
    assert said[-2:] == [("exported", None), ("exported", None)]
    assert on_postgresql() or said[0] == ("backed up", None)
