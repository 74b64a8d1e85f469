"""Stored values of measures: what is missing, and what an edit of a behaviour leaves."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from testsupport.workplace import Workplace, make_workplace
from tril.errors import Invalid
from tril.games.measures import Counted, GameScore, InRegion, Length, Measure
from tril.games.measuring import measured_before
from tril.games.settings import Rectangle
from tril.store import behaviours, borrowed, measured, recordings
from tril.store.models import Verification

LENGTH, SCORE = Length(at_least=3), GameScore(at_least=10)


@pytest.fixture
def workplace(tmp_path: Path) -> Iterator[Workplace]:
    made = make_workplace(tmp_path / "data")
    yield made
    made.database.close()


def measure_by(workplace: Workplace, slug: str, *measures: Measure) -> None:
    with workplace.database.writing() as session:
        row = behaviours.by_slug(session, slug)
        behaviours.update(
            session,
            row,
            row.name,
            row.description,
            behaviours.as_behaviour(row).target,
            row.ordered,
            measures=measures,
        )


def missing(workplace: Workplace) -> dict[int, tuple[Measure, ...]]:
    with workplace.database.reading() as session:
        return measured.unmeasured(session)


def test_nothing_is_missing_where_nothing_is_asked_for(workplace: Workplace) -> None:
    assert missing(workplace) == {}


def test_measures_of_a_built_in_behaviour_with_recordings_can_change(workplace: Workplace) -> None:
    measure_by(workplace, "column-1", LENGTH, SCORE)
    assert missing(workplace) == dict.fromkeys(workplace.ranked, (LENGTH, SCORE))
    with workplace.database.reading() as session:
        behaviour = behaviours.as_behaviour(behaviours.by_slug(session, "column-1"))
    assert behaviour.measures == (LENGTH, SCORE)


def test_a_stored_value_holds_for_any_bound_and_other_measures_are_missing(
    workplace: Workplace,
) -> None:
    measure_by(workplace, "column-1", LENGTH)
    with workplace.database.writing() as session:
        measured.store(session, {key: {LENGTH.key: 4.0} for key in workplace.ranked})
    assert missing(workplace) == {}
    longer = Length(at_least=5)
    measure_by(workplace, "column-1", longer, SCORE)
    assert missing(workplace) == dict.fromkeys(workplace.ranked, (SCORE,))
    with workplace.database.writing() as session:
        measured.store(session, {workplace.ranked[0]: {SCORE.key: None}})
        values = recordings.get(session, workplace.ranked[0]).measured
    found = measured_before([longer, SCORE], values)
    assert [(one.value, one.met, one.is_known) for one in found] == [
        (4.0, False, True),
        (None, None, True),
    ]


def test_a_borrowed_game_is_measured_by_what_the_borrower_asks_for_too(
    workplace: Workplace,
) -> None:
    first = workplace.ranked[0]
    with workplace.database.writing() as session:
        borrower = behaviours.by_slug(session, "column-2")
        borrowed.borrow(session, borrower.id, [first])
    measure_by(workplace, "column-1", LENGTH)
    measure_by(workplace, "column-2", SCORE, Length())
    keys = {key: {one.key for one in lacking} for key, lacking in missing(workplace).items()}
    assert keys.pop(first) == {LENGTH.key, SCORE.key}
    assert all(lacking == {LENGTH.key} for lacking in keys.values())


def test_games_that_do_not_replay_and_deleted_ones_are_not_measured(workplace: Workplace) -> None:
    measure_by(workplace, "column-1", LENGTH)
    first, second, *others = workplace.ranked
    with workplace.database.writing() as session:
        recordings.get(session, first).verification = Verification.FAILED
        recordings.delete(session, [recordings.get(session, second)], None)
    assert set(missing(workplace)) == set(others)


def test_what_the_game_lacks_can_not_be_asked_for(workplace: Workplace) -> None:
    with pytest.raises(Invalid, match="no counter 'divers'; it has shots"):
        measure_by(workplace, "column-1", Counted(counter="divers"))
    with pytest.raises(Invalid, match=r"no thing .* 'ball'; it has cannon, missile"):
        measure_by(workplace, "column-1", InRegion(thing="ball", area=Rectangle(0, 0, 9, 9)))
