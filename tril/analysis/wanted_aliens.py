"""Inferring from a ranking and from the best games which aliens are wanted.

A dozen ranked games do not say what every screen is worth, but they do say how many aliens of each
column are wanted, counted from the bottom: one that is behind others can hardly be hit before them.
Each of the 36 aliens then has a label, +1 if it is wanted and -1 if not, and a game is worth the
sum of the labels of what it hit. As in Bayesian REX (Brown et al. 2020), the posterior is sampled
from the likelihood of the preferences; the labels and the prior are ours.

- Prior. The lowest alien of a column is wanted with probability s, a further one, if all below it
  are, with c. The best games are meant as all of the behaviour: of those that had an alien in
  reach, the number that hit it follows a beta-binomial distribution, with parameters v and 1 if it
  is wanted, 1 and u if it is the lowest of its column that is not. Those behind that one come into
  reach by accident; they have the parameters 1 and 2. s, c, v and u are the most likely ones
  (empirical Bayes).
- Likelihood. Of two games in different tiers, the better one is ranked higher with probability
  0.1 + 0.8 sigmoid(difference in worth). Each pair's log likelihood is divided by the size of the
  larger of its tiers: whoever puts 24 games below another says one thing, not 24.
- Order. Where the best games that clear a row up to a wanted alien have hit it after all on its
  left, it counts only once the row has been swept up to it.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass
from itertools import product
from math import lgamma, log
from typing import Self

import numpy as np
import numpy.typing as npt

from tril.games.space_invaders.memory import COLUMNS, FRAMES_PER_STEP, ROWS
from tril.ranking import BEST_SHARE, Pair, best_ranked

Array = npt.NDArray[np.float64]

N_ALIENS = ROWS * COLUMNS

LABELS = np.where(np.arange(ROWS) < np.arange(ROWS + 1)[:, None], 1.0, -1.0)
"""Labels of a column's aliens, from the bottom, by how many are wanted, float64 (7, 6)."""

WANTED = (*product((0.3, 0.1, 0.5), repeat=2), (0.9, 0.1), (0.9, 0.9))
"""Values of (s, c) that are considered; of equally likely ones the first counts.

With the last two, nearly all columns are wanted: their lowest aliens, or as many as can be hit.
"""

MISSED = (1, 2, 4, 8)
"""Values of v that are considered: a wanted alien is missed about once in v + 1 games."""

UNWANTED = (5, 10, 20, 40, 80, 160)
"""Values of u that are considered: an unwanted alien is hit about once in u + 1 games."""

BEHIND = (1, 2)
"""Parameters of unwanted aliens behind another unwanted one: whoever strays often strays on."""

REACH_STEPS = 25
"""Fewest steps to the end of a game with which the lowest alien of a column is in reach."""

MISTAKES = 0.1
"""Probability that two games are ranked the other way round, however much their worth differs."""

BURN_IN = 0.2
"""Share of the passes that are dropped."""


