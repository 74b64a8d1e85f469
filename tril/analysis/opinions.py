"""Where the other ranked games place each game, and which aliens they ask for.

Which aliens are wanted is inferred from the ranking and from the best games as in a training (see
tril.analysis.wanted_aliens), from the hits of the recordings. A game's place is where its worth
falls among the ranked games'. Each ranked game is left out when its own place is asked for: the
draws of one posterior are weighted by the inverse of the likelihood of its pairs (importance
sampling, as for leave-one-out by Gelfand, Dey and Chang 1992). Places are compared as normal scores
(Van der Waerden's, Conover 1999, section 5.10).
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from statistics import NormalDist

import numpy as np
import numpy.typing as npt

from tril.analysis.wanted_aliens import (
    Array,
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
from tril.games.space_invaders.memory import COLUMNS
from tril.ranking import Ranking

MIN_GAMES = 4
"""Fewest ranked games, in at least two tiers, that say something."""
MIN_GAMES_TO_CONTRADICT = 8
"""With six games, others are contradicted more often than the misplaced one."""
FALSE_CONTRADICTIONS = 0.3
"""Contradicted games to expect of a ranking whose places are as uncertain as is said."""

_MAX_PAIRS = 1000
"""Of more than these, so many are drawn by their weights: more take long and say little else."""
_PASSES = 150
_SEED = 0
_LEAST_DEVIATION = 0.3
"""Of a game's score."""
_NOISE_SHARE = 0.5
"""Of the others' mean squared residual, what counts as variance of a game's score."""
_SAME = 1e-9
"""Differences in worth below this are none."""
_ABOUT_SAME = 0.25
"""Differences in mean worth below this hardly matter, in aliens."""

_NORMAL = NormalDist()


@dataclass(frozen=True)
class Opinion:
    """Where the other ranked games place a game.

    Attributes:
        place: Expected share of the ranked games that are better, 0 for the best to 1.
        best_place: The better end of a central interval of 68% (one standard deviation).
        worst_place: Worse end of the interval.
        tier: Tier of ``place``, counted from 1 for the best.
        best_tier: Tier of ``best_place``.
        worst_tier: Tier of ``worst_place``.
        p_value: Of a ranked game, the probability that the score of its place is at least as far
            from what is expected; None of others.
        contradicted_by: The one or two ranked games that speak most against its tier: worth
            about no more but ranked above it, or about no less but ranked below it; empty unless
            its p-value is low and another tier expected.
    """

    place: float
    best_place: float
    worst_place: float
    tier: int
    best_tier: int
    worst_tier: int
    p_value: float | None = None
    contradicted_by: tuple[int, ...] = ()


@dataclass(frozen=True)
class Opinions:
    """What a ranking says.

    Attributes:
        of: The opinion of each game, ranked or not.
        labels: Label of each alien, float64 (36,), -1 to 1; see wanted_aliens.
        in_order: How surely each counts only once its row is swept up to it, float64 (36,).
    """

    of: dict[int, Opinion]
    labels: Array
    in_order: Array


