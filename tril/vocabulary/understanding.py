"""What an order of games is about, in the terms of a game's vocabulary."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from tril.errors import Invalid
from tril.vocabulary.answers import Answer, Conditions
from tril.vocabulary.facts import Vocabulary
from tril.vocabulary.posterior import Choices, Posterior, Statement, Tiers, infer

Array = npt.NDArray[np.float64]
PASSING_LOG_ODDS = 0.0
"""From which on an order is about something; see docs/decisions/26-statements.md."""

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
    if len(tiers) < 2:
        raise Invalid("Expected at least two tiers: rank one game above another.")
    pool = words.pool[:N_COMPARED]
    games = np.concatenate([summaries, pool]).astype(np.float64)
    spread = words.spread(summaries)
    values = (games - games.mean(0)) / spread
    choices = Choices.of_tiers(tiers, len(values))
    if len(best):
        varied = list(range(len(summaries), len(values)))
        choices += Choices.of_tiers([list(best), varied], len(values), BEST_EFFORT_WEIGHT)
    roots = [group.prior_root for group in words.groups]
    whitened = np.concatenate(
        [values[:, columns] @ root for columns, root in zip(words.columns, roots, strict=True)], 1
    )
    conditions = Conditions.of(words, answers)
    posterior = infer(
        whitened,
        words.columns,
        conditions.log_prior(words),
        choices,
        conditions.allow,
        conditions.groups,
    )
    statements = tuple(_coloured(one, roots) for one in posterior.statements)
    return Understanding(words, replace(posterior, statements=statements), spread, conditions.meant)


def _coloured(statement: Statement, roots: Sequence[Array]) -> Statement:
    """Return a statement whose weights are of the facts, from one of whitened facts."""
    parts: list[Array] = []
    begin = 0
    for group in statement.groups:
        root = roots[group]
        parts.append(root @ statement.weights[begin : begin + len(root)])
        begin += len(root)
    return replace(statement, weights=np.concatenate(parts))
