"""What a person is told of the check of their ranking."""

from __future__ import annotations

from trainer.reward.advice import advice, warning
from trainer.reward.check import ConfusedTiers, RankingCheck

CONFUSED = (
    ConfusedTiers(8, 9, held_out=False, n_right=0, n_compared=1),
    ConfusedTiers(3, 7, held_out=True, n_right=2, n_compared=4),
    ConfusedTiers(8, 9, held_out=True, n_right=1, n_compared=2),
    ConfusedTiers(1, 2, held_out=True, n_right=9, n_compared=10),
)


def test_an_order_that_chance_may_explain_is_warned_of_and_another_is_refused() -> None:
    doubtful = RankingCheck({}, {}, 0.9, 0.9, 0.9, (), passed=True, n_as_good=2)
    assert advice(doubtful) == ""
    assert warning(doubtful).startswith("2 of 19 shuffled orders")
    nonsense = RankingCheck({}, {}, 0.9, 0.9, 0.9, (), passed=False, n_as_good=9)
    assert "better than chance" in advice(nonsense)
    assert warning(nonsense) == ""


def test_advice_names_what_is_confused() -> None:
    confused = tuple(
        ConfusedTiers(1, worse, held_out=False, n_right=0, n_compared=1) for worse in range(2, 10)
    )
    check = RankingCheck({}, {}, 0.4, 0.6, 0.52, confused, passed=False)
    said = advice(check)
    assert "tau 0.40" in said
    assert "52% of the pairs" in said
    assert "tiers 1 and 2, 1 and 3, 1 and 4, 1 and 5, 1 and 6, 1 and 7 and 2 more pairs" in said
    assert "other demonstrations or another order" in said
    assert "aliens" not in said
    assert "the recipe any. You can also go on" in advice(check, aliens_alone=True)
    # The advice has named them.
    assert warning(check) == ""


def test_advice_names_only_what_failed() -> None:
    said = advice(RankingCheck({}, {}, 0.95, 0.6, 0.5, (), passed=False))
    assert "tau" not in said
    assert "50% of the pairs" in said


def test_a_ranking_that_is_followed_in_part_gives_a_warning_and_no_advice() -> None:
    confused = (ConfusedTiers(3, 7, held_out=True, n_right=2, n_compared=4),)
    check = RankingCheck({}, {}, 0.7, 0.8, 0.75, confused, passed=True)
    assert advice(check) == ""
    assert "not everywhere" in warning(check)
    assert "75% of held-out pairs" in warning(check)
    assert "apart: 3 and 7." in warning(check)


def test_a_warning_names_the_tiers_that_are_not_told_apart_each_pair_once() -> None:
    check = RankingCheck({}, {}, 0.7, 0.8, 0.75, CONFUSED, passed=True)
    assert "apart: 8 and 9, 3 and 7. Games" in warning(check)


def test_a_ranking_that_was_understood_needs_no_words_single_tiers_aside() -> None:
    for confused in ((), CONFUSED):
        check = RankingCheck({}, {}, 0.95, 0.9, None, confused, passed=True)
        assert advice(check) == warning(check) == ""
