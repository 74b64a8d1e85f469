"""The library over HTTP: behaviours, recordings, import and export, watching."""

from __future__ import annotations

import hashlib
import io
import json

import numpy as np
import pytest
from PIL import Image
from starlette.testclient import TestClient

from server.api.imports import MAX_IMPORTED
from tests.server.clients import replayed, stored
from testsupport.libraries import unranked_in
from testsupport.protocol import FrameDecoder, read_frames_file
from testsupport.workplace import FRAMES, Workplace
from tril.files.cache import sealed
from tril.games.space_invaders.memory import SCREEN_SHAPE
from tril.store import behaviours, rankings
from tril.store.models import RecordingRow, RecordingState, Verification


def test_the_seven_behaviours_come_ready(reader: TestClient) -> None:
    behaviours = reader.get("/api/behaviours").json()
    assert [item["slug"] for item in behaviours] == [
        *(f"column-{n}" for n in range(1, 7)),
        "row-1",
    ]
    first = behaviours[0]
    assert first["n_recordings"] == first["n_ranked"] == 4
    assert first["n_perfect"] == 1
    assert first["has_example"]
    assert first["target"] == [[row, 0] for row in range(6)]
    assert behaviours[6]["ordered"]
    assert (behaviours[1]["n_recordings"], behaviours[1]["has_example"]) == (0, False)


def test_a_person_adds_changes_and_deletes_a_behaviour(client: TestClient) -> None:
    new = {"name": "  Stay on the left  ", "description": "Never cross the middle."}
    made = client.post("/api/behaviours", json=new).json()
    assert (made["name"], made["slug"], made["target"]) == (
        "Stay on the left",
        "stay-on-the-left",
        None,
    )
    path = f"/api/behaviours/{made['id']}"
    changed = client.patch(path, json={"target": [[0, 1], [2, 3]], "ordered": True}).json()
    assert (changed["target"], changed["ordered"]) == ([[0, 1], [2, 3]], True)
    assert client.patch(path, json={"name": "Left"}).json()["target"] == [[0, 1], [2, 3]]
    # An order needs target cells.
    assert client.patch(path, json={"target": None}).status_code == 422
    assert client.patch(path, json={"target": None, "ordered": False}).json()["target"] is None
    assert client.delete(path).status_code == 204
    assert client.get(path).status_code == 404
    assert client.get(f"{path}/recordings").status_code == 404


@pytest.mark.parametrize(
    ("body", "said"),
    [
        ({}, "Name is missing."),
        ({"name": ""}, "Name is too short."),
        ({"name": "a" * 121}, "Name can have at most 120 characters."),
        ({"name": "a", "ordered": "perhaps"}, "Ordered has to be true or false."),
        ({"name": "a", "target": [[0, 256]]}, "Target has to be at most 255."),
        (
            {"name": "a", "target": [[0, 9]]},
            "Expected target aliens in rows 0..5 and columns 0..5, got (0, 9).",
        ),
        ({"name": "a", "colour": "red"}, "Colour is not known here."),
    ],
)
def test_a_refusal_says_in_plain_words_what_is_wrong(
    client: TestClient, body: dict[str, object], said: str
) -> None:
    answer = client.post("/api/behaviours", json=body)
    assert answer.status_code == 422
    assert answer.json()["detail"] == said


def test_two_behaviours_can_not_have_one_name(client: TestClient) -> None:
    made = client.post("/api/behaviours", json={"name": "Left"}).json()
    twice = client.post("/api/behaviours", json={"name": " left "})
    renamed = client.patch(f"/api/behaviours/{made['id']}", json={"name": "Column 1"})
    for answer, name in ((twice, "Left"), (renamed, "Column 1")):
        said = f"There is a behaviour named {name} already. Choose another name."
        assert answer.status_code == 409
        assert answer.json() == {
            "detail": said,
            "errors": [{"where": ["body", "name"], "what": said}],
        }
    own = client.patch(f"/api/behaviours/{made['id']}", json={"name": "LEFT"})
    assert own.json()["name"] == "LEFT"


