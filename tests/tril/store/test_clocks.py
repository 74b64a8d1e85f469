"""Machines whose clocks are wrong don't take each other's work."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from datetime import datetime, timedelta, tzinfo

import pytest

from testsupport.workplace import Workplace
from tril.games.atari.starts import AtariStart
from tril.store import games, models, processes, recordings
from tril.store.changes import ChangeReader, note_change, prune
from tril.store.models import RecordingState, RunStatus
from tril.store.training import leases, runs

DAY = timedelta(days=1)


@contextmanager
def clock_off_by(error: timedelta) -> Iterator[None]:
    class WrongClock(datetime):
        @classmethod
        def now(cls, tz: tzinfo | None = None) -> datetime:  # type: ignore[override]
            return datetime.now(tz) + error

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(models, "datetime", WrongClock)
        yield


@pytest.fixture(params=[DAY, -DAY], ids=["ahead", "behind"])
def error(request: pytest.FixtureRequest) -> timedelta:
    found: timedelta = request.param
    return found


def test_a_worker_keeps_its_run(workplace: Workplace, error: timedelta) -> None:
    with clock_off_by(error):
        run_id = workplace.make_run()
        with workplace.database.writing() as session:
            processes.beat(session, "worker-0", "worker", {})
        workplace.lease(run_id)
    with workplace.database.writing() as session:
        assert runs.has_worker(session, runs.get(session, run_id))
        assert processes.is_kind_alive(session, "worker")
        assert leases.acquire(session, run_id, "worker-1") is None


def test_the_run_that_was_made_first_is_first(workplace: Workplace, error: timedelta) -> None:
    first = workplace.make_run()
    with clock_off_by(error):
        second = workplace.make_run()
    third = workplace.make_run()
    with workplace.database.reading() as session:
        assert [row.id for row in runs.unfinished(session)] == [first, second, third]


def test_a_run_does_not_end_before_it_began(workplace: Workplace, error: timedelta) -> None:
    run_id = workplace.make_run()
    with clock_off_by(error):
        lease = workplace.lease(run_id)
    with workplace.database.writing() as session:
        leases.end(session, lease, RunStatus.DONE)
    row = workplace.run(run_id)
    assert row.started_at is not None
    assert row.finished_at is not None
    assert timedelta(0) <= row.finished_at - row.started_at < timedelta(minutes=5)
    assert row.created_at <= row.started_at


def test_a_game_is_neither_taken_over_nor_decided_too_early_or_never(
    workplace: Workplace, error: timedelta
) -> None:
    with workplace.database.writing() as session:
        with clock_off_by(error):
            row = games.create(session, workplace.behaviour_id, AtariStart(4), None)
            games.acquire(session, row.id, "server-0", "tab")
        assert games.is_open(session, row.id)
        assert games.abandoned(session, timedelta(0)) == []
        assert games.acquire_abandoned(session, row.id, "server-1", timedelta(0)) is None
        with clock_off_by(error):
            row.recording.n_frames = 1
            assert games.end(session, row.id, row.epoch, RecordingState.FINISHED, None)
        games.keep_undecided(session, timedelta(hours=1))
        recording = recordings.get(session, row.recording_id)
        assert recording.state == RecordingState.FINISHED
        games.keep_undecided(session, -timedelta(minutes=1))
        assert recording.state == RecordingState.KEPT


def test_changes_are_there_until_they_are_old(workplace: Workplace, error: timedelta) -> None:
    with workplace.database.reading() as session:
        reader = ChangeReader(session)
    with clock_off_by(error), workplace.database.writing() as session:
        note_change(session, "run", "a")
        note_change(session, "run", "b")
    with workplace.database.writing() as session:
        prune(session)
    with clock_off_by(error), workplace.database.writing() as session:
        prune(session)
    with workplace.database.reading() as session:
        assert [row.key for row in reader.read(session)] == ["a", "b"]
