"""Rankings over HTTP: saving, undo, redo and refusals."""

from __future__ import annotations

import pytest
from starlette.testclient import TestClient

from testsupport.libraries import unranked_in
from testsupport.workplace import Workplace
from tril.store import rankings
from tril.store.models import RecordingRow, Verification

PATH = "/api/behaviours/1/ranking"


def save(client: TestClient, base_revision: int, tiers: list[list[int]]) -> dict[str, object]:
    answer = client.put(PATH, json={"base_revision": base_revision, "tiers": tiers})
    assert answer.status_code == 200, answer.text
    ranking: dict[str, object] = answer.json()
    return ranking


def test_a_ranking_is_saved_with_ties_and_a_tray(client: TestClient, workplace: Workplace) -> None:
    a, b, c, d = workplace.ranked
    assert client.get(PATH).json()["n_pairs"] == 6
    saved = save(client, 1, [[a, b], [d]])
    assert saved["tiers"] == [[a, b], [d]]
    assert unranked_in(client, "/api/behaviours/1") == [c]
    assert (saved["revision"], saved["n_pairs"]) == (2, 2)
    assert save(client, 2, [[a, b], [d]])["revision"] == 2, "the same order is no new revision"


def test_an_old_base_revision_is_refused_with_both_orders(
    client: TestClient, workplace: Workplace
) -> None:
    a, b, c, d = workplace.ranked
    save(client, 1, [[d], [a]])
    answer = client.put(PATH, json={"base_revision": 1, "tiers": [[b], [c]]})
    assert answer.status_code == 409
    conflict = answer.json()
    assert conflict["current"]["tiers"] == [[d], [a]]
    assert conflict["yours"] == [[b], [c]]
    assert "not saved" in conflict["detail"]
    for step in ("undo", "redo"):
        answer = client.post(f"{PATH}/{step}", json={"base_revision": 1})
        assert answer.status_code == 409
        assert answer.json()["current"]["revision"] == 2
    assert client.get(PATH).json()["tiers"] == [[d], [a]]


def test_undo_and_redo_walk_through_what_was_done(client: TestClient, workplace: Workplace) -> None:
    a, b, c, d = workplace.ranked
    orders = [[[a], [b], [c], [d]], [[b], [a]], [[c], [b], [a]]]
    save(client, 1, orders[1])
    save(client, 2, orders[2])

    def step(kind: str) -> dict[str, object]:
        base = client.get(PATH).json()["revision"]
        answer = client.post(f"{PATH}/{kind}", json={"base_revision": base})
        assert answer.status_code == 200, answer.text
        ranking: dict[str, object] = answer.json()
        return ranking

    assert step("undo")["tiers"] == orders[1]
    assert step("undo")["tiers"] == orders[0]
    assert step("redo")["tiers"] == orders[1]
    assert step("redo")["tiers"] == orders[2]
    assert not client.get(PATH).json()["can_redo"]
    assert step("undo")["tiers"] == orders[1]
    assert step("undo")["tiers"] == orders[0]
    emptied = step("undo")
    assert emptied["tiers"] == []
    assert not emptied["can_undo"]
    assert client.post(f"{PATH}/undo", json={"base_revision": emptied["revision"]}).status_code == (
        422
    )
    assert step("redo")["tiers"] == orders[0]
    revision = client.get(PATH).json()["revision"]
    assert not save(client, revision, [[d]])["can_redo"], "a new edit ends what could be redone"
    with workplace.database.reading() as session:
        changes = [row.change for row in rankings.history(session, workplace.behaviour_id)]
    assert changes == [
        *["edit", "edit", "edit"],
        *["undo", "undo", "redo", "redo", "undo", "undo", "undo", "redo", "edit"],
    ]


def test_undo_does_not_bring_deleted_recordings_back(
    client: TestClient, workplace: Workplace
) -> None:
    a, b, c, d = workplace.ranked
    save(client, 1, [[d], [c]])
    client.delete(f"/api/recordings/{b}")
    undone = client.post(f"{PATH}/undo", json={"base_revision": 2}).json()
    assert undone["tiers"] == [[a], [c], [d]]


def test_deleting_keeps_undo_and_redo(client: TestClient, workplace: Workplace) -> None:
    a, b, c, d = workplace.ranked
    save(client, 1, [[d], [c], [b]])
    client.delete(f"/api/recordings/{c}")
    ranking = client.get(PATH).json()
    assert ranking["tiers"] == [[d], [b]]
    undone = client.post(f"{PATH}/undo", json={"base_revision": ranking["revision"]}).json()
    assert undone["tiers"] == [[a], [b], [d]]


def test_undo_passes_over_a_deletion_that_was_undone_at_once(
    client: TestClient, workplace: Workplace
) -> None:
    a, b, c, d = workplace.ranked
    save(client, 1, [[d, c], [a], [b]])
    client.delete(f"/api/recordings/{c}")
    client.post(f"/api/recordings/{c}/restore")
    assert client.get(PATH).json()["tiers"] == [[d, c], [a], [b]]
    undone = client.post(f"{PATH}/undo", json={"base_revision": 4}).json()
    assert undone["tiers"] == [[a], [b], [c], [d]]
    assert not client.post(f"{PATH}/redo", json={"base_revision": 5}).json()["can_redo"]
    assert client.get(PATH).json()["tiers"] == [[d, c], [a], [b]]


def test_undo_takes_out_a_recording_that_was_restored_after_the_order_was_changed(
    client: TestClient, workplace: Workplace
) -> None:
    a, b, c, d = workplace.ranked
    client.delete(f"/api/recordings/{c}")
    save(client, 2, [[d], [b], [a]])
    client.post(f"/api/recordings/{c}/restore")
    assert client.get(PATH).json()["tiers"] == [[d], [b], [c], [a]]
    undone = client.post(f"{PATH}/undo", json={"base_revision": 4}).json()
    assert undone["tiers"] == [[d], [b], [a]]
    assert client.post(f"{PATH}/undo", json={"base_revision": 5}).json()["tiers"] == [[a], [b], [d]]


def test_recordings_that_can_not_be_ranked_are_named(
    client: TestClient, workplace: Workplace
) -> None:
    a, b, c, d = workplace.ranked
    client.delete(f"/api/recordings/{a}")
    with workplace.database.writing() as session:
        session.get_one(RecordingRow, b).behaviour_id = 2
        session.get_one(RecordingRow, c).verification = Verification.FAILED
    game = client.post("/api/games", json={"behaviour_id": 1}).json()
    tiers = [[a], [b], [c], [d], [game["recording_id"]], [9999]]
    answer = client.put(PATH, json={"base_revision": 2, "tiers": tiers})
    assert answer.status_code == 422
    detail = answer.json()["detail"]
    assert f"recording {a} has been deleted" in detail
    assert f"recording {b} of Column 2 is of another behaviour" in detail
    assert f"recording {c} is not verified" in detail
    assert "this recording is not kept" in detail
    assert "a recording with the id 9999 does not exist" in detail
    assert f"recording {d}" not in detail


@pytest.mark.parametrize("tiers", [[[]], [[1, 1]], [[1], [1]], [[0]], [["x"]], "x"])
def test_a_malformed_order_is_refused(reader: TestClient, tiers: object) -> None:
    answer = reader.put(PATH, json={"base_revision": 1, "tiers": tiers})
    assert answer.status_code == 422
