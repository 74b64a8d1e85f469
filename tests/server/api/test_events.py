"""The change stream, the system page and the files of the built page."""

from __future__ import annotations

import json
import threading
from collections.abc import Iterator
from pathlib import Path

import httpx2
import pytest
from sqlalchemy import func, select, text
from starlette.testclient import TestClient

from server.app import create_app
from server.web import access
from server.web.pages import check_frontend
from tests.server.clients import build_frontend, signed_in
from testsupport.databases import on_postgresql
from testsupport.live import TIMEOUT_S, LiveServer, live_server
from testsupport.visitors import cookie_of
from testsupport.workplace import Workplace
from tril.errors import Unavailable
from tril.games.atari.starts import AtariStart
from tril.store import games, players
from tril.store.changes import note_change
from tril.store.database import Database, create_database
from tril.store.models import ChangeRow, MembershipRow, Role


def events(lines: Iterator[str]) -> Iterator[dict[str, str]]:
    for line in lines:
        if line.startswith("data: "):
            yield json.loads(line.removeprefix("data: "))


def test_every_page_is_told_of_every_change_once(live: LiveServer) -> None:
    with (
        live.http.stream("GET", "/api/events") as first,
        httpx2.Client(base_url=live.http.base_url, headers=live.http.headers) as other,
        other.stream("GET", "/api/events") as second,
    ):
        assert first.headers["content-type"].startswith("text/event-stream")
        streams = [stream.iter_lines() for stream in (first, second)]
        for lines in streams:
            next(line for line in lines if line.startswith(": listening"))
        with live.database.writing() as session:
            note_change(session, "run", "abc")
            note_change(session, "run", "abc")
            note_change(session, "recording", 7)
        for lines in streams:
            told = events(lines)
            assert next(told) == {"topic": "run", "key": "abc"}
            assert next(told) == {"topic": "recording", "key": "7"}


