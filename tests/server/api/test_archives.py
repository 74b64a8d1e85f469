"""A run as a zip over HTTP, and the finished example."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path

import pytest
from sqlalchemy import select
from starlette.testclient import TestClient

from server.archives import ArchiveMaker
from testsupport.finished_runs import make_finished_run
from testsupport.workplace import Workplace, make_workplace
from trainer.archive.run_archive import write_archive
from tril.analysis.blind import BlindAnswer
from tril.errors import Unavailable
from tril.exchange import example
from tril.files.artifact_store import ArtifactStore
from tril.files.cache import Cache, sealed
from tril.store import behaviours
from tril.store.models import BlindAnswerRow, RecordingRow
from tril.store.training import runs


def test_a_finished_run_is_downloaded_as_one_zip_which_is_made_once(
    client: TestClient, workplace: Workplace
) -> None:
    run_id = make_finished_run(workplace)
    answer = client.get(f"/api/runs/{run_id}/archive.zip")
    assert answer.status_code == 200, answer.text
    assert answer.headers["content-type"] == "application/zip"
    assert f'filename="tril-column-1-{run_id[:8]}.zip"' in answer.headers["content-disposition"]
    with zipfile.ZipFile(io.BytesIO(answer.content)) as archive:
        assert archive.testzip() is None
        assert {"report.html", "load_policy.py", "policy/imitator.zip"} <= set(archive.namelist())
        assert archive.read("report.html").count(b"data:image/webp;base64,") == 2
    (kept,) = workplace.settings.cache_folder.glob("*.run.zip")
    kept.write_bytes(sealed(b"kept"))
    assert client.get(f"/api/runs/{run_id}/archive.zip").content == b"kept"
    with workplace.database.writing() as session:
        game, other = session.scalars(select(RecordingRow.id).limit(2))
        session.add(
            BlindAnswerRow(
                run_id=run_id,
                round=1,
                pair=1,
                imitator_id=game,
                other_id=other,
                imitator_left=True,
                answer=BlindAnswer.LEFT,
            )
        )
    # It has the answers of blind comparisons.
    assert client.get(f"/api/runs/{run_id}/archive.zip").content != b"kept"


def test_a_finished_run_is_downloaded_as_a_page_with_its_poster(
    client: TestClient, workplace: Workplace
) -> None:
    run_id = make_finished_run(workplace)
    page = client.get(f"/api/runs/{run_id}/page.html")
    assert page.status_code == 200, page.text
    assert page.headers["content-type"] == "text/html; charset=utf-8"
    # Shown in place it would be a page of this site.
    named = f'attachment; filename="tril-column-1-{run_id[:8]}.html"'
    assert page.headers["content-disposition"] == named
    assert "Shoot all six aliens of the leftmost column" in page.text
    (kept,) = workplace.settings.cache_folder.glob("*.page.zip")
    # Both were made at once and are kept.
    pages = io.BytesIO()
    with zipfile.ZipFile(pages, "w") as archive:
        archive.writestr("png", b"kept")
    kept.write_bytes(sealed(pages.getvalue()))
    poster = client.get(f"/api/runs/{run_id}/page.png")
    assert (poster.content, poster.headers["content-type"]) == (b"kept", "image/png")
    assert client.get(f"/api/runs/{run_id}/page.zip").status_code == 422


def test_only_a_finished_run_that_is_there_is_downloaded(
    client: TestClient, workplace: Workplace
) -> None:
    unfinished = client.get(f"/api/runs/{workplace.make_run()}/archive.zip")
    assert unfinished.status_code == 409
    assert "It can be taken away once it is done" in unfinished.json()["detail"]
    assert client.get(f"/api/runs/{workplace.make_run()}/page.html").status_code == 409
    nothing = client.get("/api/runs/00000000-0000-0000-0000-000000000000/archive.zip")
    assert nothing.status_code == 404
    assert client.get("/api/runs/7/archive.zip").status_code == 422


def test_an_archive_that_takes_too_long_or_fails_is_given_up(
    workplace: Workplace, tmp_path: Path
) -> None:
    cache = Cache(tmp_path / "cache", 2**20)
    with workplace.database.reading() as session:
        run = runs.get(session, workplace.make_run())
        behaviour = behaviours.get(session, run.behaviour_id)
    with pytest.raises(Unavailable, match="Making the archive took too long"):
        ArchiveMaker(workplace.settings, cache, timeout_s=0.01).archive(run, behaviour, 0)
    # The route asks for finished runs only.
    with pytest.raises(Unavailable, match="The archive could not be made"):
        ArchiveMaker(workplace.settings, cache).archive(run, behaviour, 0)


@pytest.fixture
def shipped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """Let a run that was finished elsewhere ship; return its id."""
    there = make_workplace(tmp_path / "there")
    run_id = make_finished_run(there)
    path = tmp_path / "example.zip"
    store = ArtifactStore(there.settings.artifact_root)
    write_archive(there.database, store, run_id, path, lambda _: b"", compact=True)
    there.database.close()
    monkeypatch.setattr(example, "EXAMPLE", path)
    return run_id


def test_the_example_opens_with_all_results_and_only_once(
    client: TestClient, shipped: str, workplace: Workplace
) -> None:
    assert client.get("/api/system").json()["has_example"]
    run = client.post("/api/example").json()
    assert (run["id"], run["status"], run["imported"]) == (shipped, "done", True)
    assert run["behaviour_name"] == example.BEHAVIOUR_NAME
    results = client.get(f"/api/runs/{shipped}/results").json()
    assert results["verdict"]["sentence"]
    assert len(results["games"]) == 6
    assert len(results["attention"]) == 4
    assert len(results["percentiles"]) == 101
    picture = client.get(results["attention"][0]["map_url"])
    assert (picture.status_code, picture.headers["content-type"]) == (200, "image/png")
    metrics = client.get(f"/api/runs/{shipped}/metrics").json()
    assert metrics["series"]["imitator"]["hits"] == [[128, 1.28], [256, 2.56]]
    recording = results["games"][0]["recording"]
    assert client.get(recording["frames_url"]).status_code == 200
    assert client.post("/api/example").json() == run
    assert len(client.get("/api/runs").json()) == 1


def test_a_deleted_example_comes_back(client: TestClient, shipped: str) -> None:
    run = client.post("/api/example").json()
    assert client.delete(f"/api/runs/{shipped}").status_code == 204
    assert client.delete(f"/api/behaviours/{run['behaviour_id']}").status_code == 204
    assert client.post("/api/example").json() == run
    assert client.get(f"/api/behaviours/{run['behaviour_id']}").json()["n_runs"] == 1


def test_without_an_example_there_is_nothing_to_open(
    client: TestClient, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(example, "EXAMPLE", tmp_path / "nothing.zip")
    assert not client.get("/api/system").json()["has_example"]
    answer = client.post("/api/example")
    assert answer.status_code == 404
    assert "No finished example" in answer.json()["detail"]
