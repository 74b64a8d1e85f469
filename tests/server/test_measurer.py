"""Recordings are measured in the background, as soon as their behaviour asks for something."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import pytest
from starlette.testclient import TestClient

from server.measurer import Measurer
from server.play.replays import ReplayProcess
from testsupport.finished_runs import make_finished_run
from testsupport.waiting import wait_until
from testsupport.workplace import Workplace
from tril.errors import Unavailable
from tril.games.measures import Measure
from tril.games.measuring import Values
from tril.recording import Recording
from tril.store import behaviours, measured, recordings
from tril.store.models import Source

CANNON_LEFT = {"kind": "region", "thing": "cannon", "area": [0, 0, 78, 210], "at_least": 0.9}
SHOTS = {"kind": "counter", "counter": "shots", "at_most": 1}


def ask_for(client: TestClient, workplace: Workplace, *measures: dict[str, Any]) -> None:
    answer = client.patch(
        f"/api/behaviours/{workplace.behaviour_id}", json={"measures": list(measures)}
    )
    assert answer.status_code == 200, answer.text
    shown = answer.json()["measures"]
    set_members = [
        {name: value for name, value in one.items() if value is not None} for one in shown
    ]
    assert set_members == list(measures)


def listed(client: TestClient, workplace: Workplace) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = client.get(
        f"/api/behaviours/{workplace.behaviour_id}/recordings"
    ).json()
    return found


def known(client: TestClient, workplace: Workplace) -> bool:
    games = listed(client, workplace)
    return all(one["known"] for game in games for one in game["measured"])


def test_recordings_are_measured_once_their_behaviour_asks_for_something(
    client: TestClient, workplace: Workplace
) -> None:
    ask_for(client, workplace, CANNON_LEFT, SHOTS)
    wait_until(lambda: known(client, workplace))
    games = listed(client, workplace)
    assert len(games) == len(workplace.ranked)
    for game in games:
        left, shots = game["measured"]
        assert (left["unit"], shots["unit"]) == ("share", "count")
        assert left["met"] is (left["value"] >= 0.9)
        assert shots["value"] == game["counters"]["shots"]
        assert shots["met"] is (shots["value"] <= 1)
    library = client.get(f"/api/behaviours/{workplace.behaviour_id}/library").json()
    columns = library["recordings"]["measured"]
    assert columns == [[game["measured"][place]["value"] for game in games] for place in (0, 1)]


def test_another_bound_is_judged_at_once_and_another_measure_is_measured(
    client: TestClient, workplace: Workplace
) -> None:
    ask_for(client, workplace, SHOTS)
    wait_until(lambda: known(client, workplace))
    ask_for(client, workplace, {"kind": "counter", "counter": "shots", "at_least": 1000})
    assert all(game["measured"][0]["met"] is False for game in listed(client, workplace))
    ask_for(client, workplace, {"kind": "length", "at_least": 3})
    wait_until(lambda: known(client, workplace))
    assert {game["measured"][0]["value"] for game in listed(client, workplace)} == {4.0}
    ask_for(client, workplace)
    assert all(game["measured"] == [] for game in listed(client, workplace))


def test_the_results_of_a_run_tell_what_its_policies_and_people_measure(
    client: TestClient, workplace: Workplace
) -> None:
    run_id = make_finished_run(workplace)
    with workplace.database.writing() as session:
        recordings.get(session, workplace.ranked[0]).source = Source.PERSON
    ask_for(client, workplace, SHOTS)

    def rows() -> list[dict[str, Any]]:
        results = client.get(f"/api/runs/{run_id}/results").json()
        shown: list[dict[str, Any]] = results["measures"]
        return shown

    wait_until(lambda: all(rows()[0][player] for player in ("imitator", "clone", "person")))
    wait_until(lambda: known(client, workplace))
    (row,) = rows()
    assert (row["unit"], row["measure"]["kind"]) == ("count", "counter")
    results = client.get(f"/api/runs/{run_id}/results").json()
    for policy in ("imitator", "clone"):
        shots = [
            game["recording"]["counters"]["shots"]
            for game in results["games"]
            if game["policy"] == policy
            and game["action_selection"] == "greedy"
            and game["held_out"]
        ]
        met = sum(count <= 1 for count in shots)
        mean = {"n": len(shots), "mean": sum(shots) / len(shots), "n_met": met}
        assert row[policy] == mean
    assert row["person"]["n"] == 1


@pytest.mark.parametrize(
    ("measure", "message"),
    [
        ({"kind": "region", "thing": "ball", "area": [0, 0, 9, 9]}, "it has cannon, missile"),
        ({"kind": "region", "thing": "cannon"}, "needs area, thing"),
        ({"kind": "score", "thing": "cannon"}, "but no 'thing'"),
        ({"kind": "alive", "at_least": 1}, "no bounds"),
    ],
)
def test_a_measure_that_makes_no_sense_is_refused_with_what_does(
    client: TestClient, workplace: Workplace, measure: dict[str, Any], message: str
) -> None:
    url = f"/api/behaviours/{workplace.behaviour_id}"
    answer = client.patch(url, json={"measures": [measure]})
    assert answer.status_code == 422
    assert message in answer.text


class FailingReplays(ReplayProcess):
    """Measures every recording but one, whose replay fails."""

    def __init__(self, actions: bytes) -> None:
        self._actions: bytes | None = actions

    def heal(self) -> None:
        """Let its replay succeed from now on."""
        self._actions = None

    def measure(self, recording: Recording, measures: Sequence[Measure]) -> Values:
        if recording.actions == self._actions:
            raise Unavailable("Its replay failed.")
        return {measure.key: 1.0 for measure in measures}


def test_a_recording_whose_replay_fails_holds_no_other_up(workplace: Workplace) -> None:
    failing = workplace.ranked[1]
    with workplace.database.writing() as session:
        behaviours.get(session, workplace.behaviour_id).measures = [SHOTS]
        actions = recordings.as_recording(recordings.get(session, failing)).actions
    replays = FailingReplays(actions)
    measurer = Measurer(workplace.database, replays)
    measurer.measure_all()
    with workplace.database.reading() as session:
        assert list(measured.unmeasured(session)) == [failing]
    replays.heal()
    measurer.measure_all()
    with workplace.database.reading() as session:
        assert not measured.unmeasured(session)
