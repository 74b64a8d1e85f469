"""Browsers, invitations and keys: let in, seen, and shut out within seconds."""

from __future__ import annotations

import asyncio
import re
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import httpx2
import pytest
from sqlalchemy import delete, event, select, update
from sqlalchemy.exc import DatabaseError
from typer.testing import CliRunner, Result
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection

from cli.main import app
from server.web.security import address_with_token, invitation_link
from server.web.sign_in import browser_name
from server.web.small_pages import language_of
from testsupport.databases import on_postgresql
from testsupport.live import TIMEOUT_S, LiveServer, connect_to, live_server
from testsupport.visitors import cookie_of
from testsupport.waiting import wait_until
from testsupport.workplace import Workplace
from tril.errors import Conflict
from tril.store import audit, players, recordings
from tril.store.access import credentials, invitations, roles
from tril.store.models import AuditRow, CredentialKind, CredentialRow, InvitationRow, Role, now


def _visitor(live: LiveServer, **more: Any) -> httpx2.Client:
    return httpx2.Client(base_url=live.http.base_url, timeout=TIMEOUT_S, **more)


@pytest.fixture
def browser(live: LiveServer) -> Iterator[httpx2.Client]:
    """Return another browser of the owner."""
    name, value = cookie_of(live.settings)
    with _visitor(live, cookies={name: value}) as client:
        yield client


def _present(client: httpx2.Client) -> dict[str, Any]:
    (found,) = [one for one in client.get("/api/browsers").json() if one["present"]]
    return dict(found)


def _code_at_end(socket: ClientConnection) -> int | None:
    """Receive until a socket is closed, and return why."""
    try:
        while True:
            socket.recv(timeout=TIMEOUT_S)
    except ConnectionClosed as closed:
        return None if closed.rcvd is None else closed.rcvd.code


def _is_refused(client: httpx2.Client) -> bool:
    return client.get("/api/player").status_code == 401


def test_signing_out_ends_this_browser_and_no_other(
    live: LiveServer, browser: httpx2.Client
) -> None:
    assert browser.get("/api/player").status_code == 200
    answer = browser.post("/api/sign-out")
    assert answer.status_code == 204
    assert "max-age=0" in answer.headers["set-cookie"].lower()
    browser.cookies.clear()
    assert _is_refused(browser)
    assert live.http.get("/api/player").status_code == 200


def test_a_browser_that_is_signed_out_loses_what_it_has_open(
    live: LiveServer, browser: httpx2.Client
) -> None:
    cookie = "=".join(next(iter(browser.cookies.items())))
    with (
        browser.stream("GET", "/api/events") as events,
        connect_to(live.settings, live.new_game()["stream_path"], cookie) as socket,
    ):
        lines = events.iter_lines()
        next(line for line in lines if line.startswith(": listening"))
        socket.recv()
        browser_id = _present(browser)["id"]
        assert live.http.delete(f"/api/browsers/{browser_id}").status_code == 204
        for _ in lines:
            pass
        assert _code_at_end(socket) == 4401
    assert _is_refused(browser)
    assert live.http.delete("/api/browsers/99999").status_code == 404


def test_a_burst_of_requests_asks_the_database_once_who_it_is(
    live: LiveServer, browser: httpx2.Client
) -> None:
    engine = live.services.database.engine
    asked: list[str] = []

    def count(_connection: Any, _cursor: Any, statement: str, *_: Any) -> None:
        if "FROM credentials" in statement:
            asked.append(statement)

    assert browser.get("/api/player").status_code == 200
    stranger = _visitor(live, cookies={live.services.access.cookie_name: "made.up"})
    event.listen(engine, "before_cursor_execute", count)
    try:
        for _ in range(20):
            assert browser.get("/api/player").status_code == 200
            assert browser.get("/api/health").status_code == 200
            assert stranger.get("/api/player").status_code == 401
    finally:
        event.remove(engine, "before_cursor_execute", count)
        stranger.close()
    # Another test's change of access may be heard of meanwhile.
    assert len(asked) <= 1


