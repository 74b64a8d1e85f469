"""A stage whose database goes away: the run is given back and does not fail."""

from __future__ import annotations

import sqlite3
import threading
from dataclasses import replace
from pathlib import Path

import pytest
from sqlalchemy import text

from testsupport.databases import CHOICE
from testsupport.workplace import Workplace, make_workplace
from trainer.progress import Progress
from trainer.runtime.pipeline import GIVEN_BACK, Pipeline
from trainer.runtime.run_data import RunData
from trainer.runtime.stages import STAGE_WORK
from tril.stages import Stage
from tril.store.database import create_database
from tril.store.models import RunStatus


def train(workplace: Workplace, run_id: str) -> str:
    pipeline = Pipeline(workplace.database, workplace.settings, "worker-0", threading.Event())
    return pipeline.train(run_id, pipeline.run_stage)


def test_a_run_goes_on_after_postgresql_was_restarted_in_the_middle_of_a_transaction(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(CHOICE, "postgresql")
    workplace = make_workplace(tmp_path / "data")

    def lose_connection(data: RunData, _progress: Progress) -> None:
        with data.context.database.writing() as session:
            pid = session.scalar(text("SELECT pg_backend_pid()"))
            with workplace.database.reading() as other:
                other.execute(text("SELECT pg_terminate_backend(:pid)"), {"pid": pid})
            session.execute(text("SELECT 1"))

    run_id = workplace.make_run()
    with monkeypatch.context() as patch:
        patch.setitem(STAGE_WORK, Stage.TRAJECTORIES, lose_connection)
        assert train(workplace, run_id) == GIVEN_BACK
    assert workplace.run(run_id).status == RunStatus.QUEUED
    assert train(workplace, run_id) == RunStatus.DONE
    workplace.database.close()


def test_a_run_goes_on_after_another_writer_took_too_long(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(CHOICE, "sqlite")
    workplace = make_workplace(tmp_path / "data")
    impatient = create_database(workplace.settings.application_url, write_patience_s=0.05)
    workplace = replace(workplace, database=impatient)
    other = sqlite3.connect(workplace.settings.data / "tril.sqlite", isolation_level=None)

    def wait_in_vain(data: RunData, _progress: Progress) -> None:
        other.execute("BEGIN IMMEDIATE")
        try:
            with data.context.database.writing() as session:
                session.connection()
        finally:
            other.execute("ROLLBACK")

    run_id = workplace.make_run()
    with monkeypatch.context() as patch:
        patch.setitem(STAGE_WORK, Stage.TRAJECTORIES, wait_in_vain)
        assert train(workplace, run_id) == GIVEN_BACK
    assert workplace.run(run_id).status == RunStatus.QUEUED
    other.close()
    workplace.database.close()