def test_a_deleted_behaviour_comes_back_with_everything_it_had(
    client: TestClient, workplace: Workplace
) -> None:
    made = client.post("/api/behaviours", json={"name": "Mine"}).json()
    path = f"/api/behaviours/{made['id']}"
    one = workplace.ranked[0]
    borrowed = client.post(f"{path}/ranking/games", json={"recording_ids": [one]})
    assert borrowed.status_code == 201
    game = client.post("/api/games", json={"behaviour_id": made["id"]})
    assert game.status_code == 201
    before = client.get(path).json()
    assert client.delete(path).status_code == 204
    assert client.post(f"{path}/restore").json() == before
    assert unranked_in(client, path) == [one]
    assert client.post("/api/behaviours/999/restore").status_code == 404


def test_a_behaviour_whose_name_was_taken_meanwhile_stays_deleted(client: TestClient) -> None:
    made = client.post("/api/behaviours", json={"name": "Mine"}).json()
    path = f"/api/behaviours/{made['id']}"
    client.delete(path)
    client.post("/api/behaviours", json={"name": "Mine"})
    assert client.post(f"{path}/restore").status_code == 409
    assert client.get(path).status_code == 404


def test_behaviours_are_limited_and_deleted_ones_count(
    client: TestClient, monkeypatch: pytest.MonkeyPatch
) -> None:
    n = len(client.get("/api/behaviours").json())
    monkeypatch.setattr(behaviours, "MAX_BEHAVIOURS", n + 1)
    monkeypatch.setattr(behaviours, "MAX_STORED", n + 2)
    first = client.post("/api/behaviours", json={"name": "First"}).json()["id"]
    refused = client.post("/api/behaviours", json={"name": "Second"})
    assert refused.status_code == 409
    assert refused.json()["detail"] == f"There are {n + 1} behaviours already; delete some first."
    client.delete(f"/api/behaviours/{first}")
    assert client.post("/api/behaviours", json={"name": "Second"}).status_code == 201
    assert client.post(f"/api/behaviours/{first}/restore").status_code == 409
    monkeypatch.setattr(behaviours, "MAX_BEHAVIOURS", n + 10)
    assert client.post(f"/api/behaviours/{first}/restore").status_code == 200
    refused = client.post("/api/behaviours", json={"name": "Third"})
    assert refused.status_code == 409
    assert "deleted ones included" in refused.json()["detail"]


def test_a_target_can_not_change_once_something_was_played(client: TestClient) -> None:
    made = client.post("/api/behaviours", json={"name": "Mine", "target": [[0, 0]]}).json()
    assert client.post("/api/games", json={"behaviour_id": made["id"]}).status_code == 201
    path = f"/api/behaviours/{made['id']}"
    answer = client.patch(path, json={"target": [[1, 1]]})
    assert answer.status_code == 409
    assert "Make a copy with another target" in answer.json()["detail"]
    # What is sent unchanged is no change.
    same = {"name": "Yours", "target": [[0, 0]], "ordered": False}
    assert client.patch(path, json=same).json()["name"] == "Yours"


def test_what_comes_ready_can_not_be_deleted_nor_retargeted(client: TestClient) -> None:
    assert client.delete("/api/behaviours/1").status_code == 409
    assert client.patch("/api/behaviours/1", json={"target": [[0, 0]]}).status_code == 409
    assert client.patch("/api/behaviours/1", json={"description": "x"}).status_code == 200


def test_a_target_can_not_change_once_something_was_trained(
    client: TestClient, workplace: Workplace
) -> None:
    made = client.post("/api/behaviours", json={"name": "Mine", "target": [[0, 0]]}).json()
    run = client.post("/api/runs", json={"behaviour_id": made["id"], "example": True})
    assert run.status_code == 201
    answer = client.patch(f"/api/behaviours/{made['id']}", json={"target": [[1, 1]]})
    assert answer.status_code == 409
    assert "runs judged by it" in answer.json()["detail"]


@pytest.mark.parametrize(
    "body",
    [
        {},
        {"name": ""},
        {"name": "   "},
        {"name": "\u202e\u200b"},
        {"name": "x", "target": []},
        {"name": "x", "target": [[6, 0]]},
        {"name": "x", "target": [[0, 0], [0, 0]]},
        {"name": "x", "ordered": True},
        {"name": "x", "unknown": 1},
        {"name": "x" * 121},
    ],
)
def test_a_senseless_behaviour_is_refused_with_a_reason(
    reader: TestClient, body: dict[str, object]
) -> None:
    answer = reader.post("/api/behaviours", json=body)
    assert answer.status_code == 422
    assert answer.json()["detail"]


