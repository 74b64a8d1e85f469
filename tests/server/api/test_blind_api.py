"""The blind comparison over HTTP: nothing tells whose a game is until the round is over."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy import select
from starlette.testclient import TestClient

from tests.server.clients import build_frontend, signed_in
from testsupport.finished_runs import add_greedy_games, make_finished_run
from testsupport.visitors import cookie_of
from testsupport.workplace import Workplace, make_workplace
from tril.store import audit, players
from tril.store.models import BlindAnswerRow, Role
from tril.store.training import blind_answers, runs

N_PAIRS = 7
"""Five against the clone; two demonstrations are in the upper half."""


@pytest.fixture
def place(tmp_path: Path) -> Iterator[tuple[Workplace, TestClient, str]]:
    """Return a data folder with a finished run, a client of the owner, and the run's address."""
    workplace = make_workplace(tmp_path / "data")
    run_id = make_finished_run(workplace)
    add_greedy_games(workplace, run_id, range(3, 12))
    with signed_in(workplace, build_frontend(tmp_path)) as client:
        yield workplace, client, f"/api/runs/{run_id}/blind"
    workplace.database.close()


def give(client: TestClient, path: str, number: int, pair: int, answer: str) -> Any:
    return client.post(f"{path}/answers", json={"round": number, "pair": pair, "answer": answer})


def judge(client: TestClient, path: str, number: int, *answers: str) -> dict[str, Any]:
    """Judge the first pairs of a round."""
    shown: dict[str, Any] = {}
    for pair, answer in enumerate(answers, start=1):
        response = give(client, path, number, pair, answer)
        assert response.status_code == 200, response.text
        shown = response.json()
    return shown


def test_nothing_tells_whose_a_game_is_before_the_round_is_over(
    place: tuple[Workplace, TestClient, str],
) -> None:
    workplace, client, path = place
    shown = judge(client, path, 1, *["left"] * N_PAIRS)
    run_id = path.split("/")[3]
    frames_url = f"{path}/1/{{pair}}/{{side}}/frames"
    expected = {
        "round": 1,
        "n_pairs": N_PAIRS,
        "answers": ["left"] * N_PAIRS,
        "frames_url": frames_url,
        "finished": [],
    }
    assert shown == expected, "not even the result, from which the last answers could be told"
    assert client.get(path).json() == expected
    assert client.get(f"/api/runs/{run_id}/results").json()["blind"] is None
    with workplace.database.reading() as session:
        pairs = blind_answers.pairs_of(session, runs.get(session, run_id), 1)
    response = client.get(frames_url.format(pair=1, side="left"))
    theirs = client.get(f"/api/recordings/{pairs[0].sides[0]}/frames")
    assert response.content == theirs.content != b""
    assert set(response.headers) <= {*theirs.headers}
    assert client.get(frames_url.format(pair=N_PAIRS + 1, side="left")).status_code == 404


def test_the_end_tells_whose_they_were_and_what_came_of_it(
    place: tuple[Workplace, TestClient, str],
) -> None:
    workplace, client, path = place
    run_id = path.split("/")[3]
    with workplace.database.reading() as session:
        pairs = blind_answers.pairs_of(session, runs.get(session, run_id), 1)
    # The imitator's is closer in all but one pair, and one is equal.
    wins = ["left" if pair.imitator_left else "right" for pair in pairs]
    lost = "right" if wins[0] == "left" else "left"
    judge(client, path, 1, lost, "equal", *wins[2:])
    (finished,) = give(client, path, 1, N_PAIRS, "ended").json()["finished"]
    result = finished["result"]
    assert (result["wins"], result["share"]["n"]) == (N_PAIRS - 1.5, N_PAIRS)
    assert {one["opponent"]: one["n"] for one in result["against"]} == {
        "clone": 5,
        "demonstrator": 2,
    }
    assert [pair["imitator"]["id"] for pair in finished["pairs"]] == [
        pair.imitator_id for pair in pairs
    ]
    assert [pair["answer"] for pair in finished["pairs"]] == [lost, "equal", *wins[2:]]
    assert client.get(f"/api/runs/{run_id}/results").json()["blind"] == result
    with workplace.database.reading() as session:
        assert audit.page(session)[0].action == audit.Action.COMPARED
    assert give(client, path, 1, N_PAIRS, "taken back").status_code == 409
    again = judge(client, path, 2, "equal")
    assert (again["round"], again["answers"], len(again["finished"])) == (2, ["equal"], 1)
    stored = client.get(f"/api/runs/{run_id}/results").json()["blind"]
    assert stored == result, "a round counts once it is over"
    give(client, path, 2, 1, "ended")
    blind = client.get(f"/api/runs/{run_id}/results").json()["blind"]
    assert (blind["wins"], blind["share"]["n"]) == (0.5, 1), "the latest round counts"
    assert [one["number"] for one in client.get(path).json()["finished"]] == [2, 1]


