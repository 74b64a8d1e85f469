"""The games that can be taught, and behaviours of any of them."""

from __future__ import annotations

import pytest
from starlette.testclient import TestClient


def _behaviour(client: TestClient, **values: object) -> dict[str, object]:
    answer = client.post("/api/behaviours", json={"name": "Stay up", **values})
    assert answer.status_code == 201, answer.text
    return dict(answer.json())


def test_games_that_were_played_come_first(client: TestClient) -> None:
    behaviour = _behaviour(client, game="pong")
    assert client.get("/api/catalogue").json()[0]["name"] != "pong"
    assert client.post("/api/games", json={"behaviour_id": behaviour["id"]}).status_code == 201
    (first, *_) = client.get("/api/catalogue").json()
    assert (first["name"], first["n_behaviours"]) == ("pong", 1)
    assert first["last_played_at"]


def test_a_game_says_what_the_page_needs_of_it(reader: TestClient) -> None:
    game = reader.get("/api/catalogue/games/ms_pacman").json()
    assert (game["title"], game["width"], game["height"]) == ("Ms. Pac-Man", 160, 210)
    assert game["buttons"] == ["left", "right", "up", "down"]
    held = dict(zip(game["actions"], game["held"], strict=True))
    assert held["NOOP"] == 0
    assert held["UPRIGHT"] == held["UP"] | held["RIGHT"]
    assert set(game["default_keys"].values()) == set(game["buttons"])
    assert game["items"] is None
    assert not game["has_player"]
    known = reader.get("/api/catalogue/games/space_invaders").json()
    assert known["has_player"]
    assert (known["items"]["rows"], known["items"]["plural"]) == (6, "aliens")


@pytest.mark.parametrize("path", ["games/tetris_2", "pictures/tetris_2"])
def test_a_game_that_there_is_not_is_not_found(reader: TestClient, path: str) -> None:
    answer = reader.get(f"/api/catalogue/{path}")
    assert answer.status_code == 404
    assert "tril games list" in answer.json()["detail"]


def test_a_behaviour_sets_its_game_until_it_was_played(client: TestClient) -> None:
    settings = {"max_steps": 600, "end_rule": "over", "options": {"mode": 4}, "hidden": None}
    behaviour = _behaviour(client, game="breakout", settings=settings)
    assert behaviour["settings"] == settings
    url = f"/api/behaviours/{behaviour['id']}"
    game = client.post("/api/games", json={"behaviour_id": behaviour["id"]}).json()
    assert game["max_frames"] == 2400
    longer = client.patch(url, json={"settings": {**settings, "max_steps": 900}})
    assert longer.status_code == 409
    assert "how the game is played" in longer.json()["detail"].lower()
    masked = client.patch(url, json={"settings": {**settings, "hidden": [[0, 0, 160, 20]]}})
    assert masked.json()["settings"]["hidden"] == [[0, 0, 160, 20]]


@pytest.mark.parametrize(
    ("values", "reason"),
    [
        ({"game": "tetris_2"}, "no game"),
        ({"game": "pong", "target": [[0, 0]]}, "nothing that can be counted"),
        ({"game": "pong", "settings": {"max_steps": 5}}, "25 to 6000 steps"),
        ({"game": "pong", "settings": {"options": {"mode": 99}}}, "Expected mode"),
        ({"game": "pong", "settings": {"hidden": [[0, 0, 500, 10]]}}, "within the screen"),
    ],
)
def test_a_behaviour_that_a_game_does_not_allow_is_refused(
    client: TestClient, values: dict[str, object], reason: str
) -> None:
    answer = client.post("/api/behaviours", json={"name": "Stay up", **values})
    assert answer.status_code in (404, 422)
    assert reason in answer.json()["detail"]


def test_recipes_are_those_of_the_game(client: TestClient) -> None:
    of = {
        game: [one["name"] for one in client.get("/api/recipes", params={"game": game}).json()]
        for game in ("space_invaders", "pong")
    }
    assert of["space_invaders"][0] == "fast"
    answer = client.get("/api/recipes", params={"game": "space_invaders", "has_target": False})
    of_no_target = [one["name"] for one in answer.json()]
    assert of_no_target[0] == "any"
    assert sorted(of_no_target) == sorted(of["space_invaders"])
    assert of["pong"] == ["any", "paper", "gail"]
    behaviour = _behaviour(client, game="pong")
    answer = client.post(
        "/api/runs", json={"behaviour_id": behaviour["id"], "recipe": "fast", "steps": 10}
    )
    assert answer.status_code == 422
    assert "choose one of any, paper, gail" in answer.json()["detail"]
