"""Lists come in pages of bounded length, and all pages together are the list."""

from __future__ import annotations

import uuid
from datetime import timedelta
from typing import Any

import pytest
from sqlalchemy import select
from starlette.testclient import TestClient

from server.dependencies import MAX_LISTED
from testsupport.workplace import Workplace
from tril.store import behaviours, players
from tril.store.access import credentials, invitations
from tril.store.models import BehaviourRow, CredentialKind, CredentialRow, PlayerRow, Role, RunRow
from tril.store.training import runs

N_MORE = MAX_LISTED + 5


def fill(workplace: Workplace) -> None:
    """Add more runs, people, browsers, invitations and behaviours than one page has."""
    run = workplace.run(workplace.make_run())
    columns = {column.key: getattr(run, column.key) for column in RunRow.__table__.columns}
    with workplace.database.writing() as session:
        person = {
            column.key: getattr(players.owner(session), column.key)
            for column in PlayerRow.__table__.columns
        }
        for index in range(N_MORE):
            # Several at the same moment: their ids decide.
            begun = run.created_at + timedelta(seconds=index // 4)
            identity = {"id": str(uuid.uuid4()), "created_at": begun}
            session.add(RunRow(**{**columns, **identity}))
            named = {"id": None, "name": f"Person {index}", "role": Role.RESEARCHER}
            row = PlayerRow(**{**person, **named})
            session.add(row)
            session.flush()
            credentials.sign_in(session, row.id, "Test")
            invitations.make(session, f"Class {index}", Role.RESEARCHER, None, None)
            behaviours.create(session, f"Behaviour {index}", "", None)


def paged(client: TestClient, path: str, cursor: str, **query: Any) -> list[dict[str, Any]]:
    """Return a whole list, fetched page by page."""
    entries: list[dict[str, Any]] = []
    while True:
        last = {cursor: entries[-1]["id"]} if entries else {}
        answer = client.get(path, params={**query, **last})
        assert answer.status_code == 200, answer.text
        page = answer.json()
        assert len(page) <= MAX_LISTED
        entries += page
        if len(page) < MAX_LISTED:
            return entries


def test_every_list_comes_in_pages(client: TestClient, workplace: Workplace) -> None:
    fill(workplace)
    with workplace.database.reading() as session:
        wanted: dict[tuple[str, str], list[Any]] = {
            ("/api/runs", "before"): [row.id for row in runs.listing(session)],
            ("/api/behaviours", "after"): [row.id for row in behaviours.listing(session)],
            ("/api/browsers", "before"): [
                row.id for row in credentials.listing(session, CredentialKind.BROWSER)
            ],
            ("/api/invitations", "before"): [row.id for row in invitations.listing(session)],
        }
        let_in = select(CredentialRow.player_id).distinct().order_by(CredentialRow.player_id)
        wanted["/api/people", "after"] = list(session.scalars(let_in))
    for (path, cursor), ids in wanted.items():
        assert len(ids) > MAX_LISTED
        assert [entry["id"] for entry in paged(client, path, cursor)] == ids, path
        assert client.get(path, params={"limit": MAX_LISTED + 1}).status_code == 422
        assert [one["id"] for one in client.get(path, params={"limit": 2}).json()] == ids[:2]


def test_pages_of_runs_keep_their_filters(client: TestClient, workplace: Workplace) -> None:
    made = [workplace.make_run() for _ in range(3)]
    with workplace.database.writing() as session:
        runs.request_cancel(session, made[1])
    newest, oldest = made[2], made[0]
    active = {"active": True, "behaviour_id": 1}
    assert [one["id"] for one in client.get("/api/runs", params=active).json()] == [newest, oldest]
    further = client.get("/api/runs", params={**active, "before": newest})
    assert [one["id"] for one in further.json()] == [oldest]
    assert client.get("/api/runs", params={"before": made[1]}).json()[0]["id"] == oldest


def test_a_page_goes_on_where_its_last_entry_was_deleted(
    client: TestClient, workplace: Workplace
) -> None:
    made = [workplace.make_run() for _ in range(2)]
    with workplace.database.writing() as session:
        runs.request_cancel(session, made[1])
        runs.delete(session, made[1])
        row = behaviours.create(session, "Left", "", None)
        later = behaviours.create(session, "Stays", "", None).id
        behaviours.delete(session, row, None)
        left = row.id
    further = client.get("/api/runs", params={"before": made[1]}).json()
    assert [one["id"] for one in further] == [made[0]]
    further = client.get("/api/behaviours", params={"after": left}).json()
    assert [one["id"] for one in further] == [later]


@pytest.mark.parametrize(
    "address", [f"/api/runs?before={uuid.UUID(int=0)}", "/api/behaviours?after=9999"]
)
def test_a_page_after_what_never_was_is_refused(reader: TestClient, address: str) -> None:
    assert reader.get(address).status_code == 404


def test_built_in_behaviours_come_first_on_every_page(
    client: TestClient, workplace: Workplace
) -> None:
    with workplace.database.reading() as session:
        query = select(BehaviourRow.id).where(BehaviourRow.built_in).order_by(BehaviourRow.id)
        built_in = list(session.scalars(query))
    further = client.get("/api/behaviours", params={"after": built_in[-2]}).json()
    assert [one["id"] for one in further] == built_in[-1:]
