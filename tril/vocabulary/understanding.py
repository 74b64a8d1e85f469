"""What an order of games is about, in the terms of a game's vocabulary."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tril.errors import Invalid
from tril.vocabulary.answers import Answer, Conditions
from tril.vocabulary.facts import SPREAD_FLOOR, Vocabulary
from tril.vocabulary.moments import Contrast, Seconds, contrast
from tril.vocabulary.posterior import (
    NOTHING_LEFT,
    Choices,
    Evidence,
    NothingPossible,
    Part,
    Posterior,
    Statement,
    Tiers,
    evidence_of_one_step,
    infer,
)

Array = npt.NDArray[np.float64]
N_SHUFFLES = 19
"""Shuffled orders that an order is compared with: one drawn blindly surpasses all of them in 5%."""
MOST_AS_GOOD = 5
"""Shuffled orders that may be explained as well; see docs/decisions/26-statements.md."""

Summaries = npt.NDArray[np.float32]
"""Facts of games, float32 (n_games, n_facts), as `Vocabulary.summary` returns them."""

N_SHAPED = 300
"""Statements of one weight that are looked at closely, of thousands."""
N_COMPARED = 20
"""Varied games beside which games are standardised, and that the check prefers best efforts to."""


@dataclass(frozen=True)
class Understanding:
    """What an order is about.

    Attributes:
        words: The vocabulary.
        posterior: What was inferred.
        meant: Subjects that a person said they mean.
    """

    words: Vocabulary
    posterior: Posterior
    meant: frozenset[str] = frozenset()

    @property
    def probabilities(self) -> Array:
        """Probability of each statement, float64 (n_statements,)."""
        return np.array([one.probability for one in self.posterior.statements])

    def coefficients(self) -> Array:
        """Return each statement's coefficients of the facts, float64 (n_statements, n_facts)."""
        rows = np.zeros((len(self.posterior.statements), self.words.n_facts))
        for row, statement in zip(rows, self.posterior.statements, strict=True):
            np.add.at(row, statement.columns, statement.weights)
        return rows

    def contrast(
        self, statement: Statement, games: Sequence[Seconds], tiers: Tiers
    ) -> Contrast | None:
        """Choose two moments of the ranked games that show a statement; None if none differ.

        Args:
            statement: The statement.
            games: Facts of the games by the second.
            tiers: Rows of the ranked games, the best tier first.
        """
        return contrast([self.values_by(statement, seconds) for seconds in games], tiers)

    def values_by(self, statement: Statement, facts: npt.NDArray[np.floating]) -> Array:
        """Return the values of games, or of their seconds, by a single statement, float64 (n,).

        Args:
            statement: The statement.
            facts: Facts of each, (n, n_facts).
        """
        values: Array = facts[:, statement.columns] @ statement.weights
        return values

    def mean_coefficients(self) -> Array:
        """Return the coefficients averaged over statements, float64 (n_facts,)."""
        mean: Array = self.probabilities @ self.coefficients()
        return mean

    def value(self, summaries: Summaries) -> Array:
        """Return the value of games, float64 (n_games,)."""
        values: Array = summaries @ self.mean_coefficients()
        return values


def understand(
    words: Vocabulary,
    summaries: Summaries,
    tiers: Tiers,
    best: Sequence[int] = (),
    answers: Sequence[Answer] = (),
) -> Understanding:
    """Infer what an order of games is about.

    Args:
        words: The game's vocabulary.
        summaries: Facts of the games.
        tiers: Rows of the ranked games, the best tier first.
        best: Rows of the best efforts, ranked or not.
        answers: What a person said of statements, the latest last.

    Raises:
        Invalid: There are fewer than two tiers.
        NothingPossible: The answers exclude all statements.
    """
    games = _Games.of(words, summaries, best, answers)
    conditions, choices = games.conditions, games.choices_with_best(tiers)
    log_prior = conditions.log_prior(words)
    parts = [*games.free_parts(log_prior), *games.shaped_parts(log_prior, choices)]
    posterior = infer(parts, choices, conditions.allow, conditions.groups)
    return Understanding(words, posterior, conditions.meant)


