"""Every operation of the API, asked for by everybody who may not, and by those who may.

    python -m pytest -s tests/server/api/test_permissions.py

prints what everybody was answered, as a table.
"""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any
from uuid import uuid4

import pytest
from sqlalchemy import select
from starlette.testclient import TestClient, WebSocketTestSession
from starlette.websockets import WebSocketDisconnect

from scripts.permissions_page import page
from server.api import catalogue
from server.play.rules import PlayRules
from server.web.permissions import (
    RESEARCHERS_FIELDS,
    check_all_declared,
)
from server.web.security import load_secrets
from tests.server.clients import build_frontend, signed_in
from testsupport.libraries import replay_of
from testsupport.visitors import cookie_of
from testsupport.workplace import Workplace, make_workplace
from tril.games.atari.starts import AtariStart
from tril.store import borrowed, games, players, rankings, recordings
from tril.store.access import credentials
from tril.store.models import (
    ArtifactRow,
    GameRow,
    MembershipRow,
    PlayerRow,
    RecordingRow,
    RecordingState,
    Role,
    Source,
    Verification,
)

MARK = "Not for other people's eyes"
"""Is in everything that a participant must not read."""

METHODS = {"get", "post", "put", "patch", "delete"}

OWN_GAMES_OF_BEHAVIOUR = {
    "get_recording",
    "get_recording_course",
    "get_recording_frames",
    "get_recording_strip",
    "get_recording_memory",
    "get_recording_clip",
    "export_recording",
    "keep_recording",
    "discard_recording",
    "delete_recording",
    "restore_recording",
    "create_game_from",
    "get_game",
}
"""Operations on games, which a participant may do with their own."""
OF_BEHAVIOUR = {
    "get_behaviour",
    "get_checklist",
    "list_recordings",
    "get_library",
    "list_shown_recordings",
}
"""Operations on behaviours that a participant may play; what they answer is filtered."""
OF_ONESELF = {
    "get_player",
    "update_player",
    "sign_out",
    "list_behaviours",
    "create_game",
    "get_title",
    "get_title_picture",
}
"""Operations that everybody may do who is signed in."""
OF_OWNER = {
    "list_people",
    "change_role",
    "list_browsers",
    "sign_browser_out",
    "list_keys",
    "create_key",
    "revoke_key",
    "list_invitations",
    "create_invitation",
    "revoke_invitation",
    "list_audit",
}
OF_WORKER = {"let_worker_in"}
"""Operations that only a worker's key may do."""
STREAM = "stream_events"
PUBLIC = {
    "name": "space_invaders",
    "round_number": 1,
    "pair": 1,
    "side": "left",
    "part": "html",
}
"""What parameters of paths name that is nobody's."""


