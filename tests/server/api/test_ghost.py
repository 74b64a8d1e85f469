"""The best demonstration's cannon, over HTTP and against the screens."""

from __future__ import annotations

import numpy as np
import pytest
from starlette.testclient import TestClient

from server.play.replays.products import memory_file
from testsupport.workplace import FRAMES, Workplace
from tril.games.atari.starts import AtariStart
from tril.games.space_invaders import SPACE_INVADERS
from tril.games.space_invaders import memory as game
from tril.games.space_invaders.cannon_track import cannon_track
from tril.play.episode import Episode
from tril.recording import Recorder
from tril.store import recordings

CANNON_COLOUR = 196


@pytest.mark.parametrize("difficulty", [0, 1])
def test_the_track_is_where_every_screen_shows_the_cannon(difficulty: int) -> None:
    console = SPACE_INVADERS.make_console()
    recorder = Recorder(Episode(console, AtariStart(40, difficulty=difficulty)))
    screens = [console.screen()]
    for action in [game.Action.RIGHT] * 120 + [game.Action.LEFT] * 30:
        recorder.advance(action)
        screens.append(console.screen())
    track = cannon_track(
        memory_file(recorder.recording(), console), AtariStart(0, difficulty=difficulty)
    )
    assert len(track.lefts) == 151
    for left, screen in zip(track.lefts, screens, strict=True):
        rows, columns = np.nonzero(
            screen[track.top : track.top + track.height, left - 2 : left + track.width + 2]
            == CANNON_COLOUR
        )
        assert (columns.min(), columns.max()) == (2, track.width + 1)
        assert (rows.min(), rows.max()) == (0, track.height - 1)


def test_the_best_ranked_recording_leaves_the_ghost(
    client: TestClient, workplace: Workplace
) -> None:
    firing, _, right, _ = workplace.ranked
    ghost = client.get("/api/behaviours/1/ghost").json()
    assert (ghost["recording_id"], ghost["source"]) == (firing, "scripted")
    assert set(ghost["lefts"]) == {34}
    ranking = {"base_revision": 1, "tiers": [[right, firing]]}
    assert client.put("/api/behaviours/1/ranking", json=ranking).status_code == 200
    ghost = client.get("/api/behaviours/1/ghost").json()
    assert ghost["recording_id"] == right
    assert len(ghost["lefts"]) == FRAMES + 1
    assert ghost["lefts"][0] == 34
    assert ghost["lefts"][-1] > 100


def test_without_a_ranking_it_is_the_newest_perfect_one_and_else_none(
    client: TestClient, workplace: Workplace
) -> None:
    firing, idle, _, _ = workplace.ranked
    client.put("/api/behaviours/1/ranking", json={"base_revision": 1, "tiers": []})
    client.patch(f"/api/recordings/{idle}", json={"perfect": True})
    assert client.get("/api/behaviours/1/ghost").json()["recording_id"] == idle
    for key in (firing, idle):
        client.patch(f"/api/recordings/{key}", json={"perfect": False})
    answer = client.get("/api/behaviours/1/ghost")
    assert answer.status_code == 200
    assert answer.json() is None
    assert client.get("/api/behaviours/999/ghost").status_code == 404


def test_a_deleted_recording_leaves_no_ghost(client: TestClient, workplace: Workplace) -> None:
    firing, idle, _, _ = workplace.ranked
    client.delete(f"/api/recordings/{firing}")
    assert client.get("/api/behaviours/1/ghost").json()["recording_id"] == idle
    with workplace.database.reading() as session:
        assert recordings.get(session, firing).deleted_at is not None
