"""Texts that come in by the API, and what became of those that earlier versions accepted."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy import text
from starlette.testclient import TestClient
from typer.testing import CliRunner

from cli.main import app
from tests.server.clients import build_frontend, signed_in
from testsupport.libraries import replay_of
from testsupport.workplace import Workplace, make_workplace
from tril.exchange.behaviour_transfer import export_behaviour, import_behaviour
from tril.exchange.formats.recording_object import parse_recording
from tril.logs import PlainFormatter
from tril.store import audit, behaviours, recordings
from tril.store.access import invitations
from tril.store.models import Role, Source
from tril.store.training import runs

SENT = [
    "a\0b",
    "a\x1b[31mb",
    "a\u202eb",
    "a\u200bb",
    "a\ud800b",
    "\ue000",
    "\U000e0041",
    "e" + "\u0316" * 9,
]
ACT = "\x1b]0;act\x07"


@pytest.fixture(scope="module")
def workplace(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Workplace]:
    made = make_workplace(tmp_path_factory.mktemp("texts") / "data")
    yield made
    made.database.close()


@pytest.fixture(scope="module")
def client(workplace: Workplace, tmp_path_factory: pytest.TempPathFactory) -> Iterator[TestClient]:
    with signed_in(workplace, build_frontend(tmp_path_factory.mktemp("page"))) as found:
        yield found


@pytest.mark.parametrize("sent", SENT, ids=ascii)
def test_no_field_takes_text_that_is_not_seen(
    client: TestClient, workplace: Workplace, sent: str
) -> None:
    run_id, recording_id = workplace.make_run(), workplace.ranked[0]
    client.post(f"/api/runs/{run_id}/cancel")
    asked: list[tuple[str, str, dict[str, Any]]] = [
        ("POST", "/api/behaviours", {"name": sent}),
        ("POST", "/api/behaviours", {"name": "x", "description": sent}),
        ("PATCH", "/api/behaviours/1", {"name": sent}),
        ("PATCH", "/api/behaviours/1", {"description": sent}),
        ("PATCH", "/api/player", {"name": sent}),
        ("PATCH", f"/api/recordings/{recording_id}", {"notes": sent}),
        ("PATCH", f"/api/runs/{run_id}", {"name": sent}),
        ("PATCH", f"/api/runs/{run_id}", {"notes": sent}),
        ("POST", "/api/keys", {"name": sent}),
        ("POST", "/api/invitations", {"name": sent, "role": "researcher"}),
        ("POST", "/api/runs", {"behaviour_id": 1, "recipe": sent}),
    ]
    for method, path, body in asked:
        content = json.dumps(body).encode()
        answer = client.request(
            method, path, content=content, headers={"content-type": "application/json"}
        )
        assert answer.status_code == 422, (path, body, answer.text)
        assert "is U+" in answer.json()["detail"], answer.text
        assert "Remove it" in answer.json()["detail"]


def test_names_of_members_that_are_no_text_are_refused_as_well(client: TestClient) -> None:
    answer = client.patch(
        "/api/player",
        content=b'{"name": "Kim", "\\ud800\\u001b": 1}',
        headers={"content-type": "application/json"},
    )
    assert answer.status_code == 422


@pytest.mark.parametrize("twin", ["column 1", "Column\u00a01", "Ｃolumn 1", " COLUMN  1 "])
def test_a_twin_of_a_behaviours_name_is_refused(client: TestClient, twin: str) -> None:
    answer = client.post("/api/behaviours", json={"name": twin})
    assert answer.status_code == 409, answer.text


def test_names_of_all_scripts_are_kept_composed(client: TestClient) -> None:
    for name in ("می‌خواهم", "שָׁלוֹם", "👩🏽‍🚀 ❤️‍🔥", "Zoe\u0308"):
        added = client.post("/api/behaviours", json={"name": name})
        assert added.status_code == 201, added.text
        assert added.json()["name"] == name.replace("e\u0308", "ë").replace("וֹ", "וֹ")
    assert client.post("/api/behaviours", json={"name": "ZOË"}).status_code == 409


def test_somebody_invited_is_told_what_is_wrong_with_their_name(
    client: TestClient, workplace: Workplace
) -> None:
    with workplace.database.writing() as session:
        _, secret = invitations.make(session, "x", Role.RESEARCHER, None, None)
    signed = client.app.state.services.access.secrets.signed(secret)  # type: ignore[attr-defined]
    given = {"invitation": signed, "name": "K\u200bim"}
    said = client.post("/join", data=given, headers={"accept-language": "en"}).text
    assert "U+200B" in said
    assert "Type the name instead of pasting it" in said
    german = client.post("/join", data=given, headers={"accept-language": "de"}).text
    assert "(U+200B). Tippe den Namen" in german


def test_what_earlier_versions_stored_is_shown_and_exported_such_that_it_is_taken_again(
    client: TestClient, workplace: Workplace
) -> None:
    run_id = workplace.make_run()
    with workplace.database.writing() as session:
        made = behaviours.create(session, "Old", "", ((0, 0),))
        played = recordings.get(session, workplace.ranked[0])
        row = recordings.add(
            session,
            made.id,
            recordings.as_recording(played),
            replay_of(played),
            Source.PERSON,
            player_id=1,
        )
        session.connection().execute(
            text("UPDATE behaviours SET name = :t, description = :t WHERE id = :id"),
            {"t": f"{ACT}a\u202eb", "id": made.id},
        )
        stored = json.dumps({"\x1b": ["a\0b", {"x": "\ud800"}]})
        if session.get_bind().dialect.name == "postgresql":
            stored = json.dumps({"\x1b": ["a\x07b", {"x": "\u202e"}]})
        session.connection().execute(
            text("UPDATE recordings SET notes = :t, conditions = :c WHERE id = :id"),
            {"t": f"{ACT}\nsecond", "c": stored, "id": row.id},
        )
        session.connection().execute(
            text("UPDATE players SET name = :t WHERE id = 1"), {"t": f"Kim{ACT}"}
        )
        session.connection().execute(
            text("UPDATE runs SET name = :t, notes = :t WHERE id = :id"), {"t": ACT, "id": run_id}
        )
    shown = client.get(f"/api/recordings/{row.id}").json()
    assert (shown["behaviour_name"], shown["player"]) == (
        "\ufffd]0;act\ufffda\ufffdb",
        "Kim\ufffd]0;act\ufffd",
    )
    assert shown["notes"] == "\ufffd]0;act\ufffd\nsecond"
    assert client.get(f"/api/recordings/{row.id}/course").status_code == 200
    parse_recording(client.get(f"/api/recordings/{row.id}/export").json())
    with workplace.database.reading() as session:
        content, _ = export_behaviour(session, behaviours.get(session, made.id))
        assert runs.get(session, run_id).notes == "\ufffd]0;act\ufffd"
    added = import_behaviour(workplace.database, json.dumps(content).encode())
    assert added.n_recordings == 1


def test_no_command_prints_what_a_terminal_obeys(
    workplace: Workplace, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    with workplace.database.writing() as session:
        invitations.make(session, "for somebody", Role.RESEARCHER, None, None)
        for table in ("players", "behaviours", "invitations", "credentials"):
            session.connection().execute(
                text(f"UPDATE {table} SET name = :t || id"), {"t": f"[/]{ACT}\x9b\u202e\n"}
            )
        session.connection().execute(text("UPDATE recordings SET notes = :t"), {"t": f"[/x]{ACT}"})
        session.connection().execute(text("UPDATE runs SET message = :t"), {"t": f"[/x]{ACT}"})
        audit.note(session, audit.Action.IMPORTED, None, "x", name=f"[/x]{ACT}")
        run_id = session.scalar(text("SELECT id FROM runs LIMIT 1"))
    monkeypatch.setenv("TRIL_DATA", str(workplace.settings.data))
    monkeypatch.setenv("TRIL_DATABASE_URL", workplace.settings.database_url)
    hostile = tmp_path / f"x{ACT}"
    hostile.write_text(f'{{"{ACT}"')
    for command in (
        ["people", "list"],
        ["audit"],
        ["behaviours", "list"],
        ["recordings", "list", "-b", "column-1"],
        ["runs", "list"],
        ["runs", "show", str(run_id)],
        ["recordings", "import", "-b", "column-1", str(hostile)],
        ["behaviours", "import", str(hostile)],
        ["runs", "import", str(hostile)],
        ["people", "revoke", ACT, "1"],
        ["people", "role", "1", ACT],
        ["runs", "show", ACT],
        ["recordings", "list", "-b", ACT],
        ["recordings", "import", "-b", "column-1", str(tmp_path / f"none{ACT}")],
        [ACT],
        ["people", "list", "--json"],
    ):
        done = CliRunner().invoke(app, command)
        assert done.output
        assert not set(done.output) & set("\x1b\x07\x9b\u202e"), command
        assert done.exit_code in (0, 1, 2), command
        assert done.exception is None or isinstance(done.exception, SystemExit), command


def test_log_entries_are_one_line_that_does_nothing() -> None:
    import logging

    record = logging.LogRecord("x", logging.INFO, "", 0, "a %s", (f"b\n{ACT}\u2028",), None)
    said = PlainFormatter("%(message)s").format(record)
    assert said == "a b\\n\\x1b]0;act\\x07\\u2028"
    try:
        raise ValueError(ACT)
    except ValueError as error:
        failed = logging.LogRecord(
            "x", logging.ERROR, "", 0, "x", (), (ValueError, error, error.__traceback__)
        )
    said = PlainFormatter("%(message)s").format(failed)
    assert said.startswith("x\nTraceback")
    assert said.endswith("ValueError: \\x1b]0;act\\x07")
