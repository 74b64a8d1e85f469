"""The published sanity experiments: rankings by points and by shots."""

from __future__ import annotations

from dataclasses import replace

import pytest

from testsupport.workplace import TINY
from trainer.progress import NullProgress
from trainer.reporting.extrapolation import SkillPlan, extrapolate, spread
from trainer.reporting.skilled_games import Experiment, Extrapolation, SkilledGame, tau_of
from tril.errors import Invalid

PLAN = SkillPlan(
    checkpoints=(0, 64),
    demonstrating=1,
    games=4,
    demonstrations=3,
    parallel_games=1,
    rollout_steps=32,
)


@pytest.fixture(scope="module")
def found() -> Extrapolation:
    return extrapolate("shots", TINY, 3, NullProgress(), PLAN)


def test_the_demonstrations_are_of_the_less_skilled_players_games(found: Extrapolation) -> None:
    assert [game.checkpoint for game in found.games] == [0] * 4 + [64] * 4
    shown = found.demonstrations
    assert {game.checkpoint for game in shown} == {0}
    assert len(shown) == 3
    assert {game.true_quantity for game in shown} <= set(range(1, 80))
    assert len(found.demonstrations) + len(found.unseen) + len(found.beyond) == len(found.games)


def test_the_same_training_seed_gives_the_same_games_and_returns(found: Extrapolation) -> None:
    assert extrapolate("shots", TINY, 3, NullProgress(), PLAN) == found


def test_games_that_are_all_worth_the_same_are_refused() -> None:
    plan = replace(PLAN, games=1, demonstrations=1)
    with pytest.raises(Invalid, match="more training steps"):
        extrapolate("points", TINY, 3, NullProgress(), plan)


def test_demonstrations_are_spread_over_their_worths() -> None:
    worths = [50.0, 10.0, 30.0, 20.0, 40.0, 99.0]
    assert spread([0, 1, 2, 3, 4], worths, 3) == [1, 2, 0]
    assert sorted(spread([0, 1], worths, 3)) == [0, 1]


def test_games_beyond_the_demonstrations_are_told_apart() -> None:
    games = [
        SkilledGame(0, 5, 0.5, demonstrated=True),
        SkilledGame(0, 9, 0.9, demonstrated=True),
        SkilledGame(9, 9, 0.8, demonstrated=False),
        SkilledGame(9, 10, 0.7, demonstrated=False),
    ]
    made = Extrapolation(Experiment.of("points", TINY, 0), tuple(games))
    assert (made.unseen, made.beyond) == ((games[2],), (games[3],))
    assert tau_of(made.demonstrations) == 1.0
    assert tau_of(games[1:3]) is None
