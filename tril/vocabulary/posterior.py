"""What an order of games is about: a posterior over statements.

A statement is one group of facts, or two together, whose weighted sum orders the games. Its weights
have a Gaussian prior; the probability of the order is Plackett's and Luce's (Luce 1959), with ties
as in Breslow's likelihood (Breslow 1974). The evidence of a statement is Laplace's (MacKay 1992),
and values of games are averaged over statements (Hoeting et al. 1999). All statements are fitted at
once, as batches of small Newton steps.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
import numpy.typing as npt

from tril.errors import Invalid

Array = npt.NDArray[np.float64]
Tiers = Sequence[Sequence[int]]
"""Rows of games in tiers, the best first."""

PRIOR_SD = 3.0
"""Standard deviation of a statement's value over games, in log odds, before any order is seen."""
N_PAIRED = 12
"""Groups, the most probable first, that are tried two at a time."""
N_KEPT = 40
"""Statements that are kept."""
MOST_NEWTON_STEPS = 12
MOST_HALVINGS = 8
TOLERANCE = 1e-4
"""Change of the weights below which a fit is done."""


NOTHING_LEFT = "Nothing is left that the order could be about: undo an answer."


class NothingPossible(Invalid):
    """No statement is allowed."""


@dataclass(frozen=True)
class Choices:
    """An order as choices: each chosen game against a set of games that holds it.

    Attributes:
        chosen: Row of the game that is chosen, int64 (n,).
        among: Which games it is chosen from, bool (n, n_games).
        weight: How much each choice counts, float64 (n,).
    """

    chosen: npt.NDArray[np.int64]
    among: npt.NDArray[np.bool_]
    weight: Array

    @classmethod
    def of_tiers(cls, tiers: Tiers, n_games: int, weight: float = 1.0) -> Choices:
        """Return the choices of an order; the last tier is chosen from nothing else.

        Args:
            tiers: Rows of games, the best tier first.
            n_games: Number of rows.
            weight: How much each choice counts.
        """
        chosen: list[int] = []
        among: list[npt.NDArray[np.bool_]] = []
        left = np.zeros(n_games, np.bool_)
        left[[game for tier in tiers for game in tier]] = True
        for tier in tiers[:-1]:
            for game in tier:
                # Not among its equals, which it was not preferred to.
                rest = left.copy()
                rest[[other for other in tier if other != game]] = False
                chosen.append(game)
                among.append(rest)
            left[list(tier)] = False
        return cls(
            np.array(chosen, np.int64),
            np.array(among, np.bool_).reshape(-1, n_games),
            np.full(len(chosen), weight),
        )

    def __add__(self, other: Choices) -> Choices:
        return Choices(
            np.concatenate([self.chosen, other.chosen]),
            np.concatenate([self.among, other.among]),
            np.concatenate([self.weight, other.weight]),
        )


@dataclass(frozen=True)
class Statement:
    """One or two groups of facts whose weighted sum orders the games.

    Attributes:
        groups: Indices of the groups.
        probability: Of the statement among all, given the order.
        columns: Its facts, int64 (n,).
        weights: Of its standardised facts, float64 (n,).
    """

    groups: tuple[int, ...]
    probability: float
    columns: npt.NDArray[np.int64]
    weights: Array


@dataclass(frozen=True)
class Posterior:
    """What an order is about.

    Attributes:
        statements: The most probable first; their probabilities add up to nearly 1.
    """

    statements: tuple[Statement, ...]


