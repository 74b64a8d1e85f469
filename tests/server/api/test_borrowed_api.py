"""Varied games and those of policies over HTTP: added, listed, ranked and given back."""

from __future__ import annotations

from typing import Any

import pytest
from starlette.testclient import TestClient

from testsupport.libraries import rows_of, unranked_in
from testsupport.workplace import Workplace
from tril.games.behaviours import Score
from tril.recording import verify
from tril.store import recordings
from tril.store.models import Source
from tril.store.training import evaluations, runs
from tril.store.training.evaluations import EvaluationKey

COLUMN_1 = "/api/behaviours/1"
COLUMN_2 = "/api/behaviours/2"


def add(client: TestClient, count: int) -> list[dict[str, Any]]:
    answer = client.post(f"{COLUMN_2}/borrowed", json={"count": count})
    assert answer.status_code == 201, answer.text
    added: list[dict[str, Any]] = answer.json()
    return added


def test_varied_games_are_added_unranked_and_said_to_be_what_they_are(
    client: TestClient, workplace: Workplace
) -> None:
    added = add(client, 4)
    of_others, made = added[:2], added[2:]
    assert {one["id"] for one in of_others} < set(workplace.ranked)
    assert {(one["behaviour_name"], one["borrowed"]) for one in of_others} == {("Column 1", True)}
    assert {(one["source"], one["behaviour_id"]) for one in made} == {("varied", 2)}
    assert {(one["player"], one["borrowed"]) for one in made} == {(None, False)}
    assert {one["verification"] for one in added} == {"verified"}
    ranking = client.get(f"{COLUMN_2}/ranking").json()
    assert ranking["tiers"] == []
    assert set(unranked_in(client, COLUMN_2)) == {one["id"] for one in added}
    listed = rows_of(client.get(f"{COLUMN_2}/borrowed").json())
    assert sorted(one["id"] for one in listed) == sorted(one["id"] for one in of_others)
    assert {one["behaviour_name"] for one in listed} == {"Column 1"}
    assert {one["number"] for one in made} == {1, 2}, "numbers are of the behaviour"
    library = client.get(f"{COLUMN_2}/recordings").json()
    assert {one["id"] for one in library} == {one["id"] for one in made}


def test_a_borrowed_game_is_judged_by_its_borrower(
    client: TestClient, workplace: Workplace
) -> None:
    firing, *others = workplace.ranked
    with workplace.database.writing() as session:
        recordings.get(session, firing).taken = [[0, 0, 120]]
    (at_home,) = (one for one in client.get(f"{COLUMN_1}/recordings").json() if one["perfect"])
    assert at_home["id"] == firing
    assert (at_home["targets"], at_home["strays"], at_home["ranked"]) == (1, 0, True)
    add(client, 8)
    shown = {one["id"]: one for one in rows_of(client.get(f"{COLUMN_2}/borrowed").json())}
    assert sorted(shown) == sorted([firing, *others])
    borrowed = shown[firing]
    assert (borrowed["targets"], borrowed["strays"]) == (0, 1)
    assert not borrowed["perfect"]
    assert not borrowed["ranked"]
    client.put(f"{COLUMN_2}/ranking", json={"base_revision": 0, "tiers": [[firing]]})
    assert {one["id"]: one for one in rows_of(client.get(f"{COLUMN_2}/borrowed").json())}[firing][
        "ranked"
    ]


def test_a_game_is_given_back_once_it_is_off_the_board(
    client: TestClient, workplace: Workplace
) -> None:
    one = add(client, 2)[0]["id"]
    client.put(f"{COLUMN_2}/ranking", json={"base_revision": 0, "tiers": [[one]]})
    refused = client.delete(f"{COLUMN_2}/borrowed/{one}")
    assert refused.status_code == 409
    assert "Take it off the board" in refused.json()["detail"]
    client.put(f"{COLUMN_2}/ranking", json={"base_revision": 1, "tiers": []})
    assert client.delete(f"{COLUMN_2}/borrowed/{one}").status_code == 204
    assert rows_of(client.get(f"{COLUMN_2}/borrowed").json()) == []
    assert one not in unranked_in(client, COLUMN_2)
    assert client.get(f"/api/recordings/{one}").json()["deleted"] is False
    assert client.delete(f"{COLUMN_2}/borrowed/{one}").status_code == 404


