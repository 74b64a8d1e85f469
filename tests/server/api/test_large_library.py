"""A library of thousands: what is answered is bounded, and only what changed is told again."""

from __future__ import annotations

import json
from typing import Any

import pytest
from sqlalchemy import func, insert, select
from starlette.testclient import TestClient

from server.change_stream import MOST_RECORDINGS, _coalesced
from testsupport.libraries import rows_of
from testsupport.workplace import Workplace
from tril.exchange.recording_transfer import export_recordings
from tril.store import library, recordings
from tril.store.changes import MAX_NOTED_ONE_BY_ONE
from tril.store.models import AuditRow, ChangeRow, RecordingRow

LIBRARY = "/api/behaviours/1/library"
MANY = 700


def add_copies(workplace: Workplace, number: int = MANY) -> list[int]:
    """Add copies of a recording; return their ids."""
    with workplace.database.writing() as session:
        row = recordings.get(session, workplace.ranked[0])
        columns = [one.key for one in RecordingRow.__table__.columns if one.key != "id"]
        values = {name: getattr(row, name) for name in columns} | {"perfect": False}
        session.execute(insert(RecordingRow), [values] * number)
        newest = session.scalar(select(func.max(RecordingRow.id))) or 0
    return list(range(newest - number + 1, newest + 1))


def changes_since(client: TestClient, cursor: int) -> dict[str, Any]:
    answer = client.get(LIBRARY, params={"since": cursor})
    assert answer.status_code == 200, answer.text
    changes: dict[str, Any] = answer.json()
    return changes


def test_a_library_in_brief_says_what_its_recordings_say(
    client: TestClient, workplace: Workplace
) -> None:
    listed = client.get("/api/behaviours/1/recordings").json()
    brief = client.get(LIBRARY).json()
    assert (brief["whole"], brief["removed"]) == (True, [])
    assert brief["ranked"] == list(workplace.ranked)
    rows = rows_of(brief)
    assert [row["id"] for row in rows] == [one["id"] for one in listed]
    for row, one in zip(rows, listed, strict=True):
        assert row["n_hits"] == len(one["hits"])
        # Only a borrowed one's behaviour is said.
        assert row.pop("behaviour_name") is None
        assert {key: row[key] for key in row.keys() & one.keys()} == {
            key: one[key] for key in row.keys() & one.keys()
        }


def test_one_recording_that_changes_is_told_alone(client: TestClient, workplace: Workplace) -> None:
    many = add_copies(workplace)
    whole = client.get(LIBRARY)
    cursor = whole.json()["cursor"]
    assert len(whole.json()["recordings"]["id"]) == MANY + 4

    nothing = changes_since(client, cursor)
    assert (nothing["whole"], nothing["removed"], nothing["recordings"]["id"]) == (False, [], [])

    client.patch(f"/api/recordings/{many[5]}", json={"perfect": True})
    marked = changes_since(client, cursor)
    assert [(row["id"], row["perfect"]) for row in rows_of(marked)] == [(many[5], True)]
    assert len(json.dumps(marked)) < len(whole.content) / 50

    client.delete(f"/api/recordings/{many[5]}")
    gone = changes_since(client, marked["cursor"])
    assert (gone["removed"], gone["recordings"]["id"]) == ([many[5]], [])
    # Whoever lists deleted ones, too, is told that it was deleted.
    with_deleted = client.get(LIBRARY, params={"since": marked["cursor"], "deleted": True}).json()
    assert [(row["id"], row["deleted"]) for row in rows_of(with_deleted)] == [(many[5], True)]

    client.post(f"/api/recordings/{many[5]}/restore")
    assert changes_since(client, gone["cursor"])["recordings"]["id"] == [many[5]]


def test_a_library_comes_in_parts_the_newest_first(
    client: TestClient, workplace: Workplace
) -> None:
    add_copies(workplace)
    whole = client.get(LIBRARY).json()
    rows = rows_of(whole)
    ids = [row["id"] for row in rows]
    parts = [client.get(LIBRARY, params={"limit": 200}).json()]
    while len(parts[-1]["recordings"]["id"]) > 0:
        before = parts[-1]["recordings"]["id"][-1]
        parts.append(client.get(LIBRARY, params={"limit": 300, "before": before}).json())
    assert [len(part["recordings"]["id"]) for part in parts] == [200, 300, MANY + 4 - 500, 0]
    assert [row for part in parts for row in rows_of(part)] == rows
    assert not any(part["whole"] for part in parts)
    assert {tuple(part["ranked"]) for part in parts} == {workplace.ranked}
    all_at_once = client.get(LIBRARY, params={"limit": len(ids) + 1}).json()
    assert (all_at_once["whole"], rows_of(all_at_once)) == (True, rows)
    assert client.get(LIBRARY, params={"limit": 0}).status_code == 422
    # What changed is told in full.
    cursor = {"since": whole["cursor"], "limit": 1}
    for key in ids[:2]:
        client.patch(f"/api/recordings/{key}", json={"perfect": True})
    assert client.get(LIBRARY, params=cursor).json()["recordings"]["id"] == ids[:2]


