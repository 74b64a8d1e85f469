"""What runs have found, as this version and earlier ones stored it."""

from __future__ import annotations

import json

from sqlalchemy import text

from testsupport.workplace import Workplace
from tril.analysis.outcome import ImitatorOutcome, RunOutcome
from tril.analysis.summary import GameFigures, summarise
from tril.store.training import runs

FOUND_BY_THE_FIRST_VERSION = {
    "check": {
        "predicted_returns": {"1": 12.5, "2": -3.0},
        "tau": 1.0,
        "pair_accuracy": 0.93,
        "held_out_accuracy": None,
        "confused": [{"better": 1, "worse": 2, "held_out": True}],
        "passed": True,
        "advice": "",
    },
    "imitator": {"best_steps": 256},
    "headline": {
        "imitator": None,
        "clone": None,
        "tau": 1.0,
        "pair_accuracy": 0.93,
        "held_out_accuracy": None,
    },
}


def stored(workplace: Workplace, run_id: str) -> object:
    with workplace.database.engine.connect() as connection:
        found = connection.execute(text("SELECT outcome FROM runs WHERE id = :id"), {"id": run_id})
        outcome = found.scalar_one()
    # PostgreSQL's driver reads JSON by itself.
    return json.loads(outcome) if isinstance(outcome, str) else outcome


def test_what_the_first_version_stored_is_read_and_kept_as_it_is(workplace: Workplace) -> None:
    run_id = workplace.make_run()
    with workplace.database.engine.begin() as connection:
        connection.execute(
            text("UPDATE runs SET outcome = :outcome WHERE id = :id"),
            {"outcome": json.dumps(FOUND_BY_THE_FIRST_VERSION), "id": run_id},
        )
    outcome = workplace.run(run_id).outcome
    assert outcome.check is not None
    assert outcome.check.predicted_returns == {1: 12.5, 2: -3.0}
    assert outcome.check.warning == ""
    assert outcome.check.confused[0].n_compared is None
    assert outcome.imitator == ImitatorOutcome(best_steps=256)
    assert outcome.example is None
    with workplace.database.writing() as session:
        runs.get(session, run_id).outcome = outcome.updated_with(RunOutcome())
    assert stored(workplace, run_id) == FOUND_BY_THE_FIRST_VERSION


def test_an_outcome_is_the_same_after_it_was_stored(workplace: Workplace) -> None:
    run_id = workplace.make_run()
    first = RunOutcome.model_validate(FOUND_BY_THE_FIRST_VERSION)
    game = GameFigures(4, 1, 0, 200, died=True, predicted_return=3.5)
    assert first.headline is not None
    headline = first.headline.model_copy(update={"imitator": summarise([game, game])})
    outcome = first.updated_with(RunOutcome(headline=headline))
    with workplace.database.writing() as session:
        runs.get(session, run_id).outcome = outcome
    assert workplace.run(run_id).outcome == outcome
    assert outcome.check == first.check