def test_one_person_has_only_so_many_streams_whatever_browsers_they_use(
    live: LiveServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(access, "MAX_OPEN", 1)
    other_browser = {"Cookie": "=".join(cookie_of(live.settings))}
    with live.http.stream("GET", "/api/events") as first:
        lines = first.iter_lines()  # closed with the stream as soon as nobody holds it
        next(lines)
        refused = live.http.get("/api/events", headers=other_browser)
        assert refused.status_code == 503
        assert "Too many pages of yours" in refused.json()["detail"]
        with live.play({"stream_path": "/api/games/x/stream"}) as page:
            assert page.close_code() == 1013


def next_ids(database: Database) -> tuple[int, int]:
    """Return the ids that the next two changes would have, which the database gives nobody else."""
    with database.writing() as session:
        if on_postgresql():
            first, second = (
                session.scalar(text("SELECT nextval('changes_id_seq')")) for _ in range(2)
            )
            assert first is not None
            assert second is not None
            return first, second
        last = session.scalar(select(func.max(ChangeRow.id))) or 0
    return last + 1, last + 2


def test_a_change_that_is_committed_after_later_ones_is_told(live: LiveServer) -> None:
    with live.http.stream("GET", "/api/events") as stream:
        lines = stream.iter_lines()
        next(line for line in lines if line.startswith(": listening"))
        told = events(lines)
        for key in reversed(next_ids(live.database)):
            with live.database.writing() as session:
                session.add(ChangeRow(id=key, topic="run", key=f"late-{key}"))
            assert next(told) == {"topic": "run", "key": f"late-{key}"}


def test_changes_over_http_are_told(live: LiveServer) -> None:
    with live.http.stream("GET", "/api/events") as stream:
        lines = stream.iter_lines()
        next(line for line in lines if line.startswith(": listening"))
        with httpx2.Client(base_url=live.http.base_url, headers=live.http.headers) as other:
            made = other.post("/api/behaviours", json={"name": "Wait"}).json()
        assert {"topic": "behaviour", "key": str(made["id"])} in (
            change for _, change in zip(range(5), events(lines), strict=False)
        )


def test_a_player_is_told_of_nothing_but_their_own(live: LiveServer) -> None:
    with live.database.writing() as session:
        me = players.add(session, "Ada", Role.PARTICIPANT).id
        session.add(MembershipRow(behaviour_id=1, player_id=me))
        other = players.add(session, "Ben", Role.PARTICIPANT).id
        session.add(MembershipRow(behaviour_id=1, player_id=other))
        # As of somebody who was a researcher before.
        left_behind = games.create(session, 2, AtariStart(20), me).recording_id
        of_other = games.create(session, 1, AtariStart(20), other).recording_id
    name, value = cookie_of(live.settings, me)
    with (
        httpx2.Client(base_url=live.http.base_url, cookies={name: value}, timeout=TIMEOUT_S) as ada,
        ada.stream("GET", "/api/events") as mine,
        live.http.stream("GET", "/api/events") as owners,
        httpx2.Client(base_url=live.http.base_url, headers=live.http.headers) as owner,
    ):
        streams = [stream.iter_lines() for stream in (mine, owners)]
        for lines in streams:
            next(line for line in lines if line.startswith(": listening"))
        assert owner.patch("/api/behaviours/2", json={"name": "Other"}).is_success
        assert owner.post("/api/games", json={"behaviour_id": 1}).is_success
        assert owner.post("/api/keys", json={"name": "k"}).is_success
        wish = {"name": "5b", "role": "participant", "behaviour_id": 1}
        assert owner.post("/api/invitations", json=wish).is_success
        assert owner.patch("/api/player", json={"name": "Olga"}).is_success
        with live.database.writing() as session:
            others: list[tuple[str, str | int]]
            others = [("recording", of_other), ("recording", left_behind), ("player", other)]
            # The numbers are those of Ada and of her behaviour, the topics not hers.
            others += [(topic, 1) for topic in ("run", "ranking", "access", "invitation", "system")]
            others += [(topic, me) for topic in ("run", "ranking", "access", "invitation", "new")]
            for topic, key in [*others, ("run", "the end")]:
                note_change(session, topic, key)
        told_owner = [
            (told["topic"], told["key"])
            for told in iter(events(streams[1]).__next__, {"topic": "run", "key": "the end"})
        ]
        assert {(topic, str(key)) for topic, key in others} <= set(told_owner)
        assert {topic for topic, _ in told_owner} >= {"behaviour", "invitation", "player"}
        # What Ada is told first is hers, so nothing of what was before.
        own = ada.post("/api/games", json={"behaviour_id": 1}).json()["recording_id"]
        with live.database.writing() as session:
            note_change(session, "recording", own)
        assert owner.patch("/api/behaviours/1", json={"name": "Mine"}).is_success
        assert ada.patch("/api/player", json={"name": "Ada L."}).is_success
        expected = {("recording", str(own)), ("behaviour", "1"), ("player", str(me))}
        told_ada: set[tuple[str, str]] = set()
        told = events(streams[0])
        while not told_ada >= expected:
            change = next(told)
            told_ada.add((change["topic"], change["key"]))
        assert told_ada == expected


def test_nobody_who_is_not_signed_in_listens_nor_does_a_worker(live: LiveServer) -> None:
    key = live.http.post("/api/keys", json={"name": "Lab", "role": "worker"}).json()["key"]
    for headers, status in (({}, 401), ({"Authorization": f"Bearer {key}"}, 403)):
        with httpx2.Client(base_url=live.http.base_url, headers=headers) as stranger:
            assert stranger.get("/api/events").status_code == status


def test_a_server_stops_although_pages_listen(workplace: Workplace) -> None:
    ended = threading.Event()
    listening = threading.Event()

    def listen(server: LiveServer) -> None:
        with (
            httpx2.Client(base_url=server.http.base_url, headers=server.http.headers) as http,
            http.stream("GET", "/api/events") as stream,
        ):
            for _ in stream.iter_lines():
                listening.set()
        ended.set()

    with live_server(workplace.settings.data) as server:
        thread = threading.Thread(target=listen, args=(server,))
        thread.start()
        assert listening.wait(10)
    assert ended.wait(10), "the stream ends in good order"
    thread.join()


def test_the_system_page_knows_the_server(client: TestClient) -> None:
    system = client.get("/api/system").json()
    assert [(process["kind"], process["alive"]) for process in system["processes"]] == [
        ("server", True)
    ]
    assert system["disk_free_bytes"] > 0
    if not on_postgresql():
        # Of the data folder, which has SQLite's files.
        assert system["data_bytes"] > 10_000


def test_the_player_has_a_name(client: TestClient) -> None:
    assert client.get("/api/player").json()["role"] == "owner"
    assert client.patch("/api/player", json={"name": " Ada "}).json()["name"] == "Ada"
    assert client.patch("/api/player", json={"name": "  "}).status_code == 422


def test_pages_and_files_of_the_build_are_served(client: TestClient) -> None:
    page = client.get("/behaviours/3/play")
    assert "<title>Tril</title>" in page.text
    assert page.headers["cache-control"] == "no-store"
    script = client.get("/assets/index-abc123.js")
    assert script.headers["content-type"].startswith("text/javascript")
    assert "immutable" in script.headers["cache-control"]
    assert client.get("/favicon.svg").headers["content-type"] == "image/svg+xml"
    assert client.get("/assets/index-gone.js").status_code == 404
    assert client.post("/behaviours/3").status_code == 405


def test_a_missing_build_says_what_to_do(workplace: Workplace, tmp_path: Path) -> None:
    with pytest.raises(Unavailable, match="make frontend"):
        check_frontend(tmp_path / "nothing")
    with signed_in(workplace, tmp_path / "nothing") as client:
        answer = client.get("/")
        assert answer.status_code == 503
        assert "make frontend" in answer.text


def test_a_new_build_is_served_without_a_restart(workplace: Workplace, tmp_path: Path) -> None:
    build = build_frontend(tmp_path)
    with signed_in(workplace, build) as client:
        assert client.get("/assets/new-1.js").status_code == 404
        (build / "assets" / "new-1.js").write_text("export {}")
        (build / "index.html").write_text("<title>New</title>")
        assert client.get("/assets/new-1.js").status_code == 200
        assert "New" in client.get("/").text


def test_a_server_refuses_a_database_that_was_never_set_up(tmp_path: Path) -> None:
    from tril.settings import Settings

    settings = Settings(data=tmp_path / "empty")
    create_database(settings.application_url).close()
    with pytest.raises(Unavailable, match="tril migrate"), TestClient(create_app(settings)):
        pass