@dataclass(frozen=True)
class World:
    """A server with games of several people.

    Attributes:
        client: Runs the application.
        workplace: Its data.
        people: The person of each role; "elsewhere" is a participant of behaviour 2.
        owners: The ids of the owner's things, by the name of the path's parameter.
        participants: Those of the participant.
        answers: What was answered, by the operation's method and path, and by whoever asked for
            what.
    """

    client: TestClient
    workplace: Workplace
    people: dict[str, int]
    owners: dict[str, Any]
    participants: dict[str, Any]
    answers: dict[tuple[str, str], set[int]] = field(default_factory=lambda: defaultdict(set))

    @cached_property
    def worker_key(self) -> str:
        """The key of a worker."""
        with self.workplace.database.writing() as session:
            _, secret = credentials.make_key(session, self.people["owner"], "Lab", Role.WORKER)
        return load_secrets(self.workplace.settings.token_file).signed(secret)

    def visitor(self, role: str) -> TestClient:
        """Return a client of somebody's fresh browser; a worker has a key, "anonymous" nothing."""
        visitor = TestClient(self.client.app, base_url=str(self.client.base_url))
        if role == "worker":
            visitor.headers["Authorization"] = f"Bearer {self.worker_key}"
        elif role != "anonymous":
            visitor.cookies.set(*cookie_of(self.workplace.settings, self.people[role]))
        return visitor

    def socket(self, role: str, path: str) -> WebSocketTestSession:
        """Open a stream from somebody's browser."""
        authority = str(self.client.base_url).removeprefix("http://").rstrip("/")
        return self.visitor(role).websocket_connect(f"ws://{authority}{path}")

    def operations(self) -> list[tuple[str, str, str]]:
        """Return the name, method and path of every operation of the API's description."""
        return [
            (operation["operationId"], method, path)
            for path, methods in self.client.app.openapi()["paths"].items()  # type: ignore[attr-defined]
            for method, operation in methods.items()
            if method in METHODS
        ]

    def things_to_delete(self) -> dict[str, Any]:
        """Make one of everything that can be deleted or revoked; return the ids."""
        owner, name = self.visitor("owner"), f"Gone {uuid4()}"
        behaviour = owner.post("/api/behaviours", json={"name": name}).json()
        invited = {"name": "gone", "role": "participant", "behaviour_id": 1}
        with self.workplace.database.writing() as session:
            played = recordings.get(session, self.workplace.ranked[0])
            recording = recordings.add(
                session,
                self.workplace.behaviour_id,
                recordings.as_recording(played),
                replay_of(played),
                Source.PERSON,
                player_id=self.people["owner"],
            )
            borrowed.borrow(session, behaviour["id"], [recording.id])
            credentials.sign_in(session, self.people["owner"], name)
            recording_id = recording.id
        browsers = owner.get("/api/browsers").json()
        (browser,) = [one for one in browsers if one["name"] == name]
        run_id = self.workplace.make_run()
        owner.post(f"/api/runs/{run_id}/cancel")
        return {
            "behaviour_id": behaviour["id"],
            "recording_id": recording_id,
            "run_id": run_id,
            "browser_id": browser["id"],
            "key_id": owner.post("/api/keys", json={"name": "gone"}).json()["id"],
            "invitation_id": owner.post("/api/invitations", json=invited).json()["id"],
        }

    def ask(self, role: str, method: str, path: str, ids: dict[str, Any]) -> Any:
        """Ask for an operation on things, as somebody of a role."""
        url = re.sub(r"{(\w+)}", lambda name: str((ids | PUBLIC)[name[1]]), path)
        query = {"step": "0", "method": "gradient"} if "attention" in path else {}
        if path.endswith("/library/recordings"):
            query = {"recording": str(ids["recording_id"])}
        body: dict[str, Any] = {"name": "Kim", "behaviour_id": ids["behaviour_id"], "frame": 0}
        if path.endswith("/role"):
            body = {"role": "participant", "behaviour_id": ids["behaviour_id"]}
        elif path == "/api/player":
            body = {"name": "Kim"}
        elif path == "/api/games":
            body = {"behaviour_id": ids["behaviour_id"]}
        answer = self.visitor(role).request(
            method, url, params=query, json=None if method in {"get", "delete"} else body
        )
        whose = f"{role}, own" if ids is self.participants and role == "participant" else role
        self.answers[f"{method.upper()} {path}", whose].add(answer.status_code)
        return answer

    def table(self) -> str:
        """Return what was answered so far: operations by who asked."""
        columns = (
            "anonymous",
            "worker",
            "elsewhere",
            "participant",
            "participant, own",
            "researcher",
            "owner",
        )
        lines = [f"| | {' | '.join(columns)} |", "|---" * (len(columns) + 1) + "|"]
        for _, method, path in self.operations():
            operation = f"{method.upper()} {path}"
            cells = (
                " ".join(map(str, sorted(self.answers[operation, column]))) for column in columns
            )
            lines.append(f"| `{operation}` | {' | '.join(cells)} |")
        return "\n".join(lines)


