"""A linear reward that is fitted to a ranking in milliseconds, and what it says of each game.

Bayesian linear regression from features of a game's final picture to the normal score of its place
in the ranking (Rasmussen and Williams 2006, section 2.1; Van der Waerden's scores, Conover 1999,
section 5.10). Of each ranked game it is asked without that game, by the closed form of
leave-one-out (Rasmussen and Williams 2006, section 5.4.2). A Bradley-Terry likelihood of the pairs
orders games equally well, but has no closed form
(docs/decisions/0017-a-reward-that-answers-while-you-rank.md).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from statistics import NormalDist

import numpy as np
import numpy.typing as npt

from tril.game.observation import SIZE, Observations
from tril.ranking import Ranking
from tril.recording import LEVEL_STEPS

Picture = npt.NDArray[np.uint8]
"""uint8 (84, 84), 0 to 255."""
Array = npt.NDArray[np.float64]

MIN_GAMES = 4
"""Ranked games, in at least two tiers, from which on a reward is fitted."""
MIN_GAMES_TO_CONTRADICT = 8
"""With six games, others are contradicted more often than the misplaced one."""
FALSE_CONTRADICTIONS = 0.3
"""Contradicted games to expect of a ranking whose places are as uncertain as the reward says."""

_CELLS = 14
"""Cells of a picture in either direction."""
_BANDS, _FREQUENCIES = 12, 12
_NOISE = 0.1
"""Variance that features don't explain, as a share of the ranked games' mean explained variance."""
_OFFSET = 10.0
"""Prior variance of the mean score, in the same unit: large, so that it is fitted freely."""

_NORMAL = NormalDist()


@dataclass(frozen=True)
class Opinion:
    """Where a linear reward, fitted to the other ranked games, places a game.

    Attributes:
        place: Expected share of the ranked games that are better, 0 for the best to 1.
        best_place: The better end of a central interval of 68% (one standard deviation).
        worst_place: Its worse end.
        tier: Tier of ``place``, counted from 1 for the best.
        best_tier: Tier of ``best_place``.
        worst_tier: Tier of ``worst_place``.
        p_value: Of a ranked game, the probability that the score of its place is at least as far
            from what is expected; None of others.
        contradicted_by: The one or two ranked games that end like it and speak most against its
            tier; empty unless its p-value is low and another tier expected.
    """

    place: float
    best_place: float
    worst_place: float
    tier: int
    best_tier: int
    worst_tier: int
    p_value: float | None = None
    contradicted_by: tuple[int, ...] = ()


def final_picture(observations: Observations) -> Picture:
    """Return the mean of the newest screens of a trajectory's last 25 observations, rounded.

    Args:
        observations: uint8 (N, 4, 84, 84), 0 to 255.
    """
    return np.asarray(observations[-LEVEL_STEPS:, -1].mean(0).round(), np.uint8)


def can_form_opinions(ranking: Ranking) -> bool:
    """Return whether a ranking has enough games, in more than one tier, to learn from."""
    return len(ranking.items) >= MIN_GAMES and len(ranking.tiers) >= 2


def form_opinions(ranking: Ranking, pictures: Mapping[int, Picture]) -> dict[int, Opinion]:
    """Fit a linear reward to a ranking; return what it says of ranked and further games.

    Args:
        ranking: The ranking.
        pictures: The final picture of every ranked game, and of any others.

    Returns:
        The opinion of each game; none if fewer than four are ranked, or all in one tier.
    """
    ranked = ranking.items
    if not can_form_opinions(ranking):
        return {}
    others = [item for item in pictures if item not in set(ranked)]
    fit = _Fit(ranking, np.stack([pictures[item] for item in (*ranked, *others)]))
    edges = np.cumsum([len(tier) for tier in ranking.tiers]) / len(ranked)
    opinions = {
        item: _opinion(mean, sd, edges)
        for items, levels in ((ranked, fit.left_out()), (others, fit.predicted()))
        for item, mean, sd in zip(items, *levels, strict=True)
    }
    own = ranking.tier_numbers()
    p_values, against = fit.doubts()
    for item, p_value, names in zip(ranked, p_values.tolist(), against, strict=True):
        opinion = replace(opinions[item], p_value=p_value)
        # Within a large tier any place is right.
        is_low = p_value * len(ranked) < FALSE_CONTRADICTIONS and opinion.tier != own[item]
        if is_low and len(ranked) >= MIN_GAMES_TO_CONTRADICT:
            opinion = replace(opinion, contradicted_by=tuple(ranked[index] for index in names))
        opinions[item] = opinion
    return opinions


class _Fit:
    """A fitted linear reward.

    Args:
        ranking: Of n games.
        pictures: uint8 (n + m, 84, 84), of the ranked games in order, then of m others.
    """

    def __init__(self, ranking: Ranking, pictures: Picture) -> None:
        self._tiers = np.repeat(np.arange(len(ranking.tiers)), [len(t) for t in ranking.tiers])
        self._n = n = len(self._tiers)
        features = _features(pictures, n)
        self._covariance = features @ features[:n].T + _OFFSET
        self._variance = np.square(features[n:]).sum(1) + _OFFSET + _NOISE
        # (n, n) of the ranked games' scores, but for the scale of all variances.
        self._precision = np.linalg.inv(self._covariance[:n] + _NOISE * np.eye(n))
        self._scores = _normal_scores(self._tiers)
        self._scores_without = _normal_scores_without_each(self._tiers)

    def left_out(self) -> tuple[Array, Array]:
        """Return mean and standard deviation of each ranked game's score, float64 (n,) each.

        The game itself is left out, also of the scale of the variances and of the others' scores.
        """
        diagonal = np.diag(self._precision)
        weighted = self._scores_without @ self._precision
        own = np.diag(weighted)
        # Of the others alone, by the inverse of a matrix without one row and column.
        squares = (weighted * self._scores_without).sum(1) - own**2 / diagonal
        variance = squares / (self._n - 1) / diagonal
        # Where the others are all tied, nothing is known.
        all_tied = ~self._scores_without.any(1)
        return -own / diagonal, np.sqrt(np.where(all_tied, 1.0, variance))

    def predicted(self) -> tuple[Array, Array]:
        """Return mean and standard deviation of each other game's score, float64 (m,) each."""
        covariance = self._covariance[self._n :]
        weights = covariance @ self._precision
        scale = self._scores @ self._precision @ self._scores / self._n
        variance = scale * (self._variance - (weights * covariance).sum(1))
        return weights @ self._scores, np.sqrt(variance)

    def doubts(self) -> tuple[Array, list[list[int]]]:
        """Return each ranked game's p-value, float64 (n,), and who speaks most against its score.

        The latter are the indices of at most two games.
        """
        means, sds = self.left_out()
        distances = np.abs(self._scores - means) / sds
        p_values = [math.erfc(distance / math.sqrt(2)) for distance in distances.tolist()]
        # The mean of a game left out is the weighted sum of the others' scores.
        weights = -self._precision / np.diag(self._precision)[:, None]
        np.fill_diagonal(weights, 0.0)
        side = np.sign(means - self._scores)[:, None]
        pulls = side * weights.clip(0.0) * (self._scores_without - self._scores[:, None])
        strongest = np.argsort(-pulls, axis=1)[:, :2].tolist()
        against = [[j for j in two if pulls[i, j] > 0] for i, two in enumerate(strongest)]
        return np.array(p_values), against


