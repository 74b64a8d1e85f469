"""The unranked game that distinguishes statements best."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tril.vocabulary.sentences import Telling
from tril.vocabulary.understanding import Summaries, Understanding

Array = npt.NDArray[np.float64]

LEAST_APART = 0.3
"""Of the ranked games, between the places that two statements give a game that tells them apart."""


@dataclass(frozen=True)
class NextGame:
    """A game whose place would tell the likeliest statement from another one.

    Attributes:
        game: Row of the game.
        other: Place of the other statement among those that are told.
        better_than: Share of the ranked games that it is better than, by the likeliest statement.
        better_than_by_other: The same by the other statement.
    """

    game: int
    other: int
    better_than: float
    better_than_by_other: float


def next_game(
    understanding: Understanding,
    tellings: Sequence[Telling],
    ranked: Summaries,
    unranked: Summaries,
) -> NextGame | None:
    """Choose the game whose place says most of whether the likeliest statement is meant.

    That is where the places that it and another statement give the game are far apart, weighted by
    the other's probability.

    Args:
        understanding: What was inferred from the order of the ranked games.
        tellings: Its statements, the most probable first.
        ranked: Facts of the ranked games.
        unranked: Facts of the games to choose from.

    Returns:
        None if no game tells any two statements apart.
    """
    if len(tellings) < 2 or not len(unranked):
        return None
    # (n_statements, n_unranked): the share of ranked games that each is better than.
    places = np.stack(
        [
            shares_below(
                understanding.values_by(telling.statement, ranked),
                understanding.values_by(telling.statement, unranked),
            )
            for telling in tellings
        ]
    )
    apart = np.abs(places - places[0])
    probability = np.array([telling.probability for telling in tellings])
    gain = np.where(apart >= LEAST_APART, probability[:, None] * apart, 0.0)
    other, game = np.unravel_index(int(gain.argmax()), gain.shape)
    if not gain[other, game]:
        return None
    return NextGame(int(game), int(other), float(places[0, game]), float(places[other, game]))


def shares_below(values: Array, of: Array) -> Array:
    """Return the share of some values that each of others surpasses; a tie counts half.

    Args:
        values: float64 (n,).
        of: float64 (m,).
    """
    above = (of[:, None] > values).mean(1)
    shares: Array = above + 0.5 * (of[:, None] == values).mean(1)
    return shares
