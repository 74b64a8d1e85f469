"""The alarm of a run, from its rows."""

from __future__ import annotations

from tests.trainings import DEMONSTRATED, HACKS, HONEST, Training, checked
from testsupport.workplace import Workplace
from tril.store import behaviours
from tril.store.training import metrics, runs
from tril.store.training.alarms import alarm_of


def trained(workplace: Workplace, training: Training) -> str:
    run_id = workplace.make_run()
    curves = training.curves()
    with workplace.database.writing() as session:
        for name, points in curves.items():
            for step, value in points:
                metrics.add(session, run_id, "imitator", step, {name: value})
        runs.get(session, run_id).outcome = checked(dict(enumerate(DEMONSTRATED)))
    return run_id


def is_alarmed(workplace: Workplace, run_id: str) -> bool:
    with workplace.database.reading() as session:
        return alarm_of(session, runs.get(session, run_id)) is not None


def test_a_run_whose_return_rises_alone_is_alarmed(workplace: Workplace) -> None:
    run_id = trained(workplace, HACKS["all the time"])
    assert is_alarmed(workplace, run_id)
    assert not is_alarmed(workplace, trained(workplace, HONEST["both rise"]))
    with workplace.database.writing() as session:
        row = runs.get(session, run_id)
        # GAIL is not paid by the learned reward.
        row.recipe = {**row.recipe, "method": "gail"}
    assert not is_alarmed(workplace, run_id)


def test_a_run_without_targets_or_before_the_check_is_not(workplace: Workplace) -> None:
    run_id = trained(workplace, HACKS["all the time"])
    with workplace.database.writing() as session:
        behaviours.get(session, workplace.behaviour_id).target = None
    assert not is_alarmed(workplace, run_id)
    assert not is_alarmed(workplace, workplace.make_run())


def test_some_curves_are_read_alone(workplace: Workplace) -> None:
    run_id = workplace.make_run()
    with workplace.database.writing() as session:
        metrics.add(session, run_id, "imitator", 20, {"hits": 1.5, "entropy": 0.2})
        metrics.add(session, run_id, "imitator", 10, {"entropy": 0.3})
        metrics.add(session, run_id, "clone", 10, {"hits": 9.0})
    with workplace.database.reading() as session:
        found = metrics.curves(session, run_id, "imitator", ("hits", "strays"))
    assert found == {"hits": [(20, 1.5)], "strays": []}