def form_opinions(
    ranking: Ranking, hits: Mapping[int, Hits], perfect: Collection[int] = ()
) -> Opinions | None:
    """Infer the wanted aliens; return opinions of ranked and unranked games.

    Args:
        ranking: The ranking.
        hits: Hits of ranked, perfect and further games, by recording id.
        perfect: Games that are meant as all of the behaviour.

    Returns:
        None if fewer than four games are ranked, or all in one tier.
    """
    if len(ranking.items) < MIN_GAMES or len(ranking.tiers) < 2:
        return None
    ranked = ranking.items
    best = best_games(ranking.tiers, perfect)
    order = learned_order([hits[item] for item in best])
    prior = log_prior([hits[item] for item in best])
    rng = np.random.default_rng(_SEED)
    pairs, weights = _pairs(ranking, rng)
    hits_of_ranked = [hits[item] for item in ranked]
    posterior = Posterior(dict(enumerate(hits_of_ranked)), pairs.tolist(), weights, prior, order)
    draws = posterior.draws(rng, _PASSES)
    labels = labels_of_draws(draws)
    worth_of_ranked = worth(labels, order, hits_of_ranked)
    log_weights = -log_likelihood_by_game(worth_of_ranked, pairs, weights)
    for index, item in enumerate(ranked):
        if item in best:
            without = log_prior([hits[i] for i in best if i != item]) - prior
            log_weights[:, index] += without[np.arange(COLUMNS), draws].sum(1)
    judged = _Judged(ranking, worth_of_ranked, _softmax(log_weights))
    opinions = judged.opinions()
    unranked = [item for item in hits if item not in set(ranked)]
    opinions |= {
        item: judged.unranked_opinion(value)
        for item, value in zip(
            unranked, worth(labels, order, [hits[i] for i in unranked]).T, strict=True
        )
    }
    return Opinions(opinions, labels.mean(0), order)


def _pairs(ranking: Ranking, rng: np.random.Generator) -> tuple[npt.NDArray[np.int64], Array]:
    """Return pairs of ranked games in different tiers, and how much each counts.

    Returns:
        Indices of games, the better one first, int64 (P, 2), and weights, float64 (P,).
    """
    sizes = [len(tier) for tier in ranking.tiers]
    tiers = np.repeat(np.arange(len(sizes)), sizes)
    pairs = np.argwhere(tiers[:, None] < tiers)
    by_tier = [np.flatnonzero(tiers == tier).tolist() for tier in range(len(sizes))]
    weights = pair_weights(pairs.tolist(), by_tier)
    if len(pairs) <= _MAX_PAIRS:
        return pairs, weights
    total = float(weights.sum())
    pairs = rng.choice(pairs, _MAX_PAIRS, p=weights / total)
    return pairs, np.full(_MAX_PAIRS, min(1.0, total / _MAX_PAIRS))


