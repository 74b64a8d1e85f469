"""What is submitted twice with one Idempotency-Key is done once."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from datetime import timedelta
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy import func, select, update
from starlette.testclient import TestClient

from server.web import submissions as web
from tests.server.clients import build_frontend, signed_in
from testsupport.visitors import cookie_of
from testsupport.workplace import Workplace
from tril.exchange.recording_transfer import export_recording
from tril.store import players, recordings, submissions
from tril.store.access.invitations import FORM_KEY_LENGTH
from tril.store.database import Database
from tril.store.models import (
    Base,
    BehaviourRow,
    CredentialRow,
    GameRow,
    InvitationRow,
    PlayerRow,
    RecordingRow,
    Role,
    RunRow,
    Source,
    SubmissionRow,
    now,
)

KEY = "0123456789abcdef"
RUN = {"behaviour_id": 1, "recipe": "fast", "steps": 1000}


def headers(key: str = KEY) -> dict[str, str]:
    return {"Idempotency-Key": key}


def count(database: Database, table: type[Base]) -> int:
    with database.reading() as session:
        return session.scalar(select(func.count()).select_from(table)) or 0


def test_a_run_that_is_submitted_again_is_the_same_run(
    client: TestClient, workplace: Workplace
) -> None:
    first = client.post("/api/runs", json=RUN, headers=headers())
    again = client.post("/api/runs", json=RUN, headers=headers())
    assert (first.status_code, again.status_code) == (201, 201)
    assert again.json() == first.json()
    assert "Idempotency-Replayed" not in first.headers
    assert again.headers["Idempotency-Replayed"] == "true"
    assert count(workplace.database, RunRow) == 1
    assert client.post("/api/runs", json=RUN).json()["id"] != first.json()["id"]
    other = client.post("/api/runs", json=RUN, headers=headers(KEY[::-1]))
    assert other.json()["id"] != first.json()["id"]


def test_both_in_flight_in_two_servers_make_one(workplace: Workplace, tmp_path: Path) -> None:
    frontend = build_frontend(tmp_path)
    with signed_in(workplace, frontend) as a, signed_in(workplace, frontend) as b:

        def submit(client: TestClient) -> Any:
            return client.post("/api/runs", json=RUN, headers=headers())

        with ThreadPoolExecutor(8) as pool:
            answers = list(pool.map(submit, [a, b] * 4))
    assert {answer.status_code for answer in answers} == {201}
    assert len({answer.json()["id"] for answer in answers}) == 1
    assert count(workplace.database, RunRow) == 1


def import_of(workplace: Workplace) -> bytes:
    with workplace.database.reading() as session:
        row = recordings.get(session, workplace.ranked[0])
        exported = export_recording(session, row)
    return (json.dumps(exported) + "\n").encode()


CREATING: dict[str, tuple[type[Base], Callable[[Workplace], dict[str, Any]]]] = {
    "/api/behaviours": (BehaviourRow, lambda _: {"json": {"name": "Twice"}}),
    "/api/games": (GameRow, lambda _: {"json": {"behaviour_id": 1}}),
    "/api/games/from/1": (GameRow, lambda _: {"json": {"frame": 10}}),
    "/api/behaviours/2/borrowed": (RecordingRow, lambda _: {"json": {"count": 3}}),
    "/api/behaviours/2/ranking/games": (
        SubmissionRow,
        lambda of: {"json": {"recording_ids": [of.ranked[0]]}},
    ),
    "/api/behaviours/2/recordings/import": (
        RecordingRow,
        lambda of: {"content": import_of(of)},
    ),
    "/api/example": (RunRow, lambda _: {}),
}


@pytest.mark.parametrize("path", CREATING)
def test_everything_that_is_created_is_created_once(
    client: TestClient, workplace: Workplace, path: str
) -> None:
    table, request = CREATING[path]
    with workplace.database.writing() as session:
        session.execute(update(RecordingRow).values(source=Source.PERSON))
    first = client.post(path, headers=headers(), **request(workplace))
    n_rows = count(workplace.database, table)
    again = client.post(path, headers=headers(), **request(workplace))
    assert first.is_success, first.text
    assert (again.status_code, again.content) == (first.status_code, first.content)
    assert count(workplace.database, table) == n_rows


@pytest.mark.parametrize(
    ("path", "table", "new"),
    [
        ("/api/keys", CredentialRow, {"name": "Script", "role": "researcher"}),
        ("/api/invitations", InvitationRow, {"name": "Class", "role": "researcher"}),
    ],
)
def test_a_secret_is_not_kept_for_those_who_ask_again(
    client: TestClient, workplace: Workplace, path: str, table: type[Base], new: dict[str, str]
) -> None:
    first = client.post(path, json=new, headers=headers())
    assert first.status_code == 201, first.text
    n_rows = count(workplace.database, table)
    again = client.post(path, json=new, headers=headers())
    assert (again.status_code, again.json()["detail"]) == (409, web.DONE_ALREADY)
    assert count(workplace.database, table) == n_rows
    with workplace.database.reading() as session:
        assert session.scalars(select(SubmissionRow.response)).all() == [None]


def test_a_key_is_not_used_for_something_else(client: TestClient, workplace: Workplace) -> None:
    client.post("/api/runs", json=RUN, headers=headers())
    for path, new in (("/api/runs", {**RUN, "steps": 2000}), ("/api/behaviours", {"name": "New"})):
        answer = client.post(path, json=new, headers=headers())
        assert answer.status_code == 422
        assert "used for another request" in answer.json()["detail"]
    assert count(workplace.database, RunRow) == 1


@pytest.mark.parametrize("key", ["short", "x" * 65, "with a space in it", "ümlaut" * 4])
def test_a_key_that_is_none_is_refused(client: TestClient, key: str) -> None:
    sent = [(b"Idempotency-Key", key.encode())]
    assert client.post("/api/runs", json=RUN, headers=sent).status_code == 400


def test_what_was_refused_may_be_submitted_again(client: TestClient, workplace: Workplace) -> None:
    behaviour = {"name": "Twice"}
    taken = client.post("/api/behaviours", json=behaviour).json()
    assert client.post("/api/behaviours", json=behaviour, headers=headers()).status_code == 409
    client.delete(f"/api/behaviours/{taken['id']}")
    assert client.post("/api/behaviours", json=behaviour, headers=headers()).status_code == 201


def test_the_keys_of_another_person_are_others(client: TestClient, workplace: Workplace) -> None:
    mine = client.post("/api/runs", json=RUN, headers=headers()).json()
    with workplace.database.writing() as session:
        other = players.add(session, "Other", Role.RESEARCHER).id
    client.cookies.clear()
    client.cookies.set(*cookie_of(workplace.settings, other))
    theirs = client.post("/api/runs", json=RUN, headers=headers())
    assert theirs.status_code == 201
    assert theirs.json()["id"] != mine["id"]


def test_keys_are_kept_for_a_day_and_not_without_number(
    client: TestClient, workplace: Workplace, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(submissions, "MAX_PER_PLAYER", 3)
    for number in range(5):
        new = {"name": f"Behaviour {number}"}
        client.post("/api/behaviours", json=new, headers=headers(f"{KEY}-{number}"))
    assert count(workplace.database, SubmissionRow) == 3
    past = now() - submissions.LIFETIME - timedelta(seconds=1)
    with workplace.database.writing() as session:
        session.execute(update(SubmissionRow).values(created_at=past))
    new = {"name": "Behaviour 5"}
    assert client.post("/api/behaviours", json=new, headers=headers(f"{KEY}-4")).status_code == 201
    assert count(workplace.database, SubmissionRow) == 1


def test_what_was_done_by_a_server_that_died_is_said_to_be_done(
    client: TestClient, workplace: Workplace, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(web, "RESPONSE_WAIT_S", 0.2)
    client.post("/api/runs", json=RUN, headers=headers())
    with workplace.database.writing() as session:
        session.execute(update(SubmissionRow).values(status=None, response=None))
    again = client.post("/api/runs", json=RUN, headers=headers())
    assert (again.status_code, again.json()["detail"]) == (409, web.DONE_ALREADY)
    assert count(workplace.database, RunRow) == 1


def test_a_name_that_is_sent_twice_makes_one_person(
    client: TestClient, workplace: Workplace
) -> None:
    wish = {"name": "Ada", "role": "participant", "behaviour_id": 2, "max_uses": 1}
    path = client.post("/api/invitations", json=wish).json()["path"]
    client.cookies.clear()
    fields = dict(re.findall(r'name="(invitation|form)" value="([^"]+)"', client.get(path).text))
    assert len(fields["form"]) == FORM_KEY_LENGTH
    n_people = count(workplace.database, PlayerRow)
    cookies = []
    for _ in range(2):
        client.cookies.clear()
        sent = client.post("/join", data={**fields, "name": "Ada"}, follow_redirects=False)
        assert (sent.status_code, sent.headers["location"]) == (303, "/behaviours/2/play")
        cookies.append(sent.headers["set-cookie"])
    assert cookies[0] == cookies[1]
    assert count(workplace.database, PlayerRow) == n_people + 1
    client.cookies.clear()
    other = {**fields, "form": "0" * FORM_KEY_LENGTH, "name": "Eve"}
    assert client.post("/join", data=other).status_code == 404, "the link was for one person"