def test_a_new_key_shuts_out_old_addresses_and_every_browser(
    workplace: Workplace, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("TRIL_DATA", str(workplace.settings.data))
    monkeypatch.setenv("TRIL_DATABASE_URL", workplace.settings.database_url)
    with live_server(workplace.settings.data) as live:
        url = f"http://{live.authority}"
        old = address_with_token(live.settings, url)
        key = _made(live.http.post("/api/keys", json={"name": "worker"}))["key"]
        with _visitor(live) as browser:
            assert browser.get(old).status_code == 303
            assert browser.get("/api/player").status_code == 200
            result = CliRunner().invoke(app, ["address", "--new"])
            assert result.exit_code == 0, result.output
            wait_until(lambda: _is_refused(browser))
            assert browser.get(old).status_code == 401
            new = address_with_token(live.settings, url)
            assert new.rpartition("=")[2] in result.stdout
            assert browser.get(new).status_code == 303
            assert browser.get("/api/player").status_code == 200
        with _visitor(live, headers={"Authorization": f"Bearer {key}"}) as script:
            assert script.get("/api/player").status_code == 200


def test_opening_the_address_again_adds_no_second_browser(live: LiveServer) -> None:
    address = address_with_token(live.settings, str(live.http.base_url))
    with _visitor(live) as browser:
        for _ in range(2):
            assert browser.get(address).status_code == 303
        cookie = dict(browser.cookies)
        browser.get(address)
        assert dict(browser.cookies) == cookie


def _made(answer: httpx2.Response) -> dict[str, Any]:
    assert answer.status_code == 201, answer.text
    return dict(answer.json())


def test_an_invitation_makes_a_person_of_a_name_who_plays_one_behaviour(live: LiveServer) -> None:
    wish = {"name": "Class 5b", "role": "participant", "behaviour_id": 2}
    made = _made(live.http.post("/api/invitations", json=wish))
    with _visitor(live) as guest:
        page = guest.get(made["path"])
        assert "What is your name?" in page.text
        (signed,) = re.findall(r'name="invitation" value="([^"]+)"', page.text)
        unnamed = guest.post("/join", data={"invitation": signed, "name": "  "})
        assert "What is your name?" in unnamed.text
        assert 'aria-invalid="true"' in unnamed.text
        joined = guest.post("/join", data={"invitation": signed, "name": "Ada <b>"})
        assert joined.status_code == 303
        assert joined.headers["location"] == "/behaviours/2/play"
        me = guest.get("/api/player").json()
        assert (me["name"], me["role"]) == ("Ada <b>", "participant")
        assert [one["id"] for one in guest.get("/api/behaviours").json()] == [2]
        game = guest.post("/api/games", json={"behaviour_id": 2}).json()
        assert live.row(game["recording_id"]).player_id == me["id"]
        assert guest.post("/api/games", json={"behaviour_id": 1}).status_code == 404
        assert live.http.delete(f"/api/invitations/{made['id']}").status_code == 204
        assert guest.get(made["path"]).status_code == 404
        late = guest.post("/join", data={"invitation": signed, "name": "Late"})
        assert late.status_code == 404
        # Who came by it stays.
        assert guest.get("/api/player").status_code == 200
    assert made["id"] not in {one["id"] for one in live.http.get("/api/invitations").json()}


def test_a_link_lets_in_as_many_as_it_was_made_for(live: LiveServer) -> None:
    wish = {"name": "5b", "role": "participant", "behaviour_id": 1, "max_uses": 3}
    made = _made(live.http.post("/api/invitations", json=wish))
    (signed,) = re.findall(r"invitation=(.+)", made["path"])

    def come(number: int) -> int:
        form = {"invitation": signed, "name": f"Guest {number}"}
        with _visitor(live, follow_redirects=False) as guest:
            return guest.post("/join", data=form).status_code

    with ThreadPoolExecutor(8) as guests:
        answers = Counter(guests.map(come, range(8)))
    assert answers == {303: 3, 404: 5}
    (listed,) = [one for one in live.http.get("/api/invitations").json() if one["id"] == made["id"]]
    assert (listed["n_used"], listed["max_uses"]) == (3, 3)


def test_a_link_expires_and_one_of_an_earlier_version_does_not(live: LiveServer) -> None:
    wish = {"name": "5b", "role": "participant", "behaviour_id": 1, "days": 1}
    expired, old = (_made(live.http.post("/api/invitations", json=wish)) for _ in range(2))
    with live.database.writing() as session:
        session.get_one(InvitationRow, expired["id"]).expires_at = now()
        row = session.get_one(InvitationRow, old["id"])
        row.max_uses = row.expires_at = None
        row.n_used = 1000
    with _visitor(live) as guest:
        page = guest.get(expired["path"])
        assert (page.status_code, "has expired" in page.text) == (404, True)
        assert guest.get(old["path"]).status_code == 200


@pytest.mark.parametrize(
    ("accepted", "language"),
    [
        ("", "en"),
        ("de-AT, en;q=0.5", "de"),
        ("en-GB,de;q=0.9", "en"),
        ("fr, de;q=0.3, en;q=0.2", "de"),
        ("de;q=x, *", "en"),
        ("de;q=0", "en"),
    ],
)
def test_small_pages_follow_the_browsers_languages(accepted: str, language: str) -> None:
    assert language_of(accepted) == language


def test_a_link_says_in_both_languages_what_it_is_for_or_why_it_lets_nobody_in(
    live: LiveServer, browser: httpx2.Client
) -> None:
    wish = {"name": "5b", "role": "participant", "behaviour_id": 2}
    made = _made(live.http.post("/api/invitations", json=wish))
    said = {
        "en": ("Welcome to Tril", "What is your name?", "is over", "is not complete"),
        "de": ("Willkommen bei Tril", "Wie heißt du?", "gilt nicht mehr", "nicht vollständig"),
    }
    for language, (welcome, question, _, incomplete) in said.items():
        with _visitor(live, headers={"Accept-Language": language}) as guest:
            page = guest.get(made["path"])
            assert page.status_code == 200
            assert f'<html lang="{language}">' in page.text
            assert welcome in page.text
            assert question in page.text
            # What it is made of is what the policy allows: scripts from files only.
            assert re.findall(r"<script[^>]*>[^<]", page.text) == []
            assert "onclick" not in page.text
            broken = guest.get(made["path"][:-3])
            assert (broken.status_code, incomplete in broken.text) == (404, True)
            assert 'href="/"' not in broken.text
    assert "is signed in as" in browser.get(made["path"]).text
    assert live.http.delete(f"/api/invitations/{made['id']}").status_code == 204
    for language, (*_, over, _) in said.items():
        with _visitor(live, headers={"Accept-Language": language}) as guest:
            page = guest.get(made["path"])
            assert (page.status_code, over in page.text) == (404, True)
    # Somebody who is in is shown the way.
    assert 'href="/"' in browser.get(made["path"]).text


@pytest.mark.parametrize(
    "wish",
    [
        {"name": "x", "role": "participant"},
        {"name": "x", "role": "researcher", "behaviour_id": 1},
        {"name": "x", "role": "owner"},
        {"name": " ", "role": "researcher"},
    ],
)
def test_an_invitation_that_makes_no_sense_is_refused(
    live: LiveServer, wish: dict[str, Any]
) -> None:
    assert live.http.post("/api/invitations", json=wish).status_code == 422


def test_a_key_lets_a_script_in_until_it_is_revoked(live: LiveServer) -> None:
    made = _made(live.http.post("/api/keys", json={"name": "nightly", "role": "researcher"}))
    with _visitor(live, headers={"Authorization": f"Bearer {made['key']}"}) as script:
        assert script.get("/api/player").json()["role"] == "researcher"
        assert script.get("/api/runs").status_code == 200
        assert script.get("/api/keys").status_code == 403
        assert script.post("/api/sign-out").status_code == 404
        wait_until(lambda: _saved_seen(live, made["id"]))
        assert live.http.delete(f"/api/keys/{made['id']}").status_code == 204
        wait_until(lambda: _is_refused(script))
    # A key is no cookie, and a cookie is no key.
    name, value = cookie_of(live.settings)
    with _visitor(live, headers={"Authorization": f"Bearer {value}"}) as confused:
        assert _is_refused(confused)
    other = _made(live.http.post("/api/keys", json={"name": "other"}))
    with _visitor(live, cookies={name: other["key"]}) as confused:
        assert _is_refused(confused)


def _saved_seen(live: LiveServer, credential_id: int) -> bool:
    asyncio.run(live.services.access.save_last_use())
    with live.database.reading() as session:
        return session.get_one(CredentialRow, credential_id).seen_at is not None


def _role(live: LiveServer, player_id: int, **update: Any) -> httpx2.Response:
    return live.http.put(f"/api/people/{player_id}/role", json=update)


def test_a_change_of_role_takes_effect_within_seconds_and_ends_what_was_open(
    live: LiveServer,
) -> None:
    with live.database.writing() as session:
        person = players.add(session, "Ria", Role.RESEARCHER).id
    name, value = cookie_of(live.settings, person)
    with _visitor(live, cookies={name: value}) as ria:
        assert ria.get("/api/runs").status_code == 200
        listed = {one["id"]: one for one in live.http.get("/api/people").json()}
        assert listed[person] == {
            "id": person, "name": "Ria", "role": "researcher", "behaviour_ids": []
        }  # fmt: skip
        game = live.new_game()
        with (
            ria.stream("GET", "/api/events") as events,
            connect_to(live.settings, game["stream_path"], f"{name}={value}") as socket,
        ):
            lines = events.iter_lines()
            next(line for line in lines if line.startswith(": listening"))
            socket.recv()
            unplayable = _role(live, person, role="participant")
            assert unplayable.status_code == 422
            assert "behaviour" in unplayable.json()["detail"]
            assert _role(live, person, role="participant", behaviour_id=2).status_code == 204
            for _ in lines:
                pass
            assert _code_at_end(socket) == 1013
        wait_until(lambda: ria.get("/api/runs").status_code == 403)
        assert ria.get("/api/player").json()["role"] == "participant"
        assert [one["id"] for one in ria.get("/api/behaviours").json()] == [2]
        assert _role(live, person, role="researcher").status_code == 204
        wait_until(lambda: ria.get("/api/runs").status_code == 200)
        # What could be played before can be played again.
        assert _role(live, person, role="participant").status_code == 204
        wait_until(lambda: ria.get("/api/runs").status_code == 403)
    newest = live.http.get("/api/audit", params={"limit": 1}).json()[0]
    assert (newest["action"], newest["subject"]) == ("changed a role", f"player {person}")
    assert newest["details"] == {"name": "Ria", "before": "researcher", "role": "participant"}


def test_the_last_owner_stays_the_owner(live: LiveServer) -> None:
    me = live.http.get("/api/player").json()["id"]
    refused = _role(live, me, role="researcher")
    assert refused.status_code == 409
    assert "last owner" in refused.json()["detail"]
    assert live.http.get("/api/player").json()["role"] == "owner"


def test_an_owner_beside_another_loses_the_keys_with_the_role(workplace: Workplace) -> None:
    with workplace.database.writing() as session:
        second = players.add(session, "Oda", Role.OWNER).id
        credentials.make_key(session, second, "everything", Role.OWNER)
        roles.change(session, second, Role.RESEARCHER, None, by_player_id=None)
        assert not credentials.listing(session, CredentialKind.KEY)
        with pytest.raises(Conflict, match="last owner"):
            roles.change(session, players.owner(session).id, Role.RESEARCHER, None, None)


@pytest.mark.parametrize(
    ("update", "status"),
    [
        ({"role": "owner"}, 422),
        ({"role": "worker"}, 422),
        ({"role": "researcher", "behaviour_id": 1}, 422),
        ({"role": "participant", "behaviour_id": 9999}, 404),
    ],
)
def test_roles_that_make_no_sense_are_refused(
    live: LiveServer, update: dict[str, Any], status: int
) -> None:
    with live.database.writing() as session:
        person = players.add(session, "Kim", Role.RESEARCHER).id
    assert _role(live, person, **update).status_code == status
    assert _role(live, 9999, role="researcher").status_code == 404
    with live.database.reading() as session:
        assert players.get(session, person).role == Role.RESEARCHER


def test_no_secret_is_stored(live: LiveServer) -> None:
    made = _made(live.http.post("/api/keys", json={"name": "hidden"}))
    secret = made["key"].partition(".")[0]
    with live.database.reading() as session:
        row = session.get_one(CredentialRow, made["id"])
        assert secret not in str(vars(row))
        assert row.secret_hash == credentials.hash_of(secret)
        assert all(secret not in str(vars(entry)) for entry in audit.page(session))


def test_what_people_do_is_logged(live: LiveServer) -> None:
    _made(live.http.post("/api/invitations", json={"name": "logged", "role": "researcher"}))
    ranking = live.http.get("/api/behaviours/1/ranking").json()
    tiers = ranking["tiers"][::-1]
    update_ = {"base_revision": ranking["revision"], "tiers": tiers}
    assert live.http.put("/api/behaviours/1/ranking", json=update_).status_code == 200
    newest, earlier = live.http.get("/api/audit", params={"limit": 2}).json()
    assert (newest["action"], newest["subject"]) == ("ranked", "behaviour 1")
    assert newest["player"] == live.http.get("/api/player").json()["name"]
    assert earlier["action"] == "made an invitation"
    (older,) = live.http.get("/api/audit", params={"limit": 1, "before": newest["id"]}).json()
    assert older == earlier


@pytest.mark.skipif(on_postgresql(), reason="triggers keep the log on SQLite alone")
def test_the_log_can_only_be_added_to(live: LiveServer) -> None:
    _made(live.http.post("/api/invitations", json={"name": "kept", "role": "researcher"}))
    (newest,) = live.http.get("/api/audit", params={"limit": 1}).json()
    changes = (
        update(AuditRow).where(AuditRow.id == newest["id"]).values(subject="nothing"),
        delete(AuditRow).where(AuditRow.id == newest["id"]),
    )
    for change in changes:
        with (
            pytest.raises(DatabaseError, match="only be added to"),
            live.database.writing() as session,
        ):
            session.execute(change)


def test_deletions_and_runs_are_logged_with_who_did_them(workplace: Workplace) -> None:
    with workplace.database.writing() as session:
        owner = players.owner(session).id
    run_id = workplace.make_run()
    with workplace.database.writing() as session:
        recordings.delete(session, [recordings.get(session, workplace.ranked[0])], owner)
    with workplace.database.reading() as session:
        logged = [(entry.action, entry.subject, entry.player_id) for entry in audit.page(session)]
    assert ("deleted", f"recording {workplace.ranked[0]}", owner) in logged
    assert ("queued a run", f"run {run_id}", None) in logged


def test_a_person_stores_and_queues_only_so_much(workplace: Workplace) -> None:
    limits: dict[str, Any] = {"max_recordings_per_player": 1, "max_queued_runs_per_player": 1}
    with live_server(workplace.settings.data, **limits) as live:
        assert live.http.post("/api/games", json={"behaviour_id": 1}).status_code == 201
        refused = live.http.post("/api/games", json={"behaviour_id": 1})
        assert refused.status_code == 409
        assert "TRIL_MAX_RECORDINGS_PER_PLAYER" in refused.json()["detail"]
        run = {"behaviour_id": 1, "recipe": "fast", "training_seed": 0}
        assert live.http.post("/api/runs", json=run).status_code == 201
        refused = live.http.post("/api/runs", json=run)
        assert refused.status_code == 409
        assert "TRIL_MAX_QUEUED_RUNS_PER_PLAYER" in refused.json()["detail"]


def test_a_person_stores_only_so_many_runs(workplace: Workplace) -> None:
    with live_server(workplace.settings.data, max_runs_per_player=1) as live:
        run = {"behaviour_id": 1, "recipe": "fast", "training_seed": 0}
        made = live.http.post("/api/runs", json=run)
        assert made.status_code == 201
        path = f"/api/runs/{made.json()['id']}"
        assert live.http.post(f"{path}/cancel").is_success
        assert live.http.delete(path).is_success
        refused = live.http.post("/api/runs", json=run)
        assert refused.status_code == 409
        assert "TRIL_MAX_RUNS_PER_PLAYER" in refused.json()["detail"]


def test_links_that_are_not_revoked_are_limited(
    live: LiveServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    n = len(live.http.get("/api/invitations").json())
    monkeypatch.setattr(invitations, "MAX_INVITATIONS", n + 1)
    wish = {"name": "A class", "role": "participant", "behaviour_id": 1}
    made = live.http.post("/api/invitations", json=wish)
    assert made.status_code == 201
    refused = live.http.post("/api/invitations", json=wish)
    assert refused.status_code == 409
    assert refused.json()["detail"] == f"There are {n + 1} links already; revoke some first."
    assert live.http.delete(f"/api/invitations/{made.json()['id']}").is_success
    assert live.http.post("/api/invitations", json=wish).status_code == 201


def test_a_link_lets_in_only_as_many_people_as_there_can_be(
    live: LiveServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    wish = {"name": "A class", "role": "participant", "behaviour_id": 1}
    signed = live.http.post("/api/invitations", json=wish).json()["path"].partition("=")[2]
    with live.database.reading() as session:
        monkeypatch.setattr(players, "MAX_PEOPLE", players.count(session) + 1)
    with httpx2.Client(base_url=f"http://{live.authority}") as guest:
        first = guest.post("/join", data={"invitation": signed, "name": "Ada"})
        assert first.status_code == 303
        second = guest.post("/join", data={"invitation": signed, "name": "Bea"})
        assert "as many people as this server takes" in second.text
    with live.database.reading() as session:
        assert players.count(session) == players.MAX_PEOPLE


def test_links_name_the_address_that_others_reach(
    workplace: Workplace, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("TRIL_DATA", str(workplace.settings.data))

    def invite(*more: str, status: int = 0) -> Result:
        result = CliRunner().invoke(app, ["people", "invite", "x", "--researcher", *more])
        assert result.exit_code == status, result.output
        return result

    here = invite()
    assert here.stdout.startswith("http://127.0.0.1:8000/join?invitation=")
    assert "--address" in here.stderr
    given = invite("--address", "http://lab.example:81/")
    assert given.stdout.startswith("http://lab.example:81/join?invitation=")
    assert not given.stderr
    for wrong in ("lab.example", "ftp://lab.example", "http://lab.example/?x=1"):
        invite("--address", wrong, status=2)
    monkeypatch.setenv("TRIL_ALLOWED_HOSTS", "tril.example")
    monkeypatch.setenv("TRIL_TRUSTED_PROXIES", "127.0.0.1")
    proxied = invite()
    assert proxied.stdout.startswith("https://tril.example/join?invitation=")
    assert not proxied.stderr


def test_commands_say_who_gets_in(workplace: Workplace, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TRIL_DATA", str(workplace.settings.data))
    monkeypatch.setenv("TRIL_DATABASE_URL", workplace.settings.database_url)

    def tril(*words: str) -> str:
        result = CliRunner().invoke(app, words)
        assert result.exit_code == 0, result.output
        return result.stdout

    link = tril("people", "invite", "Class 5b", "--behaviour", "column-1").strip()
    assert "/join?invitation=" in link
    key = tril("people", "key", "nightly").strip()
    listed = tril("people", "list")
    assert "Class 5b" in listed
    assert "nightly" in listed
    assert key.partition(".")[0] not in listed
    tril("people", "revoke", "invitation", "1")
    with workplace.database.reading() as session:
        assert not invitations.listing(session)
        (row,) = credentials.listing(session, CredentialKind.KEY)
        assert row.role == Role.RESEARCHER
    tril("people", "revoke", "key", str(row.id))
    with workplace.database.writing() as session:
        person = players.add(session, "Ria", Role.RESEARCHER)
        credentials.sign_in(session, person.id, "Test")
        ria = person.id
    assert f"id {ria}, name Ria, role researcher" in tril("people", "list")
    tril("people", "role", str(ria), "participant", "--behaviour", "column-1")
    assert f"id {ria}, name Ria, role participant" in tril("people", "list")
    assert CliRunner().invoke(app, ["people", "role", str(ria), "owner"]).exit_code != 0
    assert tril("audit").splitlines()[0].endswith("role participant, behaviour 1")
    log = "\n".join(tril("audit").splitlines()[2:])
    assert log.splitlines()[0].endswith("terminal revoked a key key 1 name nightly")
    assert CliRunner().invoke(app, ["people", "invite", "x"]).exit_code != 0
    assert invitation_link(workplace.settings, "http://x/", "s").startswith("http://x/join?")
    with workplace.database.reading() as session:
        assert session.scalar(select(AuditRow.player_id).order_by(AuditRow.id.desc())) is None


@pytest.mark.parametrize(
    ("user_agent", "name"),
    [
        (
            "Mozilla/5.0 (X11; Linux x86_64; rv:140.0) Gecko/20100101 Firefox/140.0",
            "Firefox on Linux",
        ),
        (
            "Mozilla/5.0 (Windows NT 10.0) AppleWebKit/537.36 Chrome/140.0 Safari/537.36 Edg/140.0",
            "Edge on Windows",
        ),
        ("Mozilla/5.0 (iPhone; CPU) AppleWebKit/605 Version/18 Safari/604", "Safari on iPhone"),
        ("curl/8.5.0", "curl"),
        ("", "Unknown browser"),
    ],
)
def test_browsers_are_named(user_agent: str, name: str) -> None:
    assert browser_name(user_agent) == name