def shuffles_as_good(
    words: Vocabulary,
    summaries: Summaries,
    tiers: Tiers,
    best: Sequence[int] = (),
    answers: Sequence[Answer] = (),
) -> int:
    """Return how many of ``N_SHUFFLES`` shuffled orders are explained as well as an order.

    A permutation test (Fisher 1935) of the evidence: of orders drawn blindly one in twenty
    surpasses all shuffled ones, whatever the games are like. The evidence alone does not tell, as
    games that are alike in many ways, such as in how long they last, make many orders probable.
    The statistic is the sum of three log evidences, each standardised over the orders: of the order
    alone, of the order given that the best efforts are preferred to varied games, and of statements
    with one weight, where best efforts count as in ``understand``; see
    docs/decisions/26-statements.md.

    Args:
        words: As in ``understand``.
        summaries: As in ``understand``.
        tiers: As in ``understand``.
        best: As in ``understand``; they stay the best efforts of shuffled orders.
        answers: As in ``understand``.

    Raises:
        Invalid: There are fewer than two tiers.
        NothingPossible: The answers exclude all statements.
    """
    games = _Games.of(words, summaries, best, answers)
    log_prior = games.conditions.log_prior(words)
    if games.conditions.groups:
        others = np.setdiff1d(np.arange(len(log_prior)), games.conditions.groups)
        log_prior[others] = -np.inf
    if not (log_prior > -np.inf).any():
        raise NothingPossible(NOTHING_LEFT)

    shaped = games.shaped(log_prior)
    # Without best efforts the two are equal.
    free = [
        Evidence(games.values, words.columns, log_prior, known)
        for known in (None, games.best_to_varied())
    ]

    def log_evidences(order: Tiers) -> list[float]:
        choices = games.choices(order)
        one_weight = float(np.logaddexp.reduce(shaped.log_joint(games.choices_with_best(order))))
        return [*(one.log_evidence(choices) for one in free), one_weight]

    # The same games in the same order always give the same number.
    rng = np.random.default_rng(len(tiers))
    ranked = [game for tier in tiers for game in tier]
    ends = np.cumsum([len(tier) for tier in tiers])
    orders = [tiers]
    for _ in range(N_SHUFFLES):
        orders.append([tier.tolist() for tier in np.split(rng.permutation(ranked), ends[:-1])])
    reached = _standardised_sum(np.array([log_evidences(order) for order in orders]))
    return int((reached[1:] >= reached[0]).sum())


def _standardised_sum(log_evidences: Array) -> Array:
    """Return the sum of each order's kinds of log evidence, each with a standard deviation of 1.

    Args:
        log_evidences: float64 (n_orders, n_kinds); -inf, for what is impossible, counts as the
            lowest finite value.
    """
    total = np.zeros(len(log_evidences))
    for kind in log_evidences.T:
        finite = kind[np.isfinite(kind)]
        if len(finite):
            possible = np.maximum(kind, finite.min())
            total += (possible - possible.mean()) / max(float(possible.std()), 1e-9)
    return total


@dataclass(frozen=True)
class _Shaped:
    """Statements with one weight: sums of a group's facts.

    Attributes:
        values: Of the games and the varied ones, standardised, float64 (n_rows, n_shapes).
        spread: What each sum was divided by, float64 (n_shapes,).
        group: Index of each statement's group, int64 (n_shapes,).
        is_positive: Whether the weight is above 0, bool (n_shapes,).
        log_p: Log of the prior probability, float64 (n_shapes,).
    """

    values: Array
    spread: Array
    group: npt.NDArray[np.int64]
    is_positive: npt.NDArray[np.bool_]
    log_p: Array

    def log_joint(self, choices: Choices) -> Array:
        """Return the log of each one's prior times its evidence by one Newton step from 0."""
        return self.log_p + evidence_of_one_step(self.values, choices, self.is_positive)