@pytest.fixture(scope="module")
def world(tmp_path_factory: pytest.TempPathFactory) -> Iterator[World]:
    folder = tmp_path_factory.mktemp("permissions")
    workplace = make_workplace(folder / "data")
    run_id = workplace.make_run()
    with workplace.database.writing() as session:
        people = {"owner": players.owner(session).id}
        players.rename(session, players.owner(session), MARK)
        people["researcher"] = players.add(session, f"Ria, {MARK}", Role.RESEARCHER).id
        for name, behaviour_id in (("participant", 1), ("elsewhere", 2)):
            people[name] = players.add(session, name, Role.PARTICIPANT).id
            session.add(MembershipRow(behaviour_id=behaviour_id, player_id=people[name]))
        changed = players.add(session, f"Cem, {MARK}", Role.RESEARCHER).id
        played = recordings.get(session, workplace.ranked[0])
        things = {}
        for name in ("owner", "participant"):
            recording = recordings.add(
                session,
                1,
                recordings.as_recording(played),
                replay_of(played),
                Source.PERSON,
                player_id=people[name],
                notes=MARK,
                perfect=True,
            )
            rankings.save(
                session,
                1,
                rankings.current(session, 1).revision,
                [[recording.id], *rankings.current(session, 1).tiers],
                people["owner"],
            )
            game = games.create(session, 1, AtariStart(20), people[name])
            things[name] = {"recording_id": recording.id, "game_id": game.id}
        artifact = ArtifactRow(
            run_id=run_id, kind="report", name="r", path="r", media_type="text/plain", size_bytes=1
        )
        session.add(artifact)
        session.flush()
        common = {
            "behaviour_id": 1,
            "run_id": run_id,
            "artifact_id": artifact.id,
            "kind": "gif",
            "player_id": changed,
            "browser_id": 9999,
            "key_id": 9999,
            "invitation_id": 9999,
        }
    with signed_in(workplace, build_frontend(folder), PlayRules(max_games=1)) as client:
        world = World(
            client,
            workplace,
            people,
            {**common, **things["owner"]},
            {**common, **things["participant"]},
        )
        yield world
        n_answers = sum(map(len, world.answers.values()))
        print(
            f"\n{len(world.operations())} operations, {n_answers} kinds of answer\n{world.table()}"
        )
    workplace.database.close()


def _state(world: World) -> list[Any]:
    """Return what nobody may change who may not."""
    with world.workplace.database.reading() as session:
        rows = session.execute(
            select(
                RecordingRow.id, RecordingRow.state, RecordingRow.deleted_at, RecordingRow.notes
            ).order_by(RecordingRow.id)
        ).all()
        roles = session.execute(select(PlayerRow.id, PlayerRow.role).order_by(PlayerRow.id)).all()
        return [tuple(row) for row in [*rows, *roles]]


def test_the_description_names_every_operation_of_this_test(world: World) -> None:
    named = {name for name, _, _ in world.operations()}
    assert len(named) > 50
    assert named >= OWN_GAMES_OF_BEHAVIOUR | OF_BEHAVIOUR | OF_ONESELF | OF_OWNER | OF_WORKER | {
        STREAM
    }


def test_nobody_who_is_not_signed_in_gets_more_than_the_health(world: World) -> None:
    before = _state(world)
    for name, method, path in world.operations():
        answer = world.ask("anonymous", method, path, world.owners)
        assert answer.status_code == (200 if name == "get_health" else 401), name
        assert MARK not in answer.text
    assert _state(world) == before


@pytest.mark.parametrize("role", ["participant", "elsewhere"])
def test_a_participant_gets_nothing_of_other_people(world: World, role: str) -> None:
    before = _state(world)
    mine = OF_ONESELF | (OF_BEHAVIOUR if role == "participant" else set())
    for name, method, path in world.operations():
        if name in {STREAM, "get_health"}:
            continue
        answer = world.ask(role, method, path, world.owners)
        assert MARK not in answer.text, name
        if name in mine and not (name == "create_game" and role == "elsewhere"):
            assert answer.status_code in {200, 201, 204}, (name, answer.text)
        else:
            assert answer.status_code in {403, 404}, (name, answer.text)
    with world.workplace.database.writing() as session:
        # Only the game that the participant began in the loop is new.
        of_theirs = [
            row.id
            for row in session.scalars(
                select(RecordingRow).where(
                    RecordingRow.player_id == world.people[role],
                    RecordingRow.state == RecordingState.PLAYING,
                )
            )
        ]
    after = [row for row in _state(world) if row[0] not in of_theirs]
    assert after == [row for row in before if row[0] not in of_theirs]