def test_the_last_answer_is_taken_back_and_all_are_kept(
    place: tuple[Workplace, TestClient, str],
) -> None:
    workplace, client, path = place
    assert give(client, path, 1, 1, "ended").status_code == 409, "nothing was judged"
    judge(client, path, 1, "left", "right")
    assert give(client, path, 1, 1, "taken back").status_code == 409, "it is not the last"
    assert give(client, path, 1, 2, "taken back").json()["answers"] == ["left"]
    assert give(client, path, 1, 2, "equal").json()["answers"] == ["left", "equal"]
    with workplace.database.reading() as session:
        rows = session.scalars(select(BlindAnswerRow).order_by(BlindAnswerRow.id)).all()
        assert [(row.pair, row.answer) for row in rows] == [
            (1, "left"),
            (2, "right"),
            (2, "taken back"),
            (2, "equal"),
        ]


def test_another_tab_does_not_judge_a_pair_twice(
    place: tuple[Workplace, TestClient, str],
) -> None:
    _, client, path = place
    judge(client, path, 1, "left")
    late = give(client, path, 1, 1, "right")
    assert (late.status_code, "continued elsewhere" in late.json()["detail"]) == (409, True)
    assert give(client, path, 1, 3, "left").status_code == 409
    assert give(client, path, 2, 1, "left").status_code == 409
    assert client.get(path).json()["answers"] == ["left"]


def test_two_people_judge_the_same_pairs_and_see_only_their_own_answers(
    place: tuple[Workplace, TestClient, str],
) -> None:
    workplace, client, path = place
    run_id = path.split("/")[3]
    with workplace.database.writing() as session:
        ria = players.add(session, "Ria", Role.RESEARCHER).id
    other = TestClient(client.app, base_url=str(client.base_url))
    other.cookies.set(*cookie_of(workplace.settings, ria))
    judge(client, path, 1, "equal", "equal")
    mine = give(client, path, 1, 2, "ended").json()["finished"][0]
    theirs = other.get(path).json()
    assert (theirs["round"], theirs["answers"], theirs["finished"]) == (1, [], [])
    names = [str(game["strip_url"]) for pair in mine["pairs"] for game in (pair["imitator"],)]
    assert not any(name in json.dumps(theirs) for name in names)
    judge(other, path, 1, "equal", "equal", "equal")
    (told,) = give(other, path, 1, 3, "ended").json()["finished"]
    assert [pair["other"]["id"] for pair in told["pairs"][:2]] == [
        pair["other"]["id"] for pair in mine["pairs"]
    ]
    blind = client.get(f"/api/runs/{run_id}/results").json()["blind"]
    assert (blind["n_people"], blind["wins"], blind["share"]["n"]) == (2, 2.5, 5)


def test_a_deleted_run_takes_its_comparison_with_it_and_brings_it_back(
    place: tuple[Workplace, TestClient, str],
) -> None:
    _, client, path = place
    judge(client, path, 1, "left")
    run = path.removesuffix("/blind")
    assert client.delete(run).status_code == 204
    assert client.get(path).status_code == 404
    assert give(client, path, 1, 2, "left").status_code == 404
    assert client.get(f"{path}/1/1/left/frames").status_code == 404
    client.post(f"{run}/restore")
    assert client.get(path).json()["answers"] == ["left"]


def test_a_run_that_is_not_done_has_nothing_to_compare(
    place: tuple[Workplace, TestClient, str],
) -> None:
    workplace, client, _ = place
    path = f"/api/runs/{workplace.make_run()}/blind"
    assert client.get(path).json()["n_pairs"] == 0
    assert give(client, path, 1, 1, "left").status_code == 409
