"""What a ranking says of its games, over HTTP."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from starlette.testclient import TestClient

from server.api import rankings as api
from testsupport.workplace import Workplace
from tril.demonstrators import play_randomly
from tril.games.space_invaders import SPACE_INVADERS
from tril.store import recordings
from tril.store.models import Source

OPINION = "/api/behaviours/1/ranking/opinion"


def ask(client: TestClient) -> dict[str, Any]:
    answer = client.get(OPINION)
    assert answer.status_code == 200, answer.text
    opinion: dict[str, Any] = answer.json()
    return opinion


def places(opinion: dict[str, Any]) -> dict[int, float]:
    return {game["recording_id"]: game["place"] for game in opinion["games"]}


def test_each_ranked_and_unranked_game_gets_a_place(
    client: TestClient, workplace: Workplace
) -> None:
    (added,) = client.post("/api/behaviours/1/borrowed", json={"count": 1}).json()
    opinion = ask(client)
    assert opinion["revision"] == 1
    games = {game["recording_id"]: game for game in opinion["games"]}
    assert sorted(games) == sorted([*workplace.ranked, added["id"]])
    for game in games.values():
        assert 0 <= game["best_place"] <= game["place"] <= game["worst_place"] <= 1
        assert 1 <= game["best_tier"] <= game["tier"] <= game["worst_tier"] <= 4


def test_it_follows_the_ranking(client: TestClient, workplace: Workplace) -> None:
    hit: list[list[list[int]]] = [
        [[0, 0, 20], [1, 0, 40], [2, 0, 60]],
        [[0, 0, 20]],
        [],
        [[0, 3, 20], [0, 2, 40]],
    ]
    with workplace.database.writing() as session:
        for number, hits in zip(workplace.ranked, hit, strict=True):
            recordings.get(session, number).taken = hits
        # A star would tell what is wanted, whatever the order.
        recordings.update(session, recordings.get(session, workplace.ranked[0]), perfect=False)
    before = ask(client)
    best, *_, worst = workplace.ranked
    assert places(before)[best] < places(before)[worst]
    # The first column's lowest alien is wanted, those of others are not.
    assert before["wanted"]["labels"][0] > 0 > max(before["wanted"]["labels"][1:6])
    assert len(before["wanted"]["in_order"]) == 36
    tiers = [[number] for number in reversed(workplace.ranked)]
    client.put("/api/behaviours/1/ranking", json={"base_revision": 1, "tiers": tiers})
    after = ask(client)
    assert after["revision"] == 2
    assert places(after)[best] > places(after)[worst]
    assert after["wanted"]["labels"][0] < before["wanted"]["labels"][0]


def test_perfect_games_are_asked_even_if_they_are_not_looked_at_otherwise(
    client: TestClient, workplace: Workplace, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(api, "MAX_UNRANKED_OPINIONS", 1)
    rng = np.random.default_rng(5)
    with workplace.database.writing() as session:
        ids = []
        for _ in range(3):
            one = play_randomly(rng, SPACE_INVADERS.make_console())
            ids.append(recordings.add(session, 1, one.recording, one.replay, Source.VARIED).id)
    before = ask(client)
    assert places(before).keys() == {*workplace.ranked, ids[-1]}
    assert client.patch(f"/api/recordings/{ids[0]}", json={"perfect": True}).status_code == 200
    after = ask(client)
    assert places(after).keys() == {*workplace.ranked, ids[0], ids[-1]}
    assert after["wanted"] != before["wanted"]


def test_too_small_a_ranking_is_no_error(client: TestClient, workplace: Workplace) -> None:
    tiers: list[list[int]]
    for revision, tiers in enumerate(
        [[[key] for key in workplace.ranked[:3]], [[*workplace.ranked]]]
    ):
        update = {"base_revision": revision + 1, "tiers": tiers}
        assert client.put("/api/behaviours/1/ranking", json=update).status_code == 200
        assert ask(client) == {"revision": revision + 2, "games": [], "wanted": None}


def test_an_unknown_behaviour_has_none(client: TestClient) -> None:
    assert client.get("/api/behaviours/999/ranking/opinion").status_code == 404