@pytest.mark.parametrize("cursor", [-1, 1])
def test_the_whole_library_is_told_where_changes_are_not_known(
    client: TestClient, workplace: Workplace, cursor: int
) -> None:
    newest = client.get(LIBRARY).json()["cursor"]
    with workplace.database.writing() as session:
        # As if an hour had passed, or the database were an older copy.
        for row in session.scalars(select(ChangeRow).where(ChangeRow.id < newest)):
            session.delete(row)
    asked = newest + 1 if cursor == -1 else max(0, newest - 2)
    assert changes_since(client, asked)["whole"]
    assert not changes_since(client, newest)["whole"]


def test_thousands_are_changed_at_once_and_noted_as_one_change(
    client: TestClient, workplace: Workplace
) -> None:
    many = add_copies(workplace)
    cursor = client.get(LIBRARY).json()["cursor"]
    path = "/api/behaviours/1/recordings/change"
    for change in ("mark_perfect", "delete", "restore"):
        answer = client.post(path, json={"recording_ids": many, "change": change})
        assert answer.status_code == 204, answer.text
    with workplace.database.reading() as session:
        noted = session.execute(
            select(ChangeRow.topic, ChangeRow.key).where(ChangeRow.id > cursor)
        ).all()
        assert set(noted) == {("library", "1")}
        n_logged = session.scalar(
            select(func.count()).select_from(AuditRow).where(AuditRow.action == "deleted")
        )
    assert n_logged == MANY
    changed = changes_since(client, cursor)
    assert changed["whole"]
    assert sum(changed["recordings"]["perfect"]) == MANY + 1


def test_no_list_of_recordings_is_longer_than_a_page(
    client: TestClient, workplace: Workplace
) -> None:
    add_copies(workplace)
    listed: list[int] = []
    before: int | None = None
    while True:
        page = client.get(
            "/api/behaviours/1/recordings", params={} if before is None else {"before": before}
        ).json()
        assert len(page) <= 200
        if not page:
            break
        listed += [one["id"] for one in page]
        before = listed[-1]
    assert listed == sorted(listed, reverse=True)
    assert len(set(listed)) == len(listed) == MANY + 4


def test_recordings_are_shown_by_their_numbers_deleted_ones_too(
    client: TestClient, workplace: Workplace
) -> None:
    first, second, *_ = workplace.ranked
    client.delete(f"/api/recordings/{second}")
    lent = client.post("/api/behaviours/2/ranking/games", json={"recording_ids": [first]})
    assert lent.status_code == 201

    def shown(behaviour: int, ids: list[int]) -> list[tuple[int, bool, bool]]:
        path = f"/api/behaviours/{behaviour}/library/recordings"
        answer = client.get(path, params={"recording": ids}).json()
        return [(one["id"], one["borrowed"], one["deleted"]) for one in answer]

    assert shown(1, [first, second, 99999]) == [(second, False, True), (first, False, False)]
    assert shown(2, [first, second]) == [(first, True, False)]
    too_many = {"recording": list(range(1, 102))}
    assert client.get(f"{LIBRARY}/recordings", params=too_many).status_code == 422


def test_an_export_holds_few_recordings_in_memory(client: TestClient, workplace: Workplace) -> None:
    many = add_copies(workplace)
    exported = client.get("/api/behaviours/1/recordings/export").text.splitlines()
    assert len(exported) == MANY + 4
    chosen = client.post("/api/behaviours/1/recordings/export", json={"recording_ids": many})
    assert len(chosen.text.splitlines()) == MANY
    most = 0
    with workplace.database.reading() as session:
        for _ in export_recordings(session, 1):
            most = max(most, len(session.identity_map))
    assert most <= recordings.ROWS_IN_MEMORY + 4


def test_a_page_is_told_of_many_recordings_as_one_library() -> None:
    few = [("recording", str(key)) for key in range(MOST_RECORDINGS)]
    assert list(_coalesced(few)) == few
    many = [*few, ("ranking", "1"), ("recording", "777")]
    assert list(_coalesced(many)) == [("ranking", "1"), ("library", "")]
    assert MAX_NOTED_ONE_BY_ONE <= library.MAX_CHANGED