def test_the_lists_of_a_participant_hold_only_their_own(world: World) -> None:
    visitor = world.visitor("participant")
    listed = visitor.get("/api/behaviours/1/recordings", params={"include": "policy"}).json()
    assert [one["id"] for one in listed] == [world.participants["recording_id"]]
    brief = visitor.get("/api/behaviours/1/library", params={"deleted": True}).json()
    assert brief["recordings"]["id"] == [world.participants["recording_id"]]
    assert (brief["ranked"], any(brief["recordings"]["perfect"])) == ([], False)
    both = [world.owners["recording_id"], world.participants["recording_id"]]
    shown = visitor.get("/api/behaviours/1/library/recordings", params={"recording": both}).json()
    assert [one["id"] for one in shown] == [world.participants["recording_id"]]
    (behaviour,) = visitor.get("/api/behaviours").json()
    assert (behaviour["id"], behaviour["n_recordings"], behaviour["n_ranked"]) == (1, 0, 0)
    checklist = visitor.get("/api/behaviours/1/checklist").json()
    ticks = {one["recording_id"] for one in checklist["planned"]}
    assert ticks <= {None, world.participants["recording_id"]}
    assert world.visitor("elsewhere").get("/api/behaviours").json()[0]["id"] == 2


def test_a_participant_may_do_what_they_like_with_their_own_games(world: World) -> None:
    done = set()
    visitor = world.visitor("participant")
    for name, method, path in world.operations():
        if name in OWN_GAMES_OF_BEHAVIOUR and "delete" not in name and "discard" not in name:
            answer = world.ask("participant", method, path, world.participants)
            # A gif is drawn by a program that may be missing; nothing may be forbidden.
            assert answer.status_code not in {401, 403, 404}, (name, answer.text)
            assert MARK not in answer.text, name
            done.add(name)
    assert len(done) == len(OWN_GAMES_OF_BEHAVIOUR) - 2
    own = f"/api/recordings/{world.participants['recording_id']}"
    assert visitor.post(f"{own}/discard").status_code == 200
    assert visitor.post(f"{own}/restore").status_code == 200
    # The same games are nothing to a participant of another behaviour.
    for name, method, path in world.operations():
        if name in OWN_GAMES_OF_BEHAVIOUR:
            answer = world.ask("elsewhere", method, path, world.participants)
            assert answer.status_code == 404, name


@pytest.mark.parametrize("role", ["researcher", "owner"])
def test_researchers_may_do_everything_but_say_who_gets_in(world: World, role: str) -> None:
    # Each deletes things of their own making, once everything else was asked for.
    things = world.things_to_delete()
    for name, method, path in sorted(
        world.operations(),
        key=lambda one: (
            one[1] == "delete",
            one[0] != "give_game_back",
            one[0] == "delete_behaviour",
        ),
    ):
        if name == STREAM:
            continue  # It never ends; tests/server/api/test_events.py listens.
        ids = {**world.owners, **(things if method == "delete" else {})}
        answer = world.ask(role, method, path, ids)
        if name in OF_WORKER or (name in OF_OWNER and role == "researcher"):
            assert answer.status_code == 403, name
        else:
            assert answer.status_code not in {401, 403}, (name, answer.text)
            if method == "delete":
                assert answer.status_code in {200, 204}, (name, answer.text)
    with world.workplace.database.reading() as session:
        changed = players.get(session, world.owners["player_id"]).role
        assert changed == (Role.PARTICIPANT if role == "owner" else Role.RESEARCHER)


