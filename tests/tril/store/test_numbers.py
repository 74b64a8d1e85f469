"""Numbers of recordings, which name them where people read of them."""

from __future__ import annotations

from itertools import count

import numpy as np
import pytest
from alembic import command
from sqlalchemy import select, text
from sqlalchemy.orm import Session

from testsupport.workplace import Workplace
from tril.demonstrators import play_randomly
from tril.errors import Conflict
from tril.games.space_invaders import SPACE_INVADERS
from tril.recording import Verified
from tril.store import behaviours, recordings
from tril.store.games import Progress, create, end, save
from tril.store.models import RecordingRow, RecordingState, Source
from tril.store.schema import alembic_config, check_schema, upgrade

SEEDS = count()


def played() -> Verified:
    return play_randomly(np.random.default_rng(next(SEEDS)), SPACE_INVADERS.make_console())


def add(session: Session, behaviour_id: int, run_id: str | None = None) -> RecordingRow:
    game = played()
    source = Source.PERSON if run_id is None else Source.POLICY
    return recordings.add(session, behaviour_id, game.recording, game.replay, source, run_id=run_id)


def finish(
    session: Session, behaviour_id: int, state: RecordingState, *, empty: bool = False
) -> int:
    """Play a game of one's own and end it; return its recording."""
    game = played()
    row = create(session, behaviour_id, game.recording.start, None)
    assert row.recording.number is None
    if not empty:
        assert save(session, Progress(row.id, row.epoch, game.recording, game.replay))
    assert end(session, row.id, row.epoch, state, None)
    return row.recording_id


def test_every_behaviour_and_every_run_counts_from_one(workplace: Workplace) -> None:
    run_id = workplace.make_run()
    with workplace.database.writing() as session:
        column_2 = behaviours.by_slug(session, "column-2").id
        own = workplace.behaviour_id
        of_runs = [add(session, own, run_id).number for _ in range(2)]
        assert [add(session, own).number, add(session, column_2).number] == [5, 1]
        assert [add(session, own).number, add(session, column_2).number] == [6, 2]
        assert of_runs == [1, 2]
        assert [recordings.get(session, key).number for key in workplace.ranked] == [1, 2, 3, 4]


def test_a_number_is_given_when_a_game_ends_and_never_twice(workplace: Workplace) -> None:
    own = workplace.behaviour_id
    with workplace.database.writing() as session:
        first = recordings.get(session, finish(session, own, RecordingState.FINISHED))
        left = recordings.get(session, finish(session, own, RecordingState.UNFINISHED))
        empty = recordings.get(session, finish(session, own, RecordingState.UNFINISHED, empty=True))
        assert (first.number, left.number, empty.number) == (5, 6, None)
        recordings.keep(session, first)
        recordings.delete(session, [first, left], None)
        assert add(session, own).number == 7
        recordings.restore(session, [first])
        assert first.number == 5
        recordings.restore(session, [empty])
        assert empty.number == 8


def test_refusals_name_a_recording_by_its_number(workplace: Workplace) -> None:
    run_id = workplace.make_run()
    with workplace.database.writing() as session:
        row = add(session, workplace.behaviour_id, run_id)
        with pytest.raises(Conflict, match=r"^Recording 1 is a result of a training"):
            recordings.delete(session, [row], None)


def test_an_upgrade_numbers_what_is_there_by_id(workplace: Workplace) -> None:
    run_id = workplace.make_run()
    with workplace.database.writing() as session:
        column_2 = behaviours.by_slug(session, "column-2").id
        own = workplace.behaviour_id
        finish(session, own, RecordingState.UNFINISHED, empty=True)
        create(session, own, played().recording.start, None)
        added = [add(session, own), add(session, column_2), add(session, own, run_id)]
        recordings.delete(session, [added[0]], None)
        before = dict(session.execute(select(RecordingRow.id, RecordingRow.number)).all())
    with workplace.database.engine.execution_options(tril_writes=True).begin() as connection:
        config = alembic_config()
        config.attributes["connection"] = connection
        command.downgrade(config, "0019")
        names = connection.execute(text("SELECT * FROM recordings")).keys()
        assert "number" not in names
    upgrade(workplace.database)
    check_schema(workplace.database)
    with workplace.database.reading() as session:
        after = dict(session.execute(select(RecordingRow.id, RecordingRow.number)).all())
    assert after == before
    assert sorted(n for n in after.values() if n is not None) == [1, 1, 1, 2, 3, 4, 5]