def _features(pictures: Picture, n_ranked: int) -> Array:
    """Return features of pictures, float64 (N, 340).

    They are the brightness of cells, and the amplitudes of the lowest frequencies along the rows
    in horizontal bands, which don't depend on how far to the side the aliens stand. Either kind is
    centred and scaled over the ranked games, and they count equally.

    Args:
        pictures: uint8 (N, 84, 84).
        n_ranked: How many of them, the first, are ranked.
    """
    n = len(pictures)
    scaled = pictures / np.float32(255)
    cells = scaled.reshape(n, _CELLS, SIZE // _CELLS, _CELLS, SIZE // _CELLS).mean((2, 4))
    # A few frequencies are faster as products than by a whole FFT.
    turns = np.outer(np.arange(SIZE), np.arange(_FREQUENCIES)) / SIZE
    phases = (2 * math.pi * turns).astype(np.float32)
    amplitudes = np.hypot(scaled @ np.cos(phases), scaled @ np.sin(phases))
    bands = amplitudes.reshape(n, _BANDS, SIZE // _BANDS, _FREQUENCIES).mean(2)
    blocks = []
    for block in (cells, bands):
        flat = np.asarray(block, np.float64).reshape(n, -1)
        flat -= flat[:n_ranked].mean(0)
        power = 2.0 * np.square(flat[:n_ranked]).sum(1).mean()
        blocks.append(flat / math.sqrt(power) if power else flat)
    return np.concatenate(blocks, axis=1)


def _normal_scores(tiers: npt.NDArray[np.int64]) -> Array:
    """Return the quantile of the normal distribution at each game's middle rank, float64 (n,).

    Args:
        tiers: int64 (n,), each game's tier, ascending from the best.
    """
    n_worse = len(tiers) - np.searchsorted(tiers, tiers, side="right")
    n_tied = np.bincount(tiers)[tiers]
    return _quantiles(len(tiers)).take(2 * n_worse + n_tied)


def _normal_scores_without_each(tiers: npt.NDArray[np.int64]) -> Array:
    """Return the normal scores of all games without the i-th in row i, whose own is 0; (n, n)."""
    n_worse = len(tiers) - np.searchsorted(tiers, tiers, side="right")
    n_tied = np.bincount(tiers)[tiers]
    left_out, other = tiers[:, None], tiers[None]
    doubled_ranks = 2 * (n_worse - (left_out > other)) + n_tied - (left_out == other)
    scores: Array = _quantiles(len(tiers) - 1).take(doubled_ranks)
    np.fill_diagonal(scores, 0.0)
    return scores


def _quantiles(n: int) -> Array:
    """Return the normal quantiles at k / 2n for k from 0 to 2n, 0 where these are infinite."""
    inner = [_NORMAL.inv_cdf(k / (2 * n)) for k in range(1, 2 * n)]
    return np.array([0.0, *inner, 0.0])


def _opinion(mean: float, sd: float, edges: Array) -> Opinion:
    """Return the opinion of a game from its score's distribution.

    Args:
        mean: Mean of the score.
        sd: Its standard deviation.
        edges: float64 (n_tiers,), share of the ranked games down to the end of each tier.
    """
    # The score of a game that is better than a share of them is the normal quantile there.
    scores = (mean / math.sqrt(1.0 + sd**2), mean + sd, mean - sd)
    place, best, worst = (1.0 - _NORMAL.cdf(score) for score in scores)
    tiers = np.minimum(np.searchsorted(edges, (place, best, worst)), len(edges) - 1) + 1
    tier, best_tier, worst_tier = tiers.tolist()
    return Opinion(place, best, worst, tier, best_tier, worst_tier)
