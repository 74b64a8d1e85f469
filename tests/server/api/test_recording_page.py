"""The data of a recording's page: its course, its memory, its branches."""

from __future__ import annotations

import numpy as np
from starlette.testclient import TestClient

from tests.server.clients import replayed, stored
from testsupport.workplace import FRAMES, Workplace
from tril.games import game_named
from tril.games.space_invaders import memory as game
from tril.store.models import RecordingRow, RecordingState


def test_the_course_gives_the_action_of_every_frame(
    client: TestClient, workplace: Workplace
) -> None:
    firing, idle, right, _ = workplace.ranked
    courses = {
        key: client.get(f"/api/recordings/{key}/course").json() for key in (firing, idle, right)
    }
    assert courses[firing]["actions"] == [game.Action.FIRE] * FRAMES
    assert courses[idle]["actions"] == [game.Action.NOOP] * FRAMES
    assert courses[right]["actions"] == [game.Action.RIGHT] * FRAMES
    assert courses[firing]["parent"] is None
    assert courses[firing]["branches"] == []


def test_memory_is_that_of_a_replay_at_the_start_and_after_every_frame(
    client: TestClient, workplace: Workplace
) -> None:
    course = client.get(f"/api/recordings/{workplace.ranked[3]}/course").json()
    answer = client.get(course["memory_url"])
    assert "immutable" in answer.headers["cache-control"]
    memory = np.frombuffer(answer.content, np.uint8).reshape(-1, game.RAM_SIZE)
    recording = stored(workplace.database, workplace.ranked[3])
    assert [row.tobytes() for row in memory] == replayed(
        recording, lambda console: console.ram_bytes()
    )
    names = {cell["name"]: cell["address"] for cell in course["memory_names"]}
    cannon = memory[:, names["cannon, x"]].astype(int)
    assert cannon[0] == game.PLAYER_LEFT_WALL
    assert cannon[-1] > cannon[0], "it went to the right"


def test_addresses_are_named_by_the_game_of_the_recording(
    client: TestClient, workplace: Workplace
) -> None:
    with workplace.database.writing() as session:
        row = session.get_one(RecordingRow, workplace.ranked[0])
        pong = game_named("pong")
        row.game, row.game_version, row.end_rule = pong.name, pong.version, pong.end_rule
        row.start = pong.starts.training[0].to_json()
    course = client.get(f"/api/recordings/{workplace.ranked[0]}/course").json()
    assert course.get("memory_names") == [], course


def test_branches_and_their_parent_name_each_other(
    client: TestClient, workplace: Workplace
) -> None:
    parent, branch, deleted, played = workplace.ranked
    with workplace.database.writing() as session:
        for key in (branch, deleted, played):
            row = session.get_one(RecordingRow, key)
            row.parent_id, row.parent_frame = parent, 120
        session.get_one(RecordingRow, played).state = RecordingState.PLAYING
    assert client.delete(f"/api/recordings/{deleted}").status_code == 204
    shown = client.get(f"/api/recordings/{branch}/course").json()
    assert shown["parent"] == {"recording_id": parent, "number": 1, "frame": 120}
    shown = client.get(f"/api/recordings/{parent}/course").json()
    assert shown["branches"] == [{"recording_id": branch, "number": 2, "frame": 120}]