def test_a_recording_is_shown_with_its_score(client: TestClient, workplace: Workplace) -> None:
    best = client.get(f"/api/recordings/{workplace.ranked[0]}").json()
    assert (best["n_frames"], best["n_steps"]) == (FRAMES, FRAMES // 4)
    assert best["targets"] == len(best["hits"])
    assert best["hits_per_column"] == [len(best["hits"]), 0, 0, 0, 0, 0]
    assert best["ranked"]
    assert best["perfect"]
    assert best["evaluation_start"] is None
    assert best["verification"] == "verified"


def test_frames_decode_to_the_screens_of_a_replay_and_are_cached_for_ever(
    client: TestClient, workplace: Workplace
) -> None:
    shown = client.get(f"/api/recordings/{workplace.ranked[3]}").json()
    answer = client.get(shown["frames_url"])
    assert "immutable" in answer.headers["cache-control"]
    assert client.get(shown["frames_url"]).content == answer.content
    path, _, _ = shown["frames_url"].partition("?")
    assert client.get(f"{path}?v=other").headers["cache-control"] == "private, no-cache"
    decoder = FrameDecoder(SCREEN_SHAPE)
    decoded = [decoder.decode(frame) for frame in read_frames_file(answer.content)]
    expected = replayed(
        stored(workplace.database, workplace.ranked[3]), lambda console: console.screen()
    )
    assert len(decoded) == FRAMES + 1
    np.testing.assert_array_equal(decoded, np.array(expected))
    keys = [n for n, frame in enumerate(read_frames_file(answer.content)) if frame.is_key]
    assert keys == list(range(0, FRAMES + 1, 60))


def test_a_strip_is_made_once_and_cached_for_ever(client: TestClient, workplace: Workplace) -> None:
    shown = client.get(f"/api/recordings/{workplace.ranked[0]}").json()
    answer = client.get(shown["strip_url"])
    assert answer.headers["content-type"] == "image/webp"
    assert "immutable" in answer.headers["cache-control"]
    with Image.open(io.BytesIO(answer.content)) as strip:
        assert strip.size == (2 * 160, 4 * 210 + 2 * 52)
    (made,) = workplace.settings.cache_folder.glob("*.strip")
    made.write_bytes(sealed(b"as it was made"))
    assert client.get(shown["strip_url"]).content == b"as it was made"


def test_exporting_and_importing_gives_the_same_recordings(client: TestClient) -> None:
    exported = client.get("/api/behaviours/1/recordings/export")
    assert exported.headers["content-type"] == "application/x-ndjson"
    result = client.post(
        "/api/behaviours/2/recordings/import",
        params={"rank": True},
        content=exported.content,
        headers={"Content-Type": "application/x-ndjson"},
    ).json()
    assert len(result["imported"]) == 4
    assert result["refusals"] == []
    tiers = client.get("/api/behaviours/2/ranking").json()["tiers"]
    assert tiers == [[recording_id] for recording_id in result["imported"]]
    for original, copy in zip(
        client.get("/api/behaviours/1/ranking").json()["tiers"], tiers, strict=True
    ):
        first = client.get(f"/api/recordings/{original[0]}/export").json()
        second = client.get(f"/api/recordings/{copy[0]}/export").json()
        assert first == second


def test_an_import_says_which_lines_it_refused_and_why(client: TestClient) -> None:
    good = client.get("/api/behaviours/1/recordings/export").text.splitlines()
    tampered = json.loads(good[0]) | {"taken": [[5, 5]]}
    foreign = json.loads(good[0]) | {"game_version": hashlib.md5(b"another").hexdigest()}
    body = "\n".join([good[1], json.dumps(tampered), "{", json.dumps(foreign), "", good[2]])
    result = client.post("/api/behaviours/3/recordings/import", content=body).json()
    assert len(result["imported"]) == 2
    refused = {refusal["line"]: refusal["reason"] for refusal in result["refusals"]}
    assert set(refused) == {2, 3, 4}
    assert "row 6, column 6" in refused[2]
    assert "another version of Space Invaders" in refused[4]


def test_a_file_that_is_imported_twice_adds_nothing_the_second_time(
    client: TestClient, workplace: Workplace
) -> None:
    body = client.get("/api/behaviours/1/recordings/export").text
    first = client.post("/api/behaviours/3/recordings/import", content=body).json()
    assert (len(first["imported"]), first["already_there"]) == (4, [])
    again = client.post("/api/behaviours/3/recordings/import?rank=true", content=body).json()
    assert (again["imported"], again["already_there"]) == ([], first["imported"])
    assert client.get("/api/behaviours/3/ranking").json()["tiers"] == []
    client.delete(f"/api/recordings/{first['imported'][0]}")
    third = client.post("/api/behaviours/3/recordings/import", content=body).json()
    assert (len(third["imported"]), len(third["already_there"])) == (1, 3)


def test_an_upload_is_bounded_in_number(client: TestClient) -> None:
    body = "{}\n" * (MAX_IMPORTED + 1)
    result = client.post("/api/behaviours/3/recordings/import", content=body).json()
    assert result["imported"] == []
    assert str(MAX_IMPORTED) in result["refusals"][-1]["reason"]


def test_marks_and_notes_can_be_changed(client: TestClient, workplace: Workplace) -> None:
    path = f"/api/recordings/{workplace.ranked[1]}"
    changed = client.patch(path, json={"perfect": True, "notes": "steady"}).json()
    assert (changed["perfect"], changed["notes"]) == (True, "steady")
    assert client.patch(path, json={"perfect": False}).json()["notes"] == "steady"
    with workplace.database.writing() as session:
        row = session.get_one(RecordingRow, workplace.ranked[1])
        row.verification, row.verification_note = Verification.FAILED, "It differs."
    answer = client.patch(path, json={"perfect": True})
    assert answer.status_code == 422
    assert "It differs." in answer.json()["detail"]


def test_deleting_a_ranked_recording_takes_it_out_of_the_ranking_and_restoring_puts_it_back(
    client: TestClient, workplace: Workplace
) -> None:
    gone = workplace.ranked[1]
    before = client.get("/api/behaviours/1/ranking").json()
    assert client.delete(f"/api/recordings/{gone}").status_code == 204
    after = client.get("/api/behaviours/1/ranking").json()
    assert after["tiers"] == [tier for tier in before["tiers"] if tier != [gone]]
    assert after["revision"] == before["revision"] + 1
    with workplace.database.reading() as session:
        *_, kept, deletion = rankings.history(session, workplace.behaviour_id)
    assert deletion.change == "deletion"
    assert kept.tiers == before["tiers"], "every revision stays as it was done"
    listed = client.get("/api/behaviours/1/recordings").json()
    assert gone not in [item["id"] for item in listed]
    listed = client.get("/api/behaviours/1/recordings", params={"include": "deleted"}).json()
    assert [item["deleted"] for item in listed if item["id"] == gone] == [True]
    assert not client.post(f"/api/recordings/{gone}/restore").json()["deleted"]
    restored = client.get("/api/behaviours/1/ranking").json()
    assert restored["tiers"] == before["tiers"]
    assert restored["revision"] == after["revision"] + 1
    assert unranked_in(client, "/api/behaviours/1") == []


def test_a_recording_that_was_unranked_when_it_was_deleted_comes_back_unranked(
    client: TestClient, workplace: Workplace
) -> None:
    gone, *others = workplace.ranked
    ranking, path = "/api/behaviours/1/ranking", f"/api/recordings/{gone}"
    client.delete(path)
    client.post(f"{path}/restore")
    tiers = [[key] for key in others]
    base = client.get(ranking).json()["revision"]
    client.put(ranking, json={"base_revision": base, "tiers": tiers})
    client.delete(path)
    client.post(f"{path}/restore")
    assert client.get(ranking).json()["tiers"] == tiers
    assert unranked_in(client, "/api/behaviours/1") == [gone]


def test_several_are_deleted_in_one_revision_and_brought_back(
    client: TestClient, workplace: Workplace
) -> None:
    path = "/api/behaviours/1/recordings/change"
    gone = list(workplace.ranked[:2])
    before = client.get("/api/behaviours/1/ranking").json()
    assert client.post(path, json={"recording_ids": gone, "change": "delete"}).status_code == 204
    assert [client.get(f"/api/recordings/{key}").json()["deleted"] for key in gone] == [True] * 2
    after = client.get("/api/behaviours/1/ranking").json()
    assert after["tiers"] == [[key] for key in workplace.ranked[2:]]
    assert after["revision"] == before["revision"] + 1
    client.post(path, json={"recording_ids": gone, "change": "restore"})
    listed = client.get("/api/behaviours/1/recordings").json()
    assert {item["id"] for item in listed} == set(workplace.ranked)
    restored = client.get("/api/behaviours/1/ranking").json()
    assert restored["tiers"] == before["tiers"]
    assert restored["revision"] == after["revision"] + 1


def test_what_was_deleted_and_restored_one_by_one_is_ranked_as_before(
    client: TestClient, workplace: Workplace
) -> None:
    before = client.get("/api/behaviours/1/ranking").json()
    _, b, c, _ = workplace.ranked
    for gone in (b, c):
        client.delete(f"/api/recordings/{gone}")
    for gone in (b, c):
        client.post(f"/api/recordings/{gone}/restore")
    restored = client.get("/api/behaviours/1/ranking").json()
    assert restored["tiers"] == before["tiers"]
    # Undo and redo pass over all four.
    assert (restored["can_undo"], restored["can_redo"]) == (
        before["can_undo"],
        before["can_redo"],
    )


def test_what_was_deleted_one_by_one_comes_back_in_the_former_order(
    client: TestClient, workplace: Workplace
) -> None:
    for key in workplace.ranked:
        client.delete(f"/api/recordings/{key}")
    assert client.get("/api/behaviours/1/ranking").json()["tiers"] == []
    client.post(
        "/api/behaviours/1/recordings/change",
        json={"recording_ids": list(workplace.ranked), "change": "restore"},
    )
    tiers = client.get("/api/behaviours/1/ranking").json()["tiers"]
    assert tiers == [[key] for key in workplace.ranked]


def test_several_are_marked_all_or_none(client: TestClient, workplace: Workplace) -> None:
    path = "/api/behaviours/1/recordings/change"
    with workplace.database.writing() as session:
        row = session.get_one(RecordingRow, workplace.ranked[3])
        row.verification = Verification.FAILED

    def perfect() -> set[int]:
        listed = client.get("/api/behaviours/1/recordings").json()
        return {item["id"] for item in listed if item["perfect"]}

    best, second, third, failed = workplace.ranked
    everything = {"recording_ids": [second, third, failed], "change": "mark_perfect"}
    assert client.post(path, json=everything).status_code == 422
    assert perfect() == {best}
    client.post(path, json={"recording_ids": [second, third], "change": "mark_perfect"})
    assert perfect() == {best, second, third}
    client.post(path, json={"recording_ids": [best, third], "change": "unmark_perfect"})
    assert perfect() == {second}


def test_only_recordings_of_the_behaviour_are_changed_or_exported(
    client: TestClient, workplace: Workplace
) -> None:
    both = {"recording_ids": [workplace.ranked[0], 99999], "change": "delete"}
    answer = client.post("/api/behaviours/1/recordings/change", json=both)
    assert answer.status_code == 404
    assert "99999" in answer.json()["detail"]
    both["recording_ids"] = [workplace.ranked[0]]
    assert client.post("/api/behaviours/2/recordings/change", json=both).status_code == 404
    assert len(client.get("/api/behaviours/1/recordings").json()) == 4
    chosen = {"recording": [workplace.ranked[2], workplace.ranked[0]]}
    exported = client.get("/api/behaviours/1/recordings/export", params=chosen)
    assert [json.loads(line)["tier"] for line in exported.text.splitlines()] == [1, 3]
    assert client.get("/api/behaviours/2/recordings/export", params=chosen).status_code == 404
    same = client.post(
        "/api/behaviours/1/recordings/export", json={"recording_ids": chosen["recording"]}
    )
    assert same.text == exported.text


def test_a_game_that_is_played_can_not_be_kept_or_deleted(
    client: TestClient, workplace: Workplace
) -> None:
    game = client.post("/api/games", json={"behaviour_id": 1}).json()
    path = f"/api/recordings/{game['recording_id']}"
    for answer in (client.post(f"{path}/keep"), client.delete(path)):
        assert answer.status_code == 409
        assert "still being played" in answer.json()["detail"]
    with workplace.database.writing() as session:
        session.get_one(RecordingRow, game["recording_id"]).state = RecordingState.FINISHED
    assert client.post(f"{path}/discard").json()["deleted"]
    assert client.post(f"{path}/restore").json()["state"] == "kept"


def test_a_policys_game_can_not_be_marked_as_perfect(
    client: TestClient, workplace: Workplace
) -> None:
    run = client.post("/api/runs", json={"behaviour_id": 1, "go_on_anyway": True}).json()
    with workplace.database.writing() as session:
        session.get_one(RecordingRow, workplace.ranked[3]).run_id = run["id"]
    answer = client.patch(f"/api/recordings/{workplace.ranked[3]}", json={"perfect": True})
    assert answer.status_code == 409
    assert "only the behaviour's own games" in answer.json()["detail"]


def test_a_game_that_nobody_decided_about_is_listed_but_not_counted(
    client: TestClient, workplace: Workplace
) -> None:
    game = client.post("/api/games", json={"behaviour_id": 1}).json()["recording_id"]

    def listed() -> dict[int, str]:
        found = client.get("/api/behaviours/1/recordings").json()
        return {one["id"]: one["state"] for one in found}

    def counted() -> int:
        return int(client.get("/api/behaviours/1").json()["n_recordings"])

    def set_state(state: RecordingState) -> None:
        with workplace.database.writing() as session:
            row = session.get_one(RecordingRow, game)
            row.state, row.verification = state, Verification.VERIFIED

    assert game not in listed()
    for state in (RecordingState.FINISHED, RecordingState.UNFINISHED):
        set_state(state)
        assert listed()[game] == state
        assert counted() == 4
    client.post(f"/api/recordings/{game}/keep")
    assert counted() == 5


def test_a_recording_that_does_not_replay_is_not_counted(
    client: TestClient, workplace: Workplace
) -> None:
    with workplace.database.writing() as session:
        session.get_one(RecordingRow, workplace.ranked[3]).verification = Verification.FAILED
    assert client.get("/api/behaviours/1").json()["n_recordings"] == 3
    assert len(client.get("/api/behaviours/1/recordings").json()) == 4


def test_games_of_people_never_begin_at_an_evaluation_start(client: TestClient) -> None:
    starts = set()
    for _ in range(40):
        game = client.post("/api/games", json={"behaviour_id": 1}).json()
        shown = client.get(f"/api/recordings/{game['recording_id']}").json()
        assert shown["evaluation_start"] is None
        starts.add(shown["start"]["idle_frames"])
    assert len(starts) > 10
    chosen = client.post(
        "/api/games", json={"behaviour_id": 1, "start": {"idle_frames": 11}}
    ).json()
    shown = client.get(f"/api/recordings/{chosen['recording_id']}").json()
    assert shown["evaluation_start"] == 0


@pytest.mark.parametrize(
    "path",
    [
        "/api/recordings/99999",
        "/api/recordings/99999/frames",
        "/api/recordings/99999/strip.webp",
        "/api/behaviours/99999",
        "/api/artifacts/99999",
        "/api/games/9c5b94b1-35ad-49bb-b118-8e8fc24abf80",
        "/api/runs/9c5b94b1-35ad-49bb-b118-8e8fc24abf80",
        "/api/runs/9c5b94b1-35ad-49bb-b118-8e8fc24abf80/metrics",
        "/api/runs/9c5b94b1-35ad-49bb-b118-8e8fc24abf80/results",
        "/api/runs/9c5b94b1-35ad-49bb-b118-8e8fc24abf80/reward/1",
        "/api/nothing",
    ],
)
def test_what_is_not_there_answers_404_with_a_problem(reader: TestClient, path: str) -> None:
    answer = reader.get(path)
    assert answer.status_code == 404
    assert answer.json()["detail"]


@pytest.mark.parametrize("declared", ["9" * 5_000, "-1", "1e3", "٣", " 5 5"])
def test_a_length_that_is_no_number_of_bytes_is_refused(client: TestClient, declared: str) -> None:
    answer = client.post(
        "/api/behaviours/3/recordings/import",
        content=b"{}",
        headers={b"Content-Length": declared.encode()},
    )
    assert answer.status_code == 413
    assert "too large" in answer.json()["detail"]


def test_a_foreign_file_is_one_refusal_and_one_of_many_lines_is_counted(
    client: TestClient,
) -> None:
    path = "/api/behaviours/3/recordings/import"
    result = client.post(path, content=b"PK\x03\x04" + bytes(10_000)).json()
    assert [one["reason"][:22] for one in result["refusals"]] == ["The file is a zip file"]
    result = client.post(path, content=b'{"action": 3}\n' * 199).json()
    assert (result["n_refused"], len(result["refusals"])) == (199, 20)
