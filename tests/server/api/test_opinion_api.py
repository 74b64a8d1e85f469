"""What a linear reward says of a ranking, over HTTP."""

from __future__ import annotations

from typing import Any

import pytest
from starlette.testclient import TestClient

from server.api import replays
from testsupport.workplace import Workplace

OPINION = "/api/behaviours/1/ranking/opinion"


def ask(client: TestClient) -> dict[str, Any]:
    answer = client.get(OPINION)
    assert answer.status_code == 200, answer.text
    opinion: dict[str, Any] = answer.json()
    return opinion


def settled(client: TestClient) -> dict[str, Any]:
    """Ask until every game has been looked at."""
    while (opinion := ask(client))["missing"]:
        pass
    return opinion


def test_each_ranked_and_unranked_game_gets_a_place(
    client: TestClient, workplace: Workplace
) -> None:
    (added,) = client.post("/api/behaviours/1/borrowed", json={"count": 1}).json()
    opinion = settled(client)
    assert (opinion["revision"], opinion["needs_more"]) == (1, False)
    games = {game["recording_id"]: game for game in opinion["games"]}
    assert sorted(games) == sorted([*workplace.ranked, added["id"]])
    for game in games.values():
        assert 0 <= game["best_place"] <= game["place"] <= game["worst_place"] <= 1
        assert 1 <= game["best_tier"] <= game["tier"] <= game["worst_tier"] <= 4


def test_it_follows_the_ranking(client: TestClient, workplace: Workplace) -> None:
    before = settled(client)
    tiers = [[number] for number in reversed(workplace.ranked)]
    client.put("/api/behaviours/1/ranking", json={"base_revision": 1, "tiers": tiers})
    after = ask(client)
    assert after["revision"] == 2
    # Everything is the other way round, what is said of each game, too.
    places = [
        {game["recording_id"]: game["place"] for game in one["games"]} for one in (before, after)
    ]
    for number in workplace.ranked:
        assert places[0][number] + places[1][number] == pytest.approx(1.0)


def test_a_request_replays_for_a_limited_time_and_the_next_gets_on(
    client: TestClient, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(replays, "OPINION_REPLAYS_S", 0.0)
    answers = [ask(client) for _ in range(5)]
    assert [answer["missing"] for answer in answers] == [3, 2, 1, 0, 0]
    assert [len(answer["games"]) for answer in answers] == [0, 0, 0, 4, 4]


def test_too_small_a_ranking_is_no_error(client: TestClient, workplace: Workplace) -> None:
    tiers: list[list[int]]
    for revision, tiers in enumerate(
        [[[key] for key in workplace.ranked[:3]], [[*workplace.ranked]]]
    ):
        update = {"base_revision": revision + 1, "tiers": tiers}
        assert client.put("/api/behaviours/1/ranking", json=update).status_code == 200
        expected = {"revision": revision + 2, "needs_more": True, "missing": 0, "games": []}
        assert ask(client) == expected


def test_an_unknown_behaviour_has_none(client: TestClient) -> None:
    assert client.get("/api/behaviours/999/ranking/opinion").status_code == 404
