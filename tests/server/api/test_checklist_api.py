"""The checklist of a behaviour's demonstrations over HTTP."""

from __future__ import annotations

from pathlib import Path

from starlette.testclient import TestClient

from testsupport.workplace import Workplace
from tril.demonstrators import example_plans, rule_violation
from tril.games.space_invaders.behaviours import BUILT_IN

DATA = Path(__file__).parents[2] / "data" / "column-1.jsonl"


def test_the_page_is_told_what_is_there_and_what_is_missing(client: TestClient) -> None:
    lines = DATA.read_bytes().splitlines()
    # One that hits all targets, one that hits half of them, and the one that hits nothing.
    client.post("/api/behaviours/1/recordings/import", content=b"\n".join(lines[0:7:3]))
    checklist = client.get("/api/behaviours/1/checklist").json()
    assert checklist["note"] == ""
    planned = checklist["planned"]
    assert [item["number"] for item in planned] == list(range(1, 13))
    assert planned[0]["description"] == "6 of 6 target aliens, no other"
    there = [item["recording_id"] for item in planned if item["recording_id"]]
    assert len(there) == 3
    for item in planned:
        if item["recording_id"]:
            recording = client.get(f"/api/recordings/{item['recording_id']}").json()
            hits = [(hit["row"], hit["column"]) for hit in recording["hits"]]
            assert rule_violation(example_plans(BUILT_IN[0])[item["number"] - 1], hits) is None
    client.delete(f"/api/recordings/{there[0]}")
    after = client.get("/api/behaviours/1/checklist").json()["planned"]
    assert there[0] not in [item["recording_id"] for item in after]


def test_a_short_game_that_hits_nothing_is_no_demonstration_of_it(
    client: TestClient, workplace: Workplace
) -> None:
    idle = client.get(f"/api/recordings/{workplace.ranked[1]}").json()
    assert (idle["hits"], idle["end"], idle["verification"]) == ([], None, "verified")
    planned = client.get("/api/behaviours/1/checklist").json()["planned"]
    assert planned[6]["description"] == "No alien is hit"
    assert planned[6]["recording_id"] is None


def test_a_behaviour_without_targets_has_no_checklist_and_says_why(client: TestClient) -> None:
    new = client.post("/api/behaviours", json={"name": "Stay on the left"}).json()
    checklist = client.get(f"/api/behaviours/{new['id']}/checklist").json()
    assert checklist["planned"] == []
    assert "no target aliens" in checklist["note"]
    assert client.get("/api/behaviours/999/checklist").status_code == 404
