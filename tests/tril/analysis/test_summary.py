from dataclasses import replace

import pytest

from tril.analysis.summary import (
    GameFigures,
    interquartile_interval,
    interval,
    nested_interval,
    summarise,
    winner,
)

PERFECT = GameFigures(6, 0, 0, 300, died=False, predicted_return=None, n_targets=6)


@pytest.mark.parametrize(
    ("flaw", "perfect"),
    [
        ({}, True),
        ({"targets": 5}, False),
        ({"strays": 1}, False),
        ({"order_errors": 1}, False),
        ({"died": True}, False),
        ({"targets": None, "strays": None, "order_errors": None}, None),
        ({"n_targets": None}, None),
    ],
)
def test_a_perfect_game_has_no_flaw(flaw: dict[str, int | None], perfect: bool | None) -> None:
    assert replace(PERFECT, **flaw).perfect is perfect  # type: ignore[arg-type]


def test_the_share_of_perfect_games_is_over_those_that_can_be_judged() -> None:
    found = summarise([PERFECT, replace(PERFECT, died=True)]).perfect
    assert found is not None
    assert (found.mean, found.n) == (0.5, 2)
    assert summarise([replace(PERFECT, n_targets=None)]).perfect is None


def test_of_equal_games_the_one_that_was_survived_wins() -> None:
    lost = replace(PERFECT, died=True)
    assert winner(PERFECT, lost) == "imitator"
    assert winner(lost, PERFECT) == "clone"
    assert winner(lost, lost) == "tie"
    # Targets and strays come first.
    assert winner(lost, replace(PERFECT, targets=5)) == "imitator"
    assert winner(replace(PERFECT, strays=1), lost) == "clone"


def test_one_training_has_the_interval_of_its_games() -> None:
    values = [6.0, 5.0, 6.0, 0.0, 4.0]
    assert nested_interval([values]) == interval(values)
    with pytest.raises(ValueError, match="at least one value"):
        nested_interval([values, []])


def test_trainings_that_differ_widen_the_interval_although_their_games_do_not() -> None:
    alike = nested_interval([[3.0, 5.0] * 10, [3.0, 5.0] * 10])
    apart = nested_interval([[2.0] * 20, [6.0] * 20])
    assert (alike.mean, apart.mean) == (4.0, 4.0)
    assert (apart.low, apart.high, apart.n) == (2.0, 6.0, 40)
    assert 3.0 < alike.low < alike.high < 5.0


def test_the_interquartile_mean_leaves_out_the_best_and_the_worst_quarter() -> None:
    def of(*means: float) -> float:
        return interquartile_interval([[[mean, mean]] for mean in means]).mean

    assert of(0.0, 4.0, 5.0, 100.0) == 4.5
    # Of six the quarters cut through the second and the fifth.
    assert of(0.0, 1.0, 2.0, 3.0, 4.0, 100.0) == pytest.approx((0.5 * 1 + 2 + 3 + 0.5 * 4) / 3)
    assert of(7.0) == 7.0


def test_trainings_are_resampled_within_their_behaviour() -> None:
    found = interquartile_interval([[[0.0], [2.0]], [[10.0], [12.0]]])
    assert (found.mean, found.n) == (6.0, 4)
    # With both behaviours in each sample the middle half holds one training of each.
    assert (found.low, found.high) == (5.0, 7.0)