@dataclass(frozen=True)
class Hits:
    """What a game hits.

    Attributes:
        steps: The step after which each alien of the full grid is gone, row by row, inf if it is
            left, float64 (36,).
        n_steps: Length of the game, in steps.
    """

    steps: Array
    n_steps: int

    @classmethod
    def of(cls, hits: Iterable[Sequence[int]], n_frames: int) -> Self:
        """Return those of a recording.

        Args:
            hits: Row, column and frame of each.
            n_frames: Length of the game.
        """
        steps = np.full(N_ALIENS, np.inf)
        for row, column, frame in hits:
            alien = row * COLUMNS + column
            # The first time: a cleared grid is filled again.
            steps[alien] = min(steps[alien], -(-frame // FRAMES_PER_STEP))
        return cls(steps, -(-n_frames // FRAMES_PER_STEP))

    @property
    def gone(self) -> npt.NDArray[np.bool_]:
        """Which aliens are gone in the end, bool (36,)."""
        return np.isfinite(self.steps)

    @property
    def swept(self) -> npt.NDArray[np.bool_]:
        """Up to which aliens the rows are swept in the end, bool (36,)."""
        cleared = self.gone.reshape(ROWS, COLUMNS)
        return np.logical_and.accumulate(cleared, axis=1).ravel()

    @property
    def in_reach(self) -> npt.NDArray[np.bool_]:
        """Which aliens the player could have aimed at, bool (36,).

        An alien is in reach once all below it are gone. A hit on one behind others counts, too, if
        the lowest of its column is also hit; otherwise it is taken for an accident.
        """
        grid = self.steps.reshape(ROWS, COLUMNS)
        lowest_from = np.zeros_like(grid)
        np.maximum.accumulate(grid[:-1], axis=0, out=lowest_from[1:])
        could = lowest_from <= self.n_steps - REACH_STEPS
        hit = np.isfinite(grid) & np.isfinite(grid[0])
        reached: npt.NDArray[np.bool_] = (hit | could).ravel()
        return reached


def learned_order(best: Sequence[Hits]) -> Array:
    """Return the weight of order for each alien, float64 (36,), 0 to 1.

    It grows in proportion from 0, where half of the games that clear the row up to the alien or
    fewer have hit it last, to 1. The share is the posterior mean under Jeffreys' prior, so that two
    games that agree make it 0.67, and ten 0.91.

    Args:
        best: Hits of the best games.
    """
    grid = np.stack([hits.steps for hits in best]).reshape(-1, ROWS, COLUMNS)
    order = np.zeros((ROWS, COLUMNS))
    for column in range(1, COLUMNS):
        earlier_columns, column_steps = grid[:, :, :column].max(2), grid[:, :, column]
        n_cleared = (np.isfinite(earlier_columns) & np.isfinite(column_steps)).sum(0)
        n_in_order = ((earlier_columns < column_steps) & np.isfinite(column_steps)).sum(0)
        share = (n_in_order + 0.5) / (n_cleared + 1.0)
        order[:, column] = (2.0 * share - 1.0).clip(0.0)
    return order.ravel()


def log_prior(best: Sequence[Hits]) -> Array:
    """Return the log prior of how many aliens of each column are wanted, float64 (6, 7).

    It is known up to a constant.

    Args:
        best: Hits of the best games, perhaps none.
    """
    in_reach = np.reshape([hits.in_reach for hits in best], (-1, N_ALIENS)).astype(bool)
    cleared = np.reshape([hits.gone for hits in best], (-1, N_ALIENS)).astype(bool)
    n_hit, n_reached = (in_reach & cleared).sum(0).tolist(), in_reach.sum(0).tolist()

    def of_hits(a: int, b: int) -> Array:
        """Return the log probability of each alien's hits with parameters a and b, (6, 1, 6)."""
        log_probabilities = [
            _log_beta_binomial(k, n, a, b) for k, n in zip(n_hit, n_reached, strict=True)
        ]
        return np.reshape(log_probabilities, (ROWS, COLUMNS)).T[:, None]

    n_wanted, row = np.arange(ROWS + 1)[:, None], np.arange(ROWS)
    of_wanted = np.stack([of_hits(v, 1) for v in MISSED])[:, None]
    of_unwanted = np.stack([of_hits(1, u) for u in UNWANTED])
    # By v, u, column and number of wanted aliens.
    kinds = [row < n_wanted, row == n_wanted]
    of_best = np.select(kinds, [of_wanted, of_unwanted], of_hits(*BEHIND)).sum(4)
    of_numbers = [_log_probability_of_numbers(s, c) for s, c in WANTED]
    candidates = np.concatenate(
        [of_best.reshape(-1, COLUMNS, ROWS + 1) + log_probability for log_probability in of_numbers]
    )
    evidence = np.logaddexp.reduce(candidates, axis=2).sum(1).round(9)
    likely: Array = candidates[evidence.argmax()]
    return likely


def _log_probability_of_numbers(lowest: float, further: float) -> Array:
    """Return the log probability that 0 to 6 aliens of a column are wanted, float64 (7,).

    Args:
        lowest: Probability that the lowest one is.
        further: That another one is, if all below it are.
    """
    log_probabilities = log(lowest) + np.arange(ROWS) * log(further)
    log_probabilities[:-1] += log(1.0 - further)
    return np.array([log(1.0 - lowest), *log_probabilities])


def _log_beta_binomial(k: int, n: int, a: int, b: int) -> float:
    """Return the log probability of certain k of n, under parameters a and b."""
    log_beta = lgamma(k + a) + lgamma(n - k + b) - lgamma(n + a + b)
    return log_beta - lgamma(a) - lgamma(b) + lgamma(a + b)


def pair_weights(pairs: Iterable[Sequence[int]], tiers: Iterable[Sequence[int]]) -> Array:
    """Return the weight of each pair, float64 (P,): 1 divided by the size of its larger tier.

    Args:
        pairs: Games of different tiers.
        tiers: All ranked games.
    """
    sizes = {game: len(tier) for tier in tiers for game in tier}
    return np.array([1.0 / max(sizes[better], sizes[worse]) for better, worse in pairs])


class Posterior:
    """The posterior of how many aliens of each column are wanted.

    Args:
        hits: Hits of each game.
        pairs: Games, the better one first.
        weights: Weight of each pair, float64 (P,), see pair_weights.
        prior: See log_prior.
        order: See learned_order.
    """

    def __init__(
        self,
        hits: dict[int, Hits],
        pairs: Sequence[Pair],
        weights: Array,
        prior: Array,
        order: Array,
    ) -> None:
        gains, costs = _counted(list(hits.values()), order)
        place = {game: at for at, game in enumerate(hits)}
        better, worse = np.array([[place[game] for game in pair] for pair in pairs]).T
        # How much more the better game is worth, by column, pair and number of wanted aliens.
        self._worth = _by_column(gains[better] - gains[worse]) @ (LABELS > 0).T
        self._worth -= _by_column(costs[better] - costs[worse]) @ (LABELS < 0).T
        self._weights = weights
        self._prior = prior
        self._wanted = prior.argmax(1)
        self._difference = self._worth[np.arange(COLUMNS), :, self._wanted].sum(0)

    def sample(self, rng: np.random.Generator) -> Array:
        """Draw the number of wanted aliens of one column after another (Gibbs sampling).

        Returns:
            The probability of each number, given the other columns', float64 (6, 7).
        """
        probabilities = np.empty_like(self._prior)
        for column, worth in enumerate(self._worth):
            rest_difference = self._difference - worth[:, self._wanted[column]]
            differences = rest_difference[:, None] + worth
            log_odds = self._prior[column] + self._weights @ np.log(_probability(differences))
            odds = np.exp(log_odds - log_odds.max())
            probabilities[column] = odds / odds.sum()
            self._wanted[column] = rng.choice(ROWS + 1, p=probabilities[column])
            self._difference = differences[:, self._wanted[column]]
        return probabilities

    def draws(self, rng: np.random.Generator, n_passes: int) -> npt.NDArray[np.int64]:
        """Return the number of wanted aliens of each column after each pass, int64 (S, 6).

        The first passes are dropped, see BURN_IN.
        """
        draws = []
        for _ in range(n_passes):
            self.sample(rng)
            draws.append(self._wanted.copy())
        return np.array(draws[int(BURN_IN * n_passes) :], np.int64)


def _counted(hits: Sequence[Hits], order: Array) -> tuple[Array, Array]:
    """Return each game's gain by each alien if it is wanted, and loss if not, (n, 36) each."""
    cleared = np.reshape([game.gone for game in hits], (-1, N_ALIENS)).astype(float)
    swept = np.reshape([game.swept for game in hits], (-1, N_ALIENS)).astype(float)
    return (1.0 - order) * cleared + order * swept, cleared


def _by_column(values: Array) -> Array:
    """Return values of aliens, float64 (P, 36), by column, pair and row, (6, P, 6)."""
    return values.reshape(-1, ROWS, COLUMNS).transpose(2, 0, 1)


def _probability(differences: Array) -> Array:
    """Return the probability of ranking pairs as they are, by how much more the better is worth."""
    probability: Array = MISTAKES + (1.0 - 2.0 * MISTAKES) / (1.0 + np.exp(-differences))
    return probability


def best_games(tiers: Sequence[Sequence[int]], perfect: Collection[int]) -> list[int]:
    """Return the games that are meant as all of the behaviour.

    They are the perfect demonstrations and the best ranked games, unless the first tier says
    little, being more than a quarter both of the games and of the tiers; without perfect
    demonstrations they are the best ranked games.

    Args:
        tiers: Ranked games, best tier first.
        perfect: The perfect demonstrations.
    """
    ranked = best_ranked(tiers)
    n_games = sum(len(tier) for tier in tiers)
    if perfect and min(len(ranked) / n_games, 1 / len(tiers)) > BEST_SHARE:
        ranked = []
    return sorted({*ranked, *perfect})


def labels_of_draws(draws: npt.NDArray[np.int64]) -> Array:
    """Return the labels of draws, float64 (S, 36), -1 or 1, of how many are wanted, (S, 6)."""
    labels: Array = LABELS[draws].transpose(0, 2, 1).reshape(len(draws), N_ALIENS)
    return labels


def worth(labels: Array, order: Array, hits: Sequence[Hits]) -> Array:
    """Return the worth of games by each draw's labels, float64 (S, n).

    Args:
        labels: float64 (S, 36).
        order: See learned_order.
        hits: Hits of n games.
    """
    gains, costs = _counted(hits, order)
    values: Array = (labels > 0) @ gains.T - (labels < 0) @ costs.T
    return values


def log_likelihood_by_game(worth: Array, pairs: npt.NDArray[np.int64], weights: Array) -> Array:
    """Return the log likelihood of each game's pairs in each draw, float64 (S, n).

    Args:
        worth: Worth of n games in S draws, float64 (S, n).
        pairs: Indices of the better game and the worse one, int64 (P, 2).
        weights: Weight of each pair, float64 (P,), see pair_weights.
    """
    better, worse = pairs.T
    log_likelihoods = weights * np.log(_probability(worth[:, better] - worth[:, worse]))
    games = np.arange(worth.shape[1])
    takes_part = (pairs[:, :1] == games) | (pairs[:, 1:] == games)
    of_games: Array = log_likelihoods @ takes_part
    return of_games
