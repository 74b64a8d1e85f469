"""What an order is about, from tables of facts."""

from __future__ import annotations

import numpy as np
import pytest

from tril.vocabulary.posterior import Choices, Evidence, Posterior, infer

N_GROUPS = 20
WIDTH = 3


def facts(rng: np.random.Generator, n_games: int) -> np.ndarray:
    return rng.normal(size=(n_games, N_GROUPS * WIDTH))


GROUPS = [np.arange(WIDTH * index, WIDTH * (index + 1)) for index in range(N_GROUPS)]
EQUAL = np.full(N_GROUPS, -np.log(N_GROUPS))


def order_by(value: np.ndarray) -> Choices:
    return Choices.of_tiers([[int(row)] for row in np.argsort(-value)], len(value))


def inferred(seed: int, group: int, n_games: int = 12) -> tuple[np.ndarray, Posterior]:
    values = facts(np.random.default_rng(seed), n_games)
    return values, infer(values, GROUPS, EQUAL, order_by(values[:, GROUPS[group][1]]))


def test_choices_of_tiers_leave_out_equals_and_what_was_chosen_before() -> None:
    choices = Choices.of_tiers([[2], [0, 3], [1]], 5)
    assert choices.chosen.tolist() == [2, 0, 3]
    assert choices.among.astype(int).tolist() == [
        [1, 1, 1, 1, 0],
        [1, 1, 0, 0, 0],
        [0, 1, 0, 1, 0],
    ]


def mean_value(posterior: Posterior, values: np.ndarray) -> np.ndarray:
    """Return the values of games averaged over statements."""
    value = np.zeros(len(values))
    for one in posterior.statements:
        value += one.probability * (values[:, one.columns] @ one.weights)
    return value


@pytest.mark.parametrize("seed", range(5))
def test_the_group_that_orders_the_games_is_found(seed: int) -> None:
    _, posterior = inferred(seed, group=7)
    assert 7 in posterior.statements[0].groups
    unseen = facts(np.random.default_rng(100 + seed), 200)
    agreement = np.corrcoef(mean_value(posterior, unseen), unseen[:, GROUPS[7][1]])[0, 1]
    assert agreement > 0.6


def test_a_sum_of_two_groups_is_found_as_two() -> None:
    values = facts(np.random.default_rng(3), 30)
    value = values[:, GROUPS[4][0]] + values[:, GROUPS[9][2]]
    posterior = infer(values, GROUPS, EQUAL, order_by(value))
    assert set(posterior.statements[0].groups) == {4, 9}


def test_an_order_by_a_group_has_more_evidence_than_orders_drawn_blindly() -> None:
    rng = np.random.default_rng(0)
    values = facts(rng, 12)
    evidence = Evidence(values, GROUPS, EQUAL)
    blind = [evidence.log_evidence(order_by(rng.normal(size=12))) for _ in range(19)]
    assert evidence.log_evidence(order_by(values[:, GROUPS[7][1]])) > max(blind)


def test_known_choices_count_like_choices_of_the_order() -> None:
    values = facts(np.random.default_rng(2), 20)
    first = Choices.of_tiers([[0], [1], [2], [3]], 20)
    second = Choices.of_tiers([[11], [10], [12], [13]], 20)
    third = Choices.of_tiers([[13], [12], [11], [10]], 20)
    alone, known = Evidence(values, GROUPS, EQUAL), Evidence(values, GROUPS, EQUAL, first)
    difference = alone.log_evidence(first + second) - alone.log_evidence(first + third)
    assert known.log_evidence(second) - known.log_evidence(third) == pytest.approx(
        difference, abs=0.2
    )


def test_probabilities_add_up() -> None:
    _, posterior = inferred(0, group=7)
    assert sum(one.probability for one in posterior.statements) == pytest.approx(1, abs=0.05)


def test_ties_say_nothing_of_their_order() -> None:
    values = facts(np.random.default_rng(5), 6)
    tied = infer(values, GROUPS, EQUAL, Choices.of_tiers([[0, 1, 2], [3, 4, 5]], 6))
    turned = infer(values, GROUPS, EQUAL, Choices.of_tiers([[2, 0, 1], [5, 3, 4]], 6))
    assert mean_value(tied, values) == pytest.approx(mean_value(turned, values), abs=1e-3)
