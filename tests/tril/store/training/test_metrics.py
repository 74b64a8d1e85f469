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


def test_long_curves_are_thinned_evenly_with_both_ends(workplace: Workplace) -> None:
    run_id = workplace.make_run()
    with workplace.database.writing() as session:
        points = [("imitator", step, {"kl": step / 10}) for step in range(10, 1_010, 10)]
        metrics.add_curves(session, run_id, [*points, ("reward", 1, {"loss": 0.7})])
        last, thinned = metrics.series(session, run_id, most=30)
        newest, whole = metrics.series(session, run_id)
    assert last == newest
    assert whole["imitator"]["kl"] == [(step, step / 10) for step in range(10, 1_010, 10)]
    assert [step for step, _ in thinned["imitator"]["kl"]] == [*range(10, 1_010, 40), 1_000]
    assert thinned["reward"] == {"loss": [(1, 0.7)]}


def test_curves_that_are_short_enough_are_whole(workplace: Workplace) -> None:
    run_id = workplace.make_run()
    with workplace.database.writing() as session:
        metrics.add_curves(session, run_id, [("imitator", n, {"kl": 0.5}) for n in range(1, 31)])
        assert metrics.series(session, run_id, most=30) == metrics.series(session, run_id)


def test_newer_points_are_thinned_among_themselves(workplace: Workplace) -> None:
    run_id = workplace.make_run()
    with workplace.database.writing() as session:
        metrics.add_curves(session, run_id, [("imitator", n, {"kl": 0.5}) for n in range(1, 11)])
        first, _ = metrics.series(session, run_id, most=5)
        metrics.add(session, run_id, "imitator", 11, {"kl": 0.1})
        last, newer = metrics.series(session, run_id, first, most=5)
        nothing = metrics.series(session, run_id, last, most=5)
    assert newer == {"imitator": {"kl": [(11, 0.1)]}}
    assert nothing == (last, {})


def test_named_curves_are_thinned_as_all_are(workplace: Workplace) -> None:
    run_id = workplace.make_run()
    with workplace.database.writing() as session:
        points = [("imitator", step, {"kl": step / 10, "hits": 1.0}) for step in range(1, 1_001)]
        metrics.add_curves(session, run_id, points)
        _, thinned = metrics.series(session, run_id, most=30)
        found = metrics.curves(session, run_id, "imitator", ("kl",), most=30)
    assert found["kl"] == thinned["imitator"]["kl"]
    assert 25 <= len(found["kl"]) <= 32
    assert found["kl"][0] == (1, 0.1)
    assert found["kl"][-1] == (1_000, 100.0)


def test_points_far_apart_are_kept_and_dense_ones_thinned(workplace: Workplace) -> None:
    run_id = workplace.make_run()
    with workplace.database.writing() as session:
        steps = [*range(1, 101), 500, 1_000]
        metrics.add_curves(session, run_id, [("imitator", step, {"kl": 0.5}) for step in steps])
        _, thinned = metrics.series(session, run_id, most=20)
    assert [step for step, _ in thinned["imitator"]["kl"]] == [1, 50, 99, 500, 1_000]
