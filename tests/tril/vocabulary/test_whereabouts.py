"""How far apart games are in where things are and when."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.tril.vocabulary.test_facts import HORIZON, played
from tril.games.base import Clock
from tril.vocabulary.facts import Vocabulary
from tril.vocabulary.moments import seconds_of
from tril.vocabulary.whereabouts import place_columns, share_elsewhere

X, Y = np.arange(3), np.arange(3, 5)


def game(*bins: int, y: int = 0) -> np.ndarray:
    """Return a game that is in one bin of x in each second, and in one of y all the time."""
    seconds = np.zeros((len(bins), 5), np.float16)
    seconds[np.arange(len(bins)), list(bins)] = 1
    seconds[:, 3 + y] = 1
    return seconds


@pytest.mark.parametrize(
    ("other", "share"),
    [
        (game(0, 1, 2, 2), 0.0),
        (game(0, 1, 2, 0), 1 / 8),
        (game(2, 2, 0, 0), 4 / 8),
        (game(2, 2, 0, 0, y=1), 1.0),
        # The same places at other times.
        (game(2, 0, 1, 2), 3 / 8),
        # What one game alone has does not count.
        (game(0, 1), 0.0),
        (game(), 0.0),
    ],
)
def test_games_are_elsewhere_in_the_seconds_that_both_have(other: np.ndarray, share: float) -> None:
    one = game(0, 1, 2, 2)
    assert share_elsewhere(one, other, [X, Y]) == pytest.approx(share)
    assert share_elsewhere(other, one, [X, Y]) == pytest.approx(share)


def test_a_second_is_divided_among_places_and_absence() -> None:
    half, gone = game(0), game(0)
    half[0, :3] = [0.5, 0.5, 0]
    gone[0, :3] = 0
    assert share_elsewhere(half, game(0), [X]) == pytest.approx(0.5)
    assert share_elsewhere(gone, game(0), [X]) == pytest.approx(1.0)
    assert share_elsewhere(half, gone, [X]) == pytest.approx(1.0)
    assert share_elsewhere(game(), game(), [X]) == 0.0


def test_what_is_steered_is_looked_at_or_else_all_that_moves(words: Vocabulary) -> None:
    groups = [
        words.groups[index]
        for index, columns in enumerate(words.columns)
        if any(np.array_equal(columns, found) for found in place_columns(words))
    ]
    # It moves along x alone.
    assert [(group.subject, group.aspect) for group in groups] == [((words.player,), "x")]
    assert len(place_columns(replace(words, player=None))) > len(groups)


def test_games_of_one_place_are_nearer_to_each_other_than_to_those_of_another(
    words: Vocabulary,
) -> None:
    clock = Clock(frame_rate_hz=60, frames_per_step=4, max_steps=HORIZON)
    left, again, right = (
        seconds_of(words.facts(played(seed, centre=centre)), clock)
        for seed, centre in ((1, 30.0), (2, 30.0), (3, 130.0))
    )
    columns = place_columns(words)
    assert share_elsewhere(left, again, columns) < 0.2
    assert share_elsewhere(left, right, columns) > 0.8
