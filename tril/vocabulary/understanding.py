"""What an order of games is about, in the terms of a game's vocabulary."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from tril.errors import Invalid
from tril.vocabulary.answers import Answer, Conditions
from tril.vocabulary.facts import Vocabulary
from tril.vocabulary.moments import Contrast, Seconds, contrast
from tril.vocabulary.posterior import (
    NOTHING_LEFT,
    Choices,
    Evidence,
    NothingPossible,
    Posterior,
    Statement,
    Tiers,
    infer,
)

Array = npt.NDArray[np.float64]
N_SHUFFLES = 19
"""Shuffled orders that an order is compared with: one drawn blindly surpasses all of them in 5%."""
MOST_AS_GOOD = 5
"""Shuffled orders that may be explained as well; see docs/decisions/26-statements.md."""

Summaries = npt.NDArray[np.float32]
"""Facts of games, float32 (n_games, n_facts), as `Vocabulary.summary` returns them."""

BEST_EFFORT_WEIGHT = 0.25
"""How much it counts that a best effort is preferred to a varied game: people mean more than what
makes their games differ from random play."""
N_COMPARED = 20
"""Varied games that the best efforts are compared with."""


@dataclass(frozen=True)
class Understanding:
    """What an order is about.

    Attributes:
        words: The vocabulary.
        posterior: What was inferred.
        spread: What each fact was divided by, float64 (n_facts,).
        meant: Subjects that a person said they mean.
    """

    words: Vocabulary
    posterior: Posterior
    spread: Array
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
        scaled: Array = rows / self.spread
        return scaled

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
        columns = statement.columns
        values: Array = facts[:, columns] @ (statement.weights / self.spread[columns])
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
    conditions, best_choices = games.conditions, games.best_choices(BEST_EFFORT_WEIGHT)
    choices = games.choices(tiers)
    posterior = infer(
        games.values,
        words.columns,
        conditions.log_prior(words),
        choices if best_choices is None else choices + best_choices,
        conditions.allow,
        conditions.groups,
    )
    roots = [group.prior_root for group in words.groups]
    statements = tuple(_coloured(one, roots) for one in posterior.statements)
    return Understanding(
        words, replace(posterior, statements=statements), words.spread(summaries), conditions.meant
    )


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

    evidence = Evidence(games.values, words.columns, log_prior, games.best_choices(1.0))
    reached = evidence.log_evidence(games.choices(tiers))
    # The same games in the same order always give the same number.
    rng = np.random.default_rng(len(tiers))
    ranked = [game for tier in tiers for game in tier]
    ends = np.cumsum([len(tier) for tier in tiers])
    n_as_good = 0
    for _ in range(N_SHUFFLES):
        shuffled = [tier.tolist() for tier in np.split(rng.permutation(ranked), ends[:-1])]
        n_as_good += evidence.log_evidence(games.choices(shuffled)) >= reached
    return n_as_good


@dataclass(frozen=True)
class _Games:
    """Games as statements see them.

    Attributes:
        values: Standardised and whitened facts, float64 (n_games + n_varied, n_facts); the varied
            games come last.
        n_games: Number of a person's games.
        best: Rows of the best efforts.
        conditions: What the answers leave possible.
    """

    values: Array
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
        games = np.concatenate([summaries, words.pool[:N_COMPARED]]).astype(np.float64)
        values = (games - games.mean(0)) / words.spread(summaries)
        whitened = np.concatenate(
            [
                values[:, columns] @ group.prior_root
                for columns, group in zip(words.columns, words.groups, strict=True)
            ],
            1,
        )
        return cls(whitened, len(summaries), best, Conditions.of(words, answers))

    def choices(self, tiers: Tiers) -> Choices:
        """Return the choices of an order."""
        if len(tiers) < 2:
            raise Invalid("Expected at least two tiers: rank one game above another.")
        return Choices.of_tiers(tiers, len(self.values))

    def best_choices(self, weight: float) -> Choices | None:
        """Return the choices of the best efforts against varied games; None without any."""
        if not len(self.best):
            return None
        n_rows = len(self.values)
        tiers = [list(self.best), list(range(self.n_games, n_rows))]
        return Choices.of_tiers(tiers, n_rows, weight)


def _coloured(statement: Statement, roots: Sequence[Array]) -> Statement:
    """Return a statement whose weights are of the facts, from one of whitened facts."""
    parts: list[Array] = []
    begin = 0
    for group in statement.groups:
        root = roots[group]
        parts.append(root @ statement.weights[begin : begin + len(root)])
        begin += len(root)
    return replace(statement, weights=np.concatenate(parts))