def test_a_run_shows_borrowed_games_by_its_own_target(
    client: TestClient, workplace: Workplace
) -> None:
    firing, idle, *_ = workplace.ranked
    own = add(client, 8)[-1]["id"]
    with workplace.database.writing() as session:
        recordings.get(session, firing).taken = [[0, 1, 120]]
        # Varied play hits something or other.
        recordings.get(session, own).taken = []
    client.patch(f"/api/recordings/{own}", json={"perfect": True})
    tiers = [[firing], [own], [idle]]
    answer = client.put(f"{COLUMN_2}/ranking", json={"base_revision": 0, "tiers": tiers})
    assert answer.status_code == 200, answer.text
    run = client.post("/api/runs", json={"behaviour_id": 2, "recipe": "fast", "steps": 10_000})
    assert run.status_code == 201, run.text
    best = client.get(f"/api/runs/{run.json()['id']}/results").json()["best_demonstration"]
    assert (best["id"], best["targets"], best["borrowed"]) == (firing, 1, True)


def policys_game(workplace: Workplace) -> tuple[str, int]:
    """Return a run of column 1 that is over, and a game that its policy has played."""
    run_id = workplace.make_run()
    with workplace.database.writing() as session:
        runs.request_cancel(session, run_id)
        game = recordings.as_recording(recordings.get(session, workplace.ranked[0]))
        played = verify(game).replay
        row = recordings.add(session, 1, game, played, Source.POLICY, run_id=run_id)
        key = EvaluationKey("imitator", "sticky", 7)
        evaluations.add(session, run_id, key, row.id, True, 1.5, 0.5, Score(3, 1, 0))
        return run_id, row.id


def test_a_policys_game_is_added_to_the_ranking_and_outlives_its_run(
    client: TestClient, workplace: Workplace
) -> None:
    run_id, game = policys_game(workplace)
    (shown,) = client.get(f"/api/runs/{run_id}/results").json()["games"]
    assert not shown["recording"]["borrowed"]
    assert client.get(f"/api/runs/{run_id}/results").json()["proposed"] == [game]
    answer = client.post(f"{COLUMN_1}/ranking/games", json={"recording_ids": [game]})
    assert answer.status_code == 201, answer.text
    (added,) = answer.json()
    assert (added["id"], added["run_id"], added["borrowed"]) == (game, run_id, True)
    assert (added["perfect"], added["ranked"]) == (False, False)
    assert unranked_in(client, COLUMN_1) == [game]
    assert [one["id"] for one in rows_of(client.get(f"{COLUMN_1}/borrowed").json())] == [game]
    (shown,) = client.get(f"/api/runs/{run_id}/results").json()["games"]
    assert shown["recording"]["borrowed"]

    tiers = [[game], [workplace.ranked[0]]]
    ranked = client.put(f"{COLUMN_1}/ranking", json={"base_revision": 1, "tiers": tiers})
    assert ranked.status_code == 200, ranked.text
    assert client.delete(f"/api/runs/{run_id}").status_code == 204
    assert client.get(f"{COLUMN_1}/ranking").json()["tiers"] == tiers
    (kept,) = rows_of(client.get(f"{COLUMN_1}/borrowed").json())
    assert (kept["id"], kept["ranked"]) == (game, True)
    again = client.post("/api/runs", json={"behaviour_id": 1})
    assert again.status_code == 201, again.text


def test_games_that_can_not_be_added_are_refused_by_name(
    client: TestClient, workplace: Workplace
) -> None:
    def add_games(ids: list[int], behaviour: str = COLUMN_1) -> tuple[int, str]:
        answer = client.post(f"{behaviour}/ranking/games", json={"recording_ids": ids})
        return answer.status_code, str(answer.json()["detail"])

    own = workplace.ranked[0]
    status, detail = add_games([own])
    assert (status, f"recording {own} is in the behaviour's library" in detail) == (409, True)
    assert add_games([999]) == (404, "There are no such recordings: 999.")
    assert add_games([own], "/api/behaviours/999")[0] == 404
    assert add_games([])[0] == add_games([own] * 61)[0] == add_games([0])[0] == 422
    assert rows_of(client.get(f"{COLUMN_1}/borrowed").json()) == []


@pytest.mark.parametrize("body", [{"count": 0}, {"count": 61}, {"count": "x"}, {"n": 3}])
def test_a_malformed_wish_is_refused(reader: TestClient, body: object) -> None:
    assert reader.post(f"{COLUMN_2}/borrowed", json=body).status_code == 422


def test_an_unknown_behaviour_is_none_to_borrow_for(reader: TestClient) -> None:
    assert reader.post("/api/behaviours/999/borrowed", json={}).status_code == 404
    assert reader.get("/api/behaviours/999/borrowed").status_code == 404
