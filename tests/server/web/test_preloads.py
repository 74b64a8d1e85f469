"""A page comes with links to what it needs: code, styles and, for those who may read it, data."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from server.web.pages import Frontend
from tests.server.clients import signed_in
from testsupport.workplace import Workplace

RANK = {
    "path": r"/behaviours/(\d+)/rank",
    "scripts": ["assets/RankPage-abc.js"],
    "styles": ["assets/RankPage-abc.css"],
    "data": ["/api/behaviours/{id}/ranking"],
}
SCRIPT = '<link rel="modulepreload" crossorigin href="/assets/RankPage-abc.js">'
STYLE = '<link rel="preload" as="style" crossorigin href="/assets/RankPage-abc.css">'
DATA = '<link rel="preload" as="fetch" crossorigin href="/api/behaviours/7/ranking">'
PAGE = "<!doctype html><head><title>Tril</title></head>"


@pytest.fixture
def build(tmp_path: Path) -> Path:
    (tmp_path / "index.html").write_text(PAGE)
    (tmp_path / "preloads.json").write_text(json.dumps([RANK]))
    return tmp_path


def test_a_page_links_its_own_code_and_data(workplace: Workplace, build: Path) -> None:
    with signed_in(workplace, build) as client:
        page = client.get("/behaviours/7/rank")
        assert page.headers["cache-control"] == "no-store"
        assert page.text == PAGE.replace("</head>", f"{SCRIPT}{STYLE}{DATA}</head>")
        assert client.get("/preloads.json").status_code == 404


@pytest.mark.parametrize("path", ["/", "/behaviours/x/rank", '/behaviours/7/rank/"><script>'])
def test_other_pages_are_as_they_were_built(build: Path, path: str) -> None:
    frontend = Frontend(build)
    frontend.find("/")
    assert frontend.page(path, with_data=True) == PAGE


def test_participants_get_no_data_links(build: Path) -> None:
    frontend = Frontend(build)
    frontend.find("/")
    page = frontend.page("/behaviours/7/rank", with_data=False)
    assert SCRIPT in page
    assert "/api/" not in page


def test_a_build_without_preloads_is_served_too(build: Path) -> None:
    (build / "preloads.json").unlink()
    frontend = Frontend(build)
    frontend.find("/")
    assert frontend.page("/behaviours/7/rank", with_data=True) == PAGE
