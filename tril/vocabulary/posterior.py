"""What an order of games is about: a posterior over statements.

A statement is one group of facts, or two together, whose weighted sum orders the games: all of a
group's facts with weights of their own, or one of the sums that are its shapes. Weights have a
Gaussian prior, or half of one where they are above 0; the probability of the order is Plackett's
and Luce's (Luce 1959), with ties as in Breslow's likelihood (Breslow 1974). The evidence of a
statement is Laplace's (MacKay 1992), and values of games are averaged over statements (Hoeting et
al. 1999). Statements are fitted as batches of small Newton steps.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
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
"""Parts, the most probable first, that are tried two at a time."""
N_KEPT = 100
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
        columns: All facts of the groups, int64 (n,).
        weights: Of the facts, float64 (n,); 0 for those that its shape leaves out.
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


@dataclass(frozen=True, eq=False)
class Part:
    """What a statement weighs of one group of facts.

    Attributes:
        group: Index of the group.
        columns: The group's facts, int64 (n_facts,).
        basis: Weights of the facts by the part's own weights, float64 (n_facts, n_weights).
        values: Of games, float64 (n_games, n_weights), centred, with a deviation of about 1.
        log_prior: Log of its prior probability.
        is_positive: Whether its weight is above 0.
    """

    group: int
    columns: npt.NDArray[np.int64]
    basis: Array
    values: Array
    log_prior: float
    is_positive: bool = False

    @property
    def n_weights(self) -> int:
        """Number of its own weights."""
        return int(self.basis.shape[1])


def infer(
    parts: Sequence[Part],
    choices: Choices,
    allow: Callable[[Sequence[int]], bool] = lambda _: True,
    paired: Collection[int] = (),
) -> Posterior:
    """Infer what an order is about.

    Args:
        parts: What statements may weigh; their log priors are minus infinity where they must not.
        choices: The order.
        allow: Tells whether a statement about some groups is possible.
        paired: Groups whose most probable part is tried in pairs, however improbable it is alone.

    Raises:
        NothingPossible: No statement is allowed.
    """
    candidates = _fitted([(index,) for index in range(len(parts))], parts, choices)
    by_probability = sorted(candidates, key=lambda one: -one.log_joint)
    best = [one.parts[0] for one in by_probability[:N_PAIRED] if one.log_joint > -np.inf]
    for group in paired:
        best += [one.parts[0] for one in by_probability if parts[one.parts[0]].group == group][:1]
    pairs = [
        pair
        for pair in combinations(dict.fromkeys(best), 2)
        if parts[pair[0]].group != parts[pair[1]].group
        and allow([parts[index].group for index in pair])
    ]
    candidates = [one for one in candidates if allow([parts[one.parts[0]].group])]
    candidates += _fitted(pairs, parts, choices)
    log_joint = np.array([one.log_joint for one in candidates])
    log_total = float(np.logaddexp.reduce(log_joint)) if candidates else -np.inf
    if log_total == -np.inf:
        raise NothingPossible(NOTHING_LEFT)
    statements = []
    for index in np.argsort(-log_joint, kind="stable")[:N_KEPT].tolist():
        if log_joint[index] == -np.inf:
            break
        candidate = candidates[index]
        own = [parts[part] for part in candidate.parts]
        ends = np.cumsum([part.n_weights for part in own])[:-1]
        weights = np.split(candidate.weights, ends)
        statements.append(
            Statement(
                tuple(part.group for part in own),
                float(np.exp(log_joint[index] - log_total)),
                np.concatenate([part.columns for part in own]),
                np.concatenate([part.basis @ w for part, w in zip(own, weights, strict=True)]),
            )
        )
    return Posterior(tuple(statements))


@dataclass(frozen=True)
class _Candidate:
    """A statement before all are known: indices of its parts, its evidence by its prior."""

    parts: tuple[int, ...]
    log_joint: float
    weights: Array


def _fitted(
    keys: Sequence[tuple[int, ...]], parts: Sequence[Part], choices: Choices
) -> list[_Candidate]:
    """Fit statements about parts, those of one weight by themselves, as most have no more."""
    found: list[_Candidate] = []
    n_weights = [sum(parts[index].n_weights for index in key) for key in keys]
    narrow = [key for key, n in zip(keys, n_weights, strict=True) if n == 1]
    wide = [key for key, n in zip(keys, n_weights, strict=True) if n > 1]
    for batch in filter(None, (narrow, wide)):
        used = sorted({index for key in batch for index in key})
        ends = np.cumsum([parts[index].n_weights for index in used])
        values = np.concatenate([parts[index].values for index in used], axis=1)
        columns = {
            index: np.arange(end - parts[index].n_weights, end)
            for index, end in zip(used, ends.tolist(), strict=True)
        }
        of_keys = [np.concatenate([columns[index] for index in key]) for key in batch]
        fits = _fit(values, of_keys, choices)
        for row, key in enumerate(batch):
            own = [parts[index] for index in key]
            weights = fits.weights[row, : len(of_keys[row])]
            log_joint = float(fits.log_evidence[row]) + sum(part.log_prior for part in own)
            first = 0
            for part in own:
                if part.is_positive:
                    # Half of the Gaussian, twice as high.
                    log_joint += np.log(2) if weights[first] > 0 else -np.inf
                first += part.n_weights
            found.append(_Candidate(key, log_joint, weights))
    return found


def evidence_of_one_step(
    values: Array, choices: Choices, is_positive: npt.NDArray[np.bool_]
) -> Array:
    """Return about how much evidence there is for statements of one weight, float64 (n,).

    Laplace's approximation by a single Newton step from 0, which all take at once.

    Args:
        values: Of games, one statement a column, float64 (n_games, n).
        choices: The order.
        is_positive: Which weights are above 0, bool (n,).
    """
    values, choices = _without_unused(values, choices)
    p = choices.among / choices.among.sum(1, keepdims=True)
    expected = p @ values
    gradient = choices.weight @ (values[choices.chosen] - expected)
    curvature = choices.weight @ (p @ values**2 - expected**2)
    prior = 1 / PRIOR_SD**2
    log_evidence = 0.5 * (gradient**2 / (curvature + prior) - np.log1p(curvature / prior))
    possible: Array = np.where(is_positive & (gradient <= 0), -np.inf, log_evidence)
    return possible


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
