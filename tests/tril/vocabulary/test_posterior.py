"""What an order is about, from tables of facts."""

from __future__ import annotations

import numpy as np
import pytest

from tril.vocabulary.posterior import (
    Choices,
    Evidence,
    Part,
    Posterior,
    evidence_of_one_step,
    infer,
)
from tril.vocabulary.shapes import shapes_of

N_GROUPS = 20
WIDTH = 3


def facts(rng: np.random.Generator, n_games: int) -> np.ndarray:
    return rng.normal(size=(n_games, N_GROUPS * WIDTH))


GROUPS = [np.arange(WIDTH * index, WIDTH * (index + 1)) for index in range(N_GROUPS)]
EQUAL = np.full(N_GROUPS, -np.log(N_GROUPS))


def free_parts(values: np.ndarray) -> list[Part]:
    """Return parts with a weight for each fact of a group."""
    return [
        Part(index, columns, np.eye(WIDTH), values[:, columns], EQUAL[index])
        for index, columns in enumerate(GROUPS)
    ]


def order_by(value: np.ndarray) -> Choices:
    return Choices.of_tiers([[int(row)] for row in np.argsort(-value)], len(value))


def inferred(seed: int, group: int, n_games: int = 12) -> tuple[np.ndarray, Posterior]:
    values = facts(np.random.default_rng(seed), n_games)
    return values, infer(free_parts(values), order_by(values[:, GROUPS[group][1]]))


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
    posterior = infer(free_parts(values), order_by(value))
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
    tied = infer(free_parts(values), Choices.of_tiers([[0, 1, 2], [3, 4, 5]], 6))
    turned = infer(free_parts(values), Choices.of_tiers([[2, 0, 1], [5, 3, 4]], 6))
    assert mean_value(tied, values) == pytest.approx(mean_value(turned, values), abs=1e-3)


def sum_part(values: np.ndarray, weights: list[float], *, is_positive: bool) -> Part:
    """Return a part that weighs the first group's facts in these proportions."""
    basis = np.array(weights)[:, None]
    columns = GROUPS[0]
    return Part(0, columns, basis, values[:, columns] @ basis, 0.0, is_positive)


def test_a_weight_that_has_to_be_positive_is_no_reason_for_an_order_the_other_way() -> None:
    values = facts(np.random.default_rng(8), 12)
    down = order_by(-values[:, 0])
    either = sum_part(values, [1, 0, 0], is_positive=False)
    only_up = sum_part(values, [1, 0, 0], is_positive=True)
    other = sum_part(values, [0, 1, 0], is_positive=False)
    assert infer([either, other], down).statements[0].weights[0] < 0
    statements = infer([only_up, other], down).statements
    assert all(one.weights[0] == 0 for one in statements)


def test_a_sum_that_fits_is_more_probable_than_free_weights() -> None:
    rng = np.random.default_rng(9)
    values = facts(rng, 12)
    free = Part(0, GROUPS[0], np.eye(WIDTH), values[:, GROUPS[0]], 0.0)
    side = sum_part(values, [0, 1, 1], is_positive=True)
    best = infer([free, side], order_by(values[:, 1] + values[:, 2])).statements[0]
    assert best.weights[0] == 0
    assert best.weights[1] == pytest.approx(best.weights[2])


def test_one_step_tells_which_statements_are_worth_a_fit() -> None:
    values = facts(np.random.default_rng(10), 12)
    choices = order_by(values[:, 5])
    n_facts = values.shape[1]
    either = evidence_of_one_step(values, choices, np.zeros(n_facts, np.bool_))
    assert int(np.argmax(either)) == 5
    down = evidence_of_one_step(-values, choices, np.ones(n_facts, np.bool_))
    assert down[5] == -np.inf


@pytest.mark.parametrize(
    ("n_facts", "is_ordered", "excludes"),
    [
        *((n_facts, True, excludes) for n_facts in (2, 6) for excludes in (False, True)),
        (1, True, False),
        (3, False, False),
    ],
)
def test_shapes_and_free_weights_share_all_of_the_probability(
    n_facts: int, is_ordered: bool, excludes: bool
) -> None:
    shapes = shapes_of(n_facts, is_ordered, excludes)
    assert shapes.shares.sum() + shapes.free_share == pytest.approx(1)
    assert shapes.sums.shape == (n_facts, len(shapes.shares))
    distinct = {tuple(one) for one in shapes.sums.T.tolist()}
    assert len(distinct) == len(shapes.shares)
