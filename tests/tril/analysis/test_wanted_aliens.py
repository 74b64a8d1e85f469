"""Which aliens are wanted, inferred from what games hit."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from tril.analysis.wanted_aliens import (
    LABELS,
    WANTED,
    Hits,
    Posterior,
    best_games,
    labels_of_draws,
    learned_order,
    log_likelihood_by_game,
    log_prior,
    pair_weights,
    worth,
)
from tril.games.space_invaders.memory import FRAMES_PER_STEP

N_STEPS = 200
APART = 12
"""Steps from one hit to the next."""

COLUMN_3 = (2, 8, 14, 20, 26, 32)
ROW_1 = (0, 1, 2, 3, 4, 5)


def hits(aliens: Sequence[int], n_steps: int = N_STEPS) -> Hits:
    """Return what a game hits that hits aliens in turn."""
    frames = [number * APART * FRAMES_PER_STEP for number in range(1, len(aliens) + 1)]
    rows_and_columns = [divmod(alien, 6) for alien in aliens]
    return Hits.of(
        [(*cell, frame) for cell, frame in zip(rows_and_columns, frames, strict=True)],
        n_steps * FRAMES_PER_STEP,
    )


def test_hits_of_a_recording_count_in_steps() -> None:
    found = Hits.of([(1, 2, 1), (0, 5, 8), (3, 0, 9), (1, 2, 50)], 81)
    assert found.n_steps == 21
    assert np.flatnonzero(found.gone).tolist() == [5, 8, 18]
    # The last hit is in a grid that has been filled again.
    assert [found.steps[alien] for alien in (8, 5, 18)] == [1, 2, 3]


def test_an_alien_is_in_reach_while_it_is_the_lowest_of_its_column() -> None:
    found = hits([2, 8, 0])
    assert np.flatnonzero(found.in_reach).tolist() == [0, 1, 2, 3, 4, 5, 6, 8, 14]
    # The game ends too soon after the second hit for the third to have been in reach.
    assert not hits([2, 8], 2 * APART + 20).in_reach[14]
    # One that is hit before those below it counts if the lowest of its column is hit, too.
    assert hits([2, 8, 20]).in_reach[20]
    assert not hits([8, 20]).in_reach[[8, 20]].any()


def test_rows_are_swept_from_their_left_ends() -> None:
    assert np.flatnonzero(hits([0, 1, 3, 6, 8]).swept).tolist() == [0, 1, 6]


def test_an_order_is_learned_from_games_that_keep_it() -> None:
    in_order = [hits(ROW_1), hits(ROW_1), hits(ROW_1[:4])]
    assert learned_order(in_order)[:6] == pytest.approx([0, 0.75, 0.75, 0.75, 2 / 3, 2 / 3])
    assert learned_order(in_order * 20)[:6].min(initial=1, where=np.arange(6) > 0) > 0.97
    reverse = [hits(ROW_1[::-1])] * 3
    assert not learned_order(reverse).any()
    # One of three games hits the second alien before the first.
    mixed = learned_order([*in_order[:2], hits([1, 0, 2, 3, 4, 5])])
    assert mixed[1] == pytest.approx(2 * 2.5 / 4 - 1)
    assert mixed[2] == pytest.approx(0.75)
    # Games that leave the row unfinished say nothing.
    assert not learned_order([hits([0, 2])] * 5).any()


def test_the_prior_expects_what_the_best_games_hit_where_they_could() -> None:
    best = [hits(COLUMN_3)] * 10 + [hits(COLUMN_3[:5], 5 * APART + 10)] * 3
    by_column = log_prior(best)
    assert by_column.shape == (6, 7)
    # The last alien was out of reach in the games that ended early.
    assert by_column.argmax(1).tolist() == [0, 0, 6, 0, 0, 0]
    # Of a column that nobody shoots at, nothing but the prior says what is behind its first alien.
    row = log_prior([hits(ROW_1)] * 10)
    assert row.argmax(1).tolist() == [1] * 6
    assert (row[0, 3:6] - row[0, 2:5]) == pytest.approx(np.log(min(c for _, c in WANTED)), abs=1e-9)


def test_without_best_games_the_prior_is_the_first_one() -> None:
    odds = np.exp(log_prior([]))
    assert odds.sum(1) == pytest.approx(1)
    assert odds[:, 0] == pytest.approx(1 - WANTED[0][0])


def test_an_alien_that_most_of_the_best_games_spare_is_not_wanted() -> None:
    lower = [hits(COLUMN_3[:4])] * 9
    assert log_prior([*lower, *[hits(COLUMN_3[:5])] * 3]).argmax(1).tolist() == [0, 0, 4, 0, 0, 0]
    # Where wanted ones are missed as often, it may be wanted, too.
    missed = [hits(COLUMN_3[:3]), hits(COLUMN_3[:2]), hits(COLUMN_3[:1])] * 3
    assert log_prior([*missed, *[hits(COLUMN_3[:5])] * 3]).argmax(1)[2] == 5


def test_games_that_stray_far_behind_an_unwanted_alien_do_not_make_it_wanted() -> None:
    block = [0, 6, 12, 1, 7, 13]
    missing_one = [hits([0, 6, 1, 7, 13])] * 3 + [hits([0, 6, 12, 1, 7])] * 3
    best = [hits(block)] * 5 + missing_one + [hits([*block, 18, 24, 30])] * 2
    assert log_prior(best).argmax(1).tolist() == [3, 3, 0, 0, 0, 0]


def test_what_nothing_has_reached_is_not_taken_for_wanted() -> None:
    # The last of a row is hit so late that the one behind it is never in reach.
    best = [hits(ROW_1, 6 * APART + 10)] * 4
    assert not any(one.in_reach[11] for one in best)
    labels = (np.exp(log_prior(best) - np.logaddexp.reduce(log_prior(best), 1)[:, None]) @ LABELS).T
    assert (labels[0] > 0.9).all()
    assert (labels[1:] < -0.3).all()


def test_who_hits_as_many_as_possible_wants_aliens_that_no_game_has_hit() -> None:
    best = [
        hits([5, 3, 3 + 6, 1, 1 + 6, 0, 3 + 12, 0 + 6, 4, 3 + 18]),
        hits([3, 5, 4, 3 + 6, 3 + 12, 3 + 18, 4 + 6, 0, 5 + 6, 2]),
        hits([4, 1, 0, 5, 4 + 6, 4 + 12, 4 + 18, 3, 3 + 6, 3 + 12]),
    ]
    prior = log_prior(best)
    labels = (np.exp(prior - np.logaddexp.reduce(prior, 1)[:, None]) @ LABELS).T.ravel()
    never_hit = ~np.any([one.gone for one in best], axis=0)
    assert never_hit[8]
    assert (labels[:18] > 0.0).all(), labels.round(2)
    # Who clears the lowest row, and once strays on, wants the row.
    assert log_prior([*[hits(ROW_1)] * 4, hits([*ROW_1, 6])]).argmax(1).tolist() == [1] * 6


def test_accidents_behind_a_columns_lowest_alien_do_not_make_it_wanted() -> None:
    best = [hits(COLUMN_3)] * 13 + [hits([*COLUMN_3, 7]), hits([*COLUMN_3, 13, 19])]
    assert log_prior(best).argmax(1).tolist() == [0, 0, 6, 0, 0, 0]


def test_the_posterior_is_what_all_combinations_give() -> None:
    ranking = [(2, 8), (2,), (3,), (3, 9)]
    played = {index: hits(aliens) for index, aliens in enumerate(ranking)}
    pairs = [(i, j) for i in range(4) for j in range(i + 1, 4)]
    prior = log_prior([played[0]])
    weights = np.array([1.0, 0.5, 0.5, 1.0, 0.25, 1.0])
    posterior = Posterior(played, pairs, weights, prior, np.zeros(36))
    rng = np.random.default_rng(0)
    sampled = np.mean([posterior.sample(rng) for _ in range(3_000)], axis=0)
    # Only the third and the fourth column are told apart by the ranking.
    numbers = np.arange(7)
    n_third, n_fourth = np.meshgrid(numbers, numbers, indexing="ij")

    def worth(aliens: Sequence[int]) -> np.ndarray:
        total = np.zeros((7, 7))
        for alien in aliens:
            row, column = divmod(alien, 6)
            total += np.where(row < (n_third if column == 2 else n_fourth), 1.0, -1.0)
        return total

    log_odds = prior[2][:, None] + prior[3][None]
    for (better, worse), weight in zip(pairs, weights, strict=True):
        gap = worth(ranking[better]) - worth(ranking[worse])
        log_odds += weight * np.log(0.1 + 0.8 / (1.0 + np.exp(-gap)))
    odds = np.exp(log_odds - log_odds.max())
    odds /= odds.sum()
    np.testing.assert_allclose(sampled[2], odds.sum(1), atol=0.02)
    np.testing.assert_allclose(sampled[3], odds.sum(0), atol=0.02)


def test_draws_follow_the_passes_after_the_burn_in() -> None:
    played = {0: hits(COLUMN_3), 1: hits([1])}
    prior = log_prior([played[0]])
    one, other = (Posterior(played, [(0, 1)], np.ones(1), prior, np.zeros(36)) for _ in range(2))
    draws = one.draws(np.random.default_rng(0), 30)
    assert draws.shape == (24, 6)
    rng = np.random.default_rng(0)
    probabilities = np.array([other.sample(rng) for _ in range(30)])[6:]
    assert (probabilities[np.arange(24)[:, None], np.arange(6), draws] > 0).all()
    assert np.bincount(draws[:, 2]).argmax() == 6


def test_games_are_worth_what_each_draw_wants_of_their_hits() -> None:
    labels = labels_of_draws(np.array([[0, 0, 6, 0, 0, 0], [2, 1, 0, 0, 0, 0]]))
    assert np.flatnonzero(labels[0] > 0).tolist() == list(COLUMN_3)
    assert np.flatnonzero(labels[1] > 0).tolist() == [0, 1, 6]
    games = [hits(COLUMN_3), hits([2, 3]), hits([1, 0, 6])]
    assert worth(labels, np.zeros(36), games).tolist() == [[6, 0, -3], [-6, -2, 3]]
    # Half of what counts only in order is lost out of it.
    order = np.zeros(36)
    order[1] = 0.5
    assert worth(labels, order, [hits([1]), hits([1, 0])])[1].tolist() == [0.5, 2.0]


def test_the_likelihood_of_a_game_is_that_of_its_own_pairs() -> None:
    gains = np.array([[3.0, 1.0, 1.0]])
    found = log_likelihood_by_game(gains, np.array([[0, 1], [2, 1]]), np.array([1.0, 0.5]))
    better, tied = (np.log(0.1 + 0.8 / (1.0 + np.exp(-gap))) for gap in (2.0, 0.0))
    assert found[0] == pytest.approx([better, better + tied / 2, tied / 2])


def test_a_pair_counts_by_the_size_of_its_larger_tier() -> None:
    tiers = [[5], [7, 2], [1, 3, 4]]
    assert pair_weights([(5, 2), (5, 1), (7, 3), (2, 5)], tiers) == pytest.approx(
        [1 / 2, 1 / 3, 1 / 3, 1 / 2]
    )


def test_the_best_games_are_the_perfect_ones_and_the_best_ranked() -> None:
    tiers = [[4], [2, 3], [1], [0, 5, 6, 7]]
    assert best_games(tiers, []) == [4]
    assert best_games(tiers, [9, 4]) == [4, 9]
    # Further games that are as good as the best one must not undo what it says.
    assert best_games([[1, 2], [3], [4], [5]], [9]) == [1, 2, 9]
    # In fewer than four tiers, a first tier of half of the games says little beside perfect ones.
    assert best_games([[1, 2], [3], [4]], [9]) == [9]
    assert best_games([[1, 2], [3, 4]], [9]) == [9]
    assert best_games([[1, 2], [3, 4]], []) == [1, 2]
