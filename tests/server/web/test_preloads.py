"""A page comes with links to what it needs: code, styles and, for those who may read it, data."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.server.clients import signed_in
from testsupport.visitors import cookie_of
from testsupport.workplace import Workplace
from tril.store import players
from tril.store.models import Role

RANK = {
    "path": "/behaviours/([0-9]+)/rank",
    "shows": "behaviour",
    "scripts": ["assets/RankPage-abc.js"],
    "styles": ["assets/RankPage-abc.css"],
    "data": ["/api/behaviours/{behaviour}/ranking", "/api/catalogue/games/{game}"],
}
RUN = RANK | {"path": "/runs/([0-9a-f-]{36})", "shows": "run", "data": ["/api/runs/{run}"]}
RECORDING = RANK | {
    "path": "/recordings/([0-9]+)",
    "shows": "recording",
    "data": ["/api/recordings/{recording}", "/api/behaviours/{behaviour}"],
}
SCRIPT = '<link rel="modulepreload" crossorigin href="/assets/RankPage-abc.js">'
STYLE = '<link rel="preload" as="style" crossorigin href="/assets/RankPage-abc.css">'
PAGE = "<!doctype html><head><title>Tril</title></head>"


@pytest.fixture
def build(tmp_path: Path) -> Path:
    (tmp_path / "index.html").write_text(PAGE)
    (tmp_path / "preloads.json").write_text(json.dumps([RANK, RUN, RECORDING]))
    return tmp_path


def page_with(*data: str) -> str:
    links = [f'<link rel="preload" as="fetch" crossorigin href="{path}">' for path in data]
    return PAGE.replace("</head>", "".join([SCRIPT, STYLE, *links, "</head>"]))


def test_a_page_links_its_own_code_and_data(workplace: Workplace, build: Path) -> None:
    with signed_in(workplace, build) as client:
        page = client.get("/behaviours/1/rank")
        assert page.headers["cache-control"] == "no-store"
        assert page.text == page_with(
            "/api/behaviours/1/ranking", "/api/catalogue/games/space_invaders"
        )
        assert client.get("/preloads.json").status_code == 404


def test_a_page_links_the_behaviour_of_what_it_shows(workplace: Workplace, build: Path) -> None:
    shown = workplace.ranked[0]
    with signed_in(workplace, build) as client:
        assert client.get(f"/recordings/{shown}").text == page_with(
            f"/api/recordings/{shown}", f"/api/behaviours/{workplace.behaviour_id}"
        )


def test_data_that_nothing_is_known_of_are_not_linked(workplace: Workplace, build: Path) -> None:
    nobody = "11111111-2222-4333-8444-555555555555"
    with signed_in(workplace, build) as client:
        assert client.get("/recordings/999").text == page_with("/api/recordings/999")
        assert client.get(f"/runs/{nobody}").text == page_with(f"/api/runs/{nobody}")
        many = "9" * 5000
        assert client.get(f"/behaviours/{many}/rank").text == page_with(
            f"/api/behaviours/{many}/ranking"
        )


def test_participants_get_no_data_links(workplace: Workplace, build: Path) -> None:
    with workplace.database.writing() as session:
        participant = players.add(session, "Ada", Role.PARTICIPANT).id
    with signed_in(workplace, build) as client:
        client.cookies.clear()
        client.cookies.set(*cookie_of(workplace.settings, participant))
        assert client.get("/behaviours/1/rank").text == page_with()


@pytest.mark.parametrize("path", ["/", "/behaviours/x/rank", '/behaviours/7/rank/"><script>'])
def test_other_pages_are_as_they_were_built(workplace: Workplace, build: Path, path: str) -> None:
    with signed_in(workplace, build) as client:
        assert client.get(path).text == PAGE


def test_a_build_without_preloads_is_served_too(workplace: Workplace, build: Path) -> None:
    (build / "preloads.json").unlink()
    with signed_in(workplace, build) as client:
        assert client.get("/behaviours/1/rank").text == PAGE