def infer(
    values: Array,
    groups: Sequence[npt.NDArray[np.int64]],
    log_prior: Array,
    choices: Choices,
    allow: Callable[[Sequence[int]], bool] = lambda _: True,
    paired: Sequence[int] = (),
) -> Posterior:
    """Infer what an order is about.

    Args:
        values: Standardised facts of each game, float64 (n_games, n_facts).
        groups: Columns of each group.
        log_prior: Log of the prior probability of each group; minus infinity where there is none.
        choices: The order.
        allow: Tells whether a statement about some groups is possible.
        paired: Groups that are tried two at a time, however improbable they are alone.

    Raises:
        NothingPossible: No statement is allowed.
    """
    keys: list[tuple[int, ...]] = [(index,) for index in range(len(groups))]
    log_p = np.asarray(log_prior, np.float64)
    fits = _fit(values, groups, choices)
    fitted = [fits.weights[index, : len(groups[index])] for index in range(len(groups))]
    singles = log_p + fits.log_evidence
    best = sorted({*np.argsort(-singles)[:N_PAIRED].tolist(), *paired})
    pairs = [pair for pair in combinations(best, 2) if allow(pair)]
    joint = [np.concatenate([groups[one], groups[other]]) for one, other in pairs]
    if pairs:
        fits = _fit(values, joint, choices)
        fitted += [fits.weights[index, : len(columns)] for index, columns in enumerate(joint)]
        keys += pairs
        of_pairs = fits.log_evidence + [log_p[one] + log_p[other] for one, other in pairs]
        log_joint = np.concatenate([singles, of_pairs])
    else:
        log_joint = singles
    log_joint = np.where([allow(key) for key in keys], log_joint, -np.inf)
    log_total = float(np.logaddexp.reduce(log_joint))
    if log_total == -np.inf:
        raise NothingPossible(NOTHING_LEFT)
    columns_of = [*groups, *joint]
    statements = tuple(
        Statement(
            keys[index],
            float(np.exp(log_joint[index] - log_total)),
            columns_of[index],
            fitted[index],
        )
        for index in np.argsort(-log_joint)[:N_KEPT].tolist()
        if log_joint[index] > -np.inf
    )
    return Posterior(statements)


class Evidence:
    """The evidence for orders of the same games, averaged over statements about a single group.

    Args:
        values: As in ``infer``.
        groups: As in ``infer``.
        log_prior: As in ``infer``.
        known: Choices that are known beside each order.
    """

    def __init__(
        self,
        values: Array,
        groups: Sequence[npt.NDArray[np.int64]],
        log_prior: Array,
        known: Choices | None = None,
    ) -> None:
        possible = np.flatnonzero(log_prior > -np.inf).tolist()
        self._values = values
        self._groups = [groups[index] for index in possible]
        self._log_prior = log_prior[possible]
        self._prior = _prior(self._groups)
        if known is not None:
            self._prior = _fit(values, self._groups, known, self._prior)
            self._log_prior = self._log_prior + self._prior.log_evidence

    def log_evidence(self, choices: Choices) -> float:
        """Return the log probability of an order, given the known choices but for a constant.

        What is known counts by Laplace's approximation, a Gaussian prior of the weights.
        """
        fits = _fit(self._values, self._groups, choices, self._prior)
        return float(np.logaddexp.reduce(self._log_prior + fits.log_evidence))


@dataclass(frozen=True)
class _Fits:
    """Weights of each group: the most probable ones, and how sure they are.

    Groups are filled up to the widest with weights that change nothing.

    Attributes:
        weights: float64 (n_groups, width).
        precision: Minus the Hessian of the log posterior there, float64 (n_groups, width, width).
        log_evidence: Log of each group's evidence, float64 (n_groups,).
    """

    weights: Array
    precision: Array
    log_evidence: Array


def _prior(groups: Sequence[npt.NDArray[np.int64]]) -> _Fits:
    width = max(len(columns) for columns in groups)
    # The sum of n standardised facts then has the prior's standard deviation.
    scale = np.array([len(columns) for columns in groups]) / PRIOR_SD**2
    return _Fits(
        np.zeros((len(groups), width)),
        scale[:, None, None] * np.eye(width),
        np.zeros(len(groups)),
    )


def _without_unused(values: Array, choices: Choices) -> tuple[Array, Choices]:
    """Leave out games that are never chosen from, which only cost time."""
    used = np.flatnonzero(choices.among.any(0))
    row = np.full(len(values), -1)
    row[used] = np.arange(len(used))
    return values[used], Choices(row[choices.chosen], choices.among[:, used], choices.weight)