@dataclass(frozen=True)
class _Games:
    """Games as statements see them.

    Attributes:
        words: The vocabulary.
        facts: Of the games and, last, of the varied ones, float64 (n_games + n_varied, n_facts).
        values: The same, standardised and whitened.
        spread: What each fact was divided by, float64 (n_facts,).
        n_games: Number of a person's games.
        best: Rows of the best efforts.
        conditions: What the answers leave possible.
    """

    words: Vocabulary
    facts: Array
    values: Array
    spread: Array
    n_games: int
    best: Sequence[int]
    conditions: Conditions

    @classmethod
    def of(
        cls,
        words: Vocabulary,
        summaries: Summaries,
        best: Sequence[int],
        answers: Sequence[Answer],
    ) -> _Games:
        facts = np.concatenate([summaries, words.pool[:N_COMPARED]]).astype(np.float64)
        spread = words.spread(summaries)
        standardised = (facts - facts.mean(0)) / spread
        whitened = np.concatenate(
            [
                standardised[:, columns] @ group.prior_root
                for columns, group in zip(words.columns, words.groups, strict=True)
            ],
            1,
        )
        conditions = Conditions.of(words, answers)
        return cls(words, facts, whitened, spread, len(summaries), best, conditions)

    def free_parts(self, log_prior: Array) -> list[Part]:
        """Return the parts of statements with a weight for each fact of a group.

        Args:
            log_prior: Log of the prior probability of each group.
        """
        parts: list[Part] = []
        for index, (group, columns) in enumerate(
            zip(self.words.groups, self.words.columns, strict=True)
        ):
            basis = group.prior_root / self.spread[columns, None]
            log_p = float(log_prior[index] + np.log(group.shapes.free_share))
            parts.append(Part(index, columns, basis, self.values[:, columns], log_p))
        return parts

    def shaped(self, log_prior: Array) -> _Shaped:
        """Return the statements with one weight.

        Args:
            log_prior: Log of the prior probability of each group.
        """
        shapes = [group.shapes for group in self.words.groups]
        columns = self.words.columns
        # Sums of each shape's facts, (n_pool + n_games, n_shapes).
        facts = np.concatenate([self.words.pool, self.facts[: self.n_games]])
        sums = np.concatenate(
            [facts[:, own] @ one.sums for own, one in zip(columns, shapes, strict=True)], 1
        )
        spread = np.maximum(sums.std(0), SPREAD_FLOOR)
        # Rows as in `self.facts`: the games, then the varied ones that they are compared with.
        n_compared = len(self.facts) - self.n_games
        values = np.concatenate([sums[len(self.words.pool) :], sums[:n_compared]])
        n_shapes = [len(one.shares) for one in shapes]
        group = np.repeat(np.arange(len(shapes)), n_shapes)
        return _Shaped(
            (values - values.mean(0)) / spread,
            spread,
            group,
            np.repeat([one.is_positive for one in shapes], n_shapes),
            log_prior[group] + np.log(np.concatenate([one.shares for one in shapes])),
        )

    def shaped_parts(self, log_prior: Array, choices: Choices) -> list[Part]:
        """Return the parts of statements with one weight that are worth a closer look.

        Args:
            log_prior: Log of the prior probability of each group.
            choices: The order.
        """
        found = self.shaped(log_prior)
        log_joint = found.log_joint(choices)
        shapes = [group.shapes for group in self.words.groups]
        first = np.cumsum([0, *(len(one.shares) for one in shapes)])
        parts: list[Part] = []
        for index in np.argsort(-log_joint, kind="stable")[:N_SHAPED].tolist():
            if log_joint[index] == -np.inf:
                break
            group = int(found.group[index])
            basis = shapes[group].sums[:, [index - first[group]]] / found.spread[index]
            parts.append(
                Part(
                    group,
                    self.words.columns[group],
                    basis,
                    found.values[:, [index]],
                    float(found.log_p[index]),
                    bool(found.is_positive[index]),
                )
            )
        return parts

    def choices(self, tiers: Tiers) -> Choices:
        """Return the choices of an order."""
        if len(tiers) < 2:
            raise Invalid("Expected at least two tiers: rank one game above another.")
        return Choices.of_tiers(tiers, len(self.values))

    def choices_with_best(self, tiers: Tiers) -> Choices:
        """Return the choices of an order, and of the best efforts before its worse half.

        What a ranked best effort is better than the order says already.
        """
        choices = self.choices(tiers)
        ranked = [game for tier in tiers for game in tier]
        best = [game for game in self.best if game not in ranked]
        # Whole tiers, as equals are not told apart; the last one counts however large it is.
        worse = list(tiers[-1])
        for tier in reversed(tiers[1:-1]):
            if len(worse) + len(tier) > len(ranked) // 2:
                break
            worse += tier
        if not best:
            return choices
        return choices + Choices.of_tiers([best, worse], len(self.values))

    def best_to_varied(self) -> Choices | None:
        """Return the choices of the best efforts before varied games; None without any."""
        if not len(self.best):
            return None
        n_rows = len(self.values)
        tiers = [list(self.best), list(range(self.n_games, n_rows))]
        return Choices.of_tiers(tiers, n_rows)
