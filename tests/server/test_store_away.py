"""What is answered while the artifact store can't be reached or hangs."""

from __future__ import annotations

import socket
from concurrent.futures import ThreadPoolExecutor

import pytest

from testsupport.live import live_server
from testsupport.ports import free_port
from testsupport.workplace import Workplace
from tril.files import artifact_store
from tril.store.training import artifacts


@pytest.fixture
def s3_elsewhere(monkeypatch: pytest.MonkeyPatch) -> None:
    """Keep the files of runs on S3, with credentials."""
    monkeypatch.setenv("TRIL_ARTIFACTS_URL", "s3://bucket/prefix")
    for name in ("AWS_ACCESS_KEY_ID", "AWS_SECRET_ACCESS_KEY"):
        monkeypatch.setenv(name, "tests")
    monkeypatch.setitem(artifact_store.S3_OPTIONS["client_options"], "timeout", "2s")


def file_of_a_run(workplace: Workplace) -> int:
    run_id = workplace.make_run()
    with workplace.database.writing() as session:
        return artifacts.save(session, run_id, "figure", "x.png", "image/png", 1).id


@pytest.mark.usefixtures("s3_elsewhere")
def test_a_store_that_is_away_is_answered_503(
    workplace: Workplace, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = file_of_a_run(workplace)
    monkeypatch.setenv("AWS_ENDPOINT_URL", f"http://127.0.0.1:{free_port()}")
    with live_server(workplace.settings.data) as live:
        answer = live.http.get(f"/api/artifacts/{file}")
    assert answer.status_code == 503
    assert "artifact store" in answer.json()["detail"]


@pytest.mark.usefixtures("s3_elsewhere")
def test_a_store_that_hangs_holds_up_nothing_else(
    workplace: Workplace, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = file_of_a_run(workplace)
    with socket.create_server(("127.0.0.1", 0)) as silent, ThreadPoolExecutor(8) as asking:
        monkeypatch.setenv("AWS_ENDPOINT_URL", f"http://127.0.0.1:{silent.getsockname()[1]}")
        with live_server(workplace.settings.data) as live:
            hanging = [
                asking.submit(live.http.get, f"/api/artifacts/{file}", timeout=60.0)
                for _ in range(8)
            ]
            with silent.accept()[0]:
                assert live.http.get("/api/behaviours").status_code == 200
                assert not any(answer.done() for answer in hanging)
            assert {answer.result().status_code for answer in hanging} == {503}