class _Judged:
    """The ranked games' places, by draws of which aliens are wanted.

    Args:
        ranking: Ranking of n games.
        worth: Worth of each game in each draw, float64 (S, n).
        weights: Weight of each draw without each game, float64 (S, n); columns sum to 1.
    """

    def __init__(self, ranking: Ranking, worth: Array, weights: Array) -> None:
        self._ranking = ranking
        self._worth = worth
        self._n = n = worth.shape[1]
        sizes = [len(tier) for tier in ranking.tiers]
        self._edges = np.cumsum(sizes) / n
        self._scores = _normal_scores(np.repeat(np.arange(len(sizes)), sizes))
        scores = [
            self._score(np.delete(worth, index, 1), worth[:, index], weights[:, index])
            for index in range(n)
        ]
        self._means, self._variances = np.array(scores).T
        self._squares = np.square(self._scores - self._means)

    def _score(self, other_worths: Array, own_worths: Array, weights: Array) -> tuple[float, float]:
        """Return mean and variance of the score of a game among others.

        Where it is worth as much as some of them, it may be anywhere among these.

        Args:
            other_worths: Worth of the other games, float64 (S, m).
            own_worths: Worth of the game, float64 (S,).
            weights: Weights of the draws, float64 (S,).
        """
        m = other_worths.shape[1]
        difference = other_worths - own_worths[:, None]
        n_better, n_tied = (difference > _SAME).sum(1), (np.abs(difference) <= _SAME).sum(1)
        # Middles and ends of the gaps between m others, in units of half a gap.
        quantiles = _quantiles(m + 1)
        middle = -quantiles[2 * n_better + n_tied + 1]
        width = quantiles[2 * (n_better + n_tied) + 1] - quantiles[2 * n_better + 1]
        mean = float(weights @ middle)
        return mean, float(weights @ (np.square(middle - mean) + np.square(width) / 12))

    def opinions(self) -> dict[int, Opinion]:
        """Return the opinion of each ranked game."""
        noise = (self._squares.sum() - self._squares) / (self._n - 1)
        deviations = np.sqrt(self._variances + _NOISE_SHARE * noise + _LEAST_DEVIATION**2)
        tiers = self._ranking.tier_numbers()
        opinions = {}
        for index, item in enumerate(self._ranking.items):
            mean, deviation = float(self._means[index]), float(deviations[index])
            distance = abs(self._scores[index] - mean) / deviation
            p_value = math.erfc(distance / math.sqrt(2))
            opinion = replace(_opinion(mean, deviation, self._edges), p_value=p_value)
            # Within a large tier any place is right.
            is_low = p_value * self._n < FALSE_CONTRADICTIONS and opinion.tier != tiers[item]
            if is_low and self._n >= MIN_GAMES_TO_CONTRADICT:
                opinion = replace(opinion, contradicted_by=self._contradicting_games(index))
            opinions[item] = opinion
        return opinions

    def _contradicting_games(self, index: int) -> tuple[int, ...]:
        """Return the one or two games that contradict a game's tier most.

        Above a game that is ranked too low stand games of no higher worth, below one that is
        ranked too high games of no lower worth. Equal worth and distant tiers contradict most.
        """
        side = np.sign(self._means[index] - self._scores[index])
        means = self._worth.mean(0)
        ahead = side * (means[index] - means)
        pulls = np.exp(-np.abs(ahead)) * side * (self._scores - self._scores[index])
        pulls[ahead < -_ABOUT_SAME] = 0.0
        strongest = np.argsort(-pulls)[:2].tolist()
        return tuple(self._ranking.items[index] for index in strongest if pulls[index] > 0)

    def unranked_opinion(self, worth: Array) -> Opinion:
        """Return the opinion of an unranked game, given its worth, float64 (S,)."""
        even = np.full(len(worth), 1.0 / len(worth))
        mean, variance = self._score(self._worth, worth, even)
        noise = _NOISE_SHARE * float(self._squares.mean()) + _LEAST_DEVIATION**2
        return _opinion(mean, math.sqrt(variance + noise), self._edges)


def _softmax(log_weights: Array) -> Array:
    """Return weights that sum to 1 in each column."""
    weights = np.exp(log_weights - log_weights.max(0))
    weights_of_draws: Array = weights / weights.sum(0)
    return weights_of_draws


def _normal_scores(tiers: npt.NDArray[np.int64]) -> Array:
    """Return the quantile of the normal distribution at each game's middle rank, float64 (n,).

    Args:
        tiers: int64 (n,), each game's tier, ascending from the best.
    """
    n_worse = len(tiers) - np.searchsorted(tiers, tiers, side="right")
    n_tied = np.bincount(tiers)[tiers]
    return _quantiles(len(tiers)).take(2 * n_worse + n_tied)


@lru_cache
def _quantiles(n: int) -> Array:
    """Return the normal quantiles at k / 2n for k from 0 to 2n, 0 where these are infinite."""
    inner = [_NORMAL.inv_cdf(k / (2 * n)) for k in range(1, 2 * n)]
    return np.array([0.0, *inner, 0.0])


def _opinion(mean: float, sd: float, edges: Array) -> Opinion:
    """Return the opinion of a game from its score's distribution.

    Args:
        mean: Mean of the score.
        sd: Standard deviation of the score.
        edges: float64 (n_tiers,), share of the ranked games down to the end of each tier.
    """
    # The score of a game that is better than a share of them is the normal quantile there.
    scores = (mean / math.sqrt(1.0 + sd**2), mean + sd, mean - sd)
    place, best, worst = (1.0 - _NORMAL.cdf(score) for score in scores)
    tiers = np.minimum(np.searchsorted(edges, (place, best, worst)), len(edges) - 1) + 1
    tier, best_tier, worst_tier = tiers.tolist()
    return Opinion(place, best, worst, tier, best_tier, worst_tier)
