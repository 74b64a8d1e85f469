"""The games that can be taught, in the API."""

from __future__ import annotations

import io
import json

import pytest
from PIL import Image
from starlette.testclient import TestClient

from tests.server.api.games_data import PATH, games
from tril.games import game_named, game_titles
from tril.games.atari.catalogue import entries
from tril.play.pictures import drawn_picture


def test_all_games_are_there_in_order_of_their_titles_while_nobody_has_played(
    client: TestClient,
) -> None:
    games = client.get("/api/catalogue").json()
    assert {one["name"]: one["title"] for one in games} == game_titles()
    titles = [one["title"].casefold() for one in games]
    assert titles == sorted(titles)
    assert {one["name"] for one in games if one["n_behaviours"]} == {"space_invaders"}
    assert all(one["last_played_at"] is None for one in games)


def test_a_game_says_all_that_its_page_needs(client: TestClient) -> None:
    pong = client.get("/api/catalogue/games/pong").json()
    assert pong["buttons"] == ["down", "up", "fire"]
    assert len(pong["held"]) == len(pong["actions"])
    assert set(pong["default_keys"].values()) == set(pong["buttons"])
    assert pong["pixel_aspect"] == pytest.approx(12 / 7)
    assert pong["items"] is None
    assert pong["has_player"] is False
    assert pong["things"]["ball"] == "ball"
    slugs = [behaviour["slug"] for behaviour in pong["ready_made"]]
    assert slugs == ["stay-up", "level-with-the-ball"]
    assert client.get("/api/catalogue/games/chess").status_code == 404


def test_a_ready_made_behaviour_is_added_as_it_is_offered(client: TestClient) -> None:
    seaquest = client.get("/api/catalogue/games/seaquest").json()
    assert seaquest["tallies"] == {"divers": "divers picked up"}
    offered = next(one for one in seaquest["ready_made"] if one["slug"] == "rescue-divers")
    slug = offered.pop("slug")
    created = client.post("/api/behaviours", json=offered | {"game": "seaquest"})
    assert created.status_code == 201
    shown = created.json()
    assert (shown["slug"], shown["built_in"]) == (slug, False)
    assert {name: shown[name] for name in offered} == offered


@pytest.mark.parametrize("name", ["pong", "space_invaders"])
def test_a_picture_is_of_the_games_screen(client: TestClient, name: str) -> None:
    answer = client.get(f"/api/catalogue/pictures/{name}")
    screen = game_named(name).screen
    assert Image.open(io.BytesIO(answer.content)).size == (screen.width, screen.height)
    assert "immutable" in answer.headers["cache-control"]


def test_every_game_of_the_emulator_has_a_drawn_picture() -> None:
    assert [name for name in entries() if drawn_picture(name) is None] == []


def test_the_games_in_the_tests_of_the_page_are_as_the_api_shows_them() -> None:
    assert json.loads(PATH.read_text()) == games()