def _fit(
    values: Array,
    groups: Sequence[npt.NDArray[np.int64]],
    choices: Choices,
    prior: _Fits | None = None,
) -> _Fits:
    """Fit the weights of each group to an order.

    Args:
        values: Standardised facts of each game, float64 (n_games, n_facts).
        groups: Columns of each group.
        choices: The order.
        prior: Of the weights; None for the one before anything is known.
    """
    values, choices = _without_unused(values, choices)
    prior = _prior(groups) if prior is None else prior
    width = prior.weights.shape[1]
    # (n_groups, n_games, width); columns of zeros fill up, and change nothing.
    x = np.zeros((len(groups), len(values), width))
    for index, columns in enumerate(groups):
        x[index, :, : len(columns)] = values[:, columns]
    weights = prior.weights.copy()
    value = _log_posterior(x, weights, choices, prior.weights, prior.precision)
    at_work = np.arange(len(groups))
    for _ in range(MOST_NEWTON_STEPS):
        part, own = x[at_work], (prior.weights[at_work], prior.precision[at_work])
        gradient, hessian = _derivatives(part, weights[at_work], choices, *own)
        step = np.linalg.solve(hessian, gradient[..., None])[..., 0]
        # The log posterior is concave; halving a step that overshoots always ends.
        for _ in range(MOST_HALVINGS):
            reached = _log_posterior(part, weights[at_work] + step, choices, *own)
            worse = reached < value[at_work] - 1e-9
            if not worse.any():
                break
            step[worse] /= 2
        weights[at_work] += step
        value[at_work] = _log_posterior(part, weights[at_work], choices, *own)
        at_work = at_work[np.abs(step).max(1) > TOLERANCE]
        if not len(at_work):
            break
    _, hessian = _derivatives(x, weights, choices, prior.weights, prior.precision)
    # Laplace: the volume of the posterior by that of the prior (MacKay 1992).
    volume = np.linalg.slogdet(prior.precision)[1] - np.linalg.slogdet(hessian)[1]
    return _Fits(weights, hessian, value + 0.5 * volume)


def _log_posterior(
    x: Array, weights: Array, choices: Choices, mean: Array, precision: Array
) -> Array:
    """Return the log posterior of each group's weights but for a constant, (n_groups,)."""
    score = (x @ weights[..., None])[..., 0]
    # (n_groups, n_choices, n_games)
    among = np.where(choices.among, score[:, None], -np.inf)
    top = among.max(2)
    log_sum = top + np.log(np.exp(among - top[..., None]).sum(2))
    fit: Array = (score[:, choices.chosen] - log_sum) @ choices.weight
    off = weights - mean
    fit -= 0.5 * (off * (precision @ off[..., None])[..., 0]).sum(1)
    return fit


def _derivatives(
    x: Array, weights: Array, choices: Choices, mean: Array, precision: Array
) -> tuple[Array, Array]:
    """Return the gradient, (n_groups, width), and minus the Hessian, (n_groups, width, width)."""
    score = (x @ weights[..., None])[..., 0]
    among = np.where(choices.among, score[:, None], -np.inf)
    p = np.exp(among - among.max(2, keepdims=True))
    p /= p.sum(2, keepdims=True)
    # (n_groups, n_choices, width): mean facts of the games that were chosen from.
    expected = p @ x
    gradient = ((x[:, choices.chosen] - expected) * choices.weight[:, None]).sum(1)
    # The sum over choices of the facts' covariance under p.
    weighted = (choices.weight[:, None] * p).sum(1)
    hessian = np.swapaxes(x * weighted[..., None], 1, 2) @ x
    hessian -= np.swapaxes(expected * choices.weight[:, None], 1, 2) @ expected
    gradient -= (precision @ (weights - mean)[..., None])[..., 0]
    return gradient, hessian + precision
