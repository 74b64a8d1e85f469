"""Which unranked game tells statements apart."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from tril.vocabulary.facts import Vocabulary
from tril.vocabulary.next_game import NextGame, next_game, shares_below
from tril.vocabulary.posterior import Posterior, Statement
from tril.vocabulary.sentences import Telling
from tril.vocabulary.understanding import Understanding


def choose(
    words: Vocabulary,
    probabilities: Sequence[float],
    unranked: Sequence[Sequence[float]],
) -> NextGame | None:
    """Choose among games of three facts, each of which is all that one statement is about.

    Four ranked games have 1, 2, 3 and 4 of each fact.
    """
    statements = [
        Statement((0,), probability, np.array([fact]), np.ones(1))
        for fact, probability in enumerate(probabilities)
    ]
    tellings = [
        Telling(f"fact {fact}", one.probability, one.groups, (str(fact),), (), "", one)
        for fact, one in enumerate(statements)
    ]
    understanding = Understanding(words, Posterior(tuple(statements)))
    ranked = np.repeat(np.arange(1, 5, dtype=np.float32)[:, None], 3, axis=1)
    return next_game(understanding, tellings, ranked, np.array(unranked, np.float32).reshape(-1, 3))


def test_it_is_the_one_to_which_the_likeliest_statements_give_other_places(
    words: Vocabulary,
) -> None:
    alike, telling = (2.5, 2.5, 2.5), (4.5, 0.5, 2.5)
    assert choose(words, (0.6, 0.3, 0.1), [alike, telling]) == NextGame(1, 1, 1.0, 0.0)


def test_a_likelier_alternative_counts_more_than_one_that_is_further_apart(
    words: Vocabulary,
) -> None:
    # Game 0 tells the third statement entirely, game 1 the second by three quarters.
    games = [(4.5, 4.5, 0.5), (4.5, 1.5, 4.5)]
    assert choose(words, (0.6, 0.3, 0.1), games) == NextGame(1, 1, 1.0, 0.25)
    assert choose(words, (0.6, 0.05, 0.35), games) == NextGame(0, 2, 1.0, 0.0)


@pytest.mark.parametrize(
    ("probabilities", "unranked"),
    [((0.6, 0.4), [(2.5, 2.5, 0), (2.5, 3.5, 0)]), ((0.6, 0.4), []), ((1.0,), [(4, 0, 0)])],
    ids=["alike", "no game", "one statement"],
)
def test_there_is_none_where_nothing_would_tell(
    words: Vocabulary, probabilities: Sequence[float], unranked: Sequence[Sequence[float]]
) -> None:
    assert choose(words, probabilities, unranked) is None


def test_places_are_shares_of_games_that_are_worse_and_half_of_equals() -> None:
    shares = shares_below(np.array([1.0, 2.0, 2.0, 3.0]), np.array([0.0, 2.0, 9.0]))
    assert shares.tolist() == [0.0, 0.5, 1.0]
