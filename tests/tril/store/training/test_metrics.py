"""The points of curves."""

from __future__ import annotations

from testsupport.workplace import Workplace
from tril.store.training import metrics


def test_series_are_split_by_stage_and_name_in_order_of_steps(workplace: Workplace) -> None:
    run_id = workplace.make_run()
    with workplace.database.writing() as session:
        metrics.add(session, run_id, "imitator", 200, {"entropy": 1.0})
        metrics.add(session, run_id, "imitator", 100, {"entropy": 2.0, "hits": 0.5})
        metrics.add(session, run_id, "reward", 1, {"loss": 0.7})
        _, series = metrics.series(session, run_id)
    assert series == {
        "imitator": {"entropy": [(100, 2.0), (200, 1.0)], "hits": [(100, 0.5)]},
        "reward": {"loss": [(1, 0.7)]},
    }


def test_a_second_point_at_a_step_completes_the_first(workplace: Workplace) -> None:
    run_id = workplace.make_run()
    with workplace.database.writing() as session:
        metrics.add(session, run_id, "imitator", 100, {"entropy": 1.0})
        metrics.add(session, run_id, "imitator", 100, {"entropy": 2.0, "kl": 0.1})
        _, series = metrics.series(session, run_id)
    assert series == {"imitator": {"entropy": [(100, 2.0)], "kl": [(100, 0.1)]}}


def test_points_that_replace_dropped_ones_come_after_what_was_read(workplace: Workplace) -> None:
    run_id = workplace.make_run()
    with workplace.database.writing() as session:
        for step in (100, 200, 300):
            metrics.add(session, run_id, "imitator", step, {"kl": step / 1000})
    with workplace.database.reading() as session:
        last, _ = metrics.series(session, run_id)
    with workplace.database.writing() as session:
        metrics.drop_after(session, run_id, "imitator", 100)
    with workplace.database.writing() as session:
        metrics.add(session, run_id, "imitator", 200, {"kl": 0.9})
    with workplace.database.reading() as session:
        newer, series = metrics.series(session, run_id, last)
        _, whole = metrics.series(session, run_id)
    assert newer > last
    assert series == {"imitator": {"kl": [(200, 0.9)]}}
    assert whole == {"imitator": {"kl": [(100, 0.1), (200, 0.9)]}}
    with workplace.database.reading() as session:
        assert metrics.series(session, run_id, newer) == (newer, {})