def test_a_workers_key_lets_a_worker_in_and_does_nothing_else(world: World) -> None:
    visitor = world.visitor("worker")
    before = _state(world)
    for name, method, path in world.operations():
        if name == "get_health":
            continue
        for ids in (world.owners, world.participants):
            answer = world.ask("worker", method, path, ids)
            # What the test sends is no worker's request, but it is read.
            assert answer.status_code == (422 if name in OF_WORKER else 403), name
            assert MARK not in answer.text
    assert _state(world) == before
    for path in (f"games/{world.owners['game_id']}/stream", f"runs/{world.owners['run_id']}/watch"):
        authority = str(world.client.base_url).removeprefix("http://").rstrip("/")
        with (
            pytest.raises(WebSocketDisconnect) as refused,
            visitor.websocket_connect(f"ws://{authority}/api/{path}") as socket,
        ):
            socket.receive_text()
        assert refused.value.code == 1008


@pytest.mark.parametrize("role", ["anonymous", "participant", "elsewhere"])
def test_nobody_joins_games_or_watches_runs_of_others(world: World, role: str) -> None:
    paths = [f"/api/games/{world.owners['game_id']}/stream"]
    paths.append(f"/api/runs/{world.owners['run_id']}/watch?player=imitator:greedy")
    if role == "elsewhere":
        paths.append(f"/api/games/{world.participants['game_id']}/stream")
    for path in paths:
        with (
            pytest.raises(WebSocketDisconnect) as refused,
            world.socket(role, path) as socket,
        ):
            socket.receive_text()
        assert refused.value.code == (4401 if role == "anonymous" else 1008), path


def test_a_participant_joins_their_own_game(world: World) -> None:
    path = f"/api/games/{world.participants['game_id']}/stream"
    with world.socket("participant", path) as socket:
        assert '"hello"' in socket.receive_text()


def test_a_route_without_a_declared_need_keeps_the_application_from_being_built() -> None:
    with pytest.raises(RuntimeError, match="new_route"):
        check_all_declared(["new_route"])


def test_recordings_say_who_played_them(world: World) -> None:
    shown = world.visitor("owner").get(f"/api/recordings/{world.participants['recording_id']}")
    assert shown.json()["player"] in {"participant", "Kim"}
    with world.workplace.database.reading() as session:
        row = session.get_one(RecordingRow, world.participants["recording_id"])
        assert row.verification == Verification.VERIFIED
        assert session.get_one(GameRow, world.participants["game_id"]).recording_id


@pytest.mark.parametrize("role", ["participant", "researcher", "owner"])
def test_a_participant_is_told_nothing_of_what_researchers_make_of_a_game(
    world: World, role: str
) -> None:
    visitor = world.visitor(role)
    own = world.participants["recording_id"]
    listed = visitor.get("/api/behaviours/1/recordings").json()
    shown = [visitor.get(f"/api/recordings/{own}").json()]
    shown += [one for one in listed if one["id"] == own]
    assert len(shown) == 2
    exported = visitor.get(f"/api/recordings/{own}/export").json()
    for one in shown:
        said = {name: one[name] for name in RESEARCHERS_FIELDS["Recording"]}
        if role == "participant":
            assert said == RESEARCHERS_FIELDS["Recording"]
        else:
            assert (said["notes"], said["perfect"], said["ranked"]) == (MARK, True, True)
    in_file = {"notes", "perfect", "tier"} & exported.keys()
    assert in_file == (set() if role == "participant" else {"notes", "perfect", "tier"})


def test_who_may_do_what_and_reads_which_field_is_as_documented() -> None:
    docs = Path(__file__).parents[3] / "docs" / "permissions.md"
    assert docs.read_text() == page(), (
        "If participants are not to read a field that is new, name it in RESEARCHERS_FIELDS. Then:"
        " python -m scripts.permissions_page > docs/permissions.md"
    )


@pytest.mark.parametrize("path", ["games", "pictures"])
def test_a_participant_names_no_game_that_they_do_not_play(
    world: World, path: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    visitor = world.visitor("participant")
    assert visitor.get(f"/api/catalogue/{path}/space_invaders").status_code == 200
    made: list[str] = []
    monkeypatch.setattr(catalogue, "game_named", made.append)
    for name in ("pong", "gym:CartPole-v1", "gym:os:Walk-v0"):
        assert visitor.get(f"/api/catalogue/{path}/{name}").status_code == 404
    assert made == []
    assert world.visitor("researcher").get("/api/catalogue/pictures/pong").status_code == 200
