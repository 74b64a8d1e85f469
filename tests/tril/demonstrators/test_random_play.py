"""Random play: what it holds, how games differ, and that recordings replay."""

from __future__ import annotations

from itertools import groupby, islice

import numpy as np
import pytest

from testsupport.space_invaders import EVALUATION_STARTS
from tril.demonstrators.random_play import HOLD_STEPS, play_randomly, random_actions
from tril.games.base import Console
from tril.games.space_invaders import SPACE_INVADERS
from tril.games.space_invaders.memory import MAX_FRAMES, Action
from tril.recording import verify


@pytest.fixture(scope="module")
def console() -> Console:
    return SPACE_INVADERS.make_console()


def test_a_game_is_played_to_its_end_and_replays(console: Console) -> None:
    game = play_randomly(np.random.default_rng(3), console)
    assert game.replay.end is not None
    assert 0 < game.recording.n_frames <= MAX_FRAMES
    assert verify(game.recording, console=console) == game
    assert game.n_cut == 0


def test_the_same_seed_gives_the_same_game_and_another_one_another(console: Console) -> None:
    first, again, other = (
        play_randomly(np.random.default_rng(seed), console) for seed in (1, 1, 2)
    )
    assert first == again
    assert first.recording.actions != other.recording.actions


def test_no_game_begins_at_an_evaluation_start(console: Console) -> None:
    starts = {play_randomly(np.random.default_rng(n), console).recording.start for n in range(8)}
    assert len(starts) > 4
    assert starts.isdisjoint(EVALUATION_STARTS)


def test_actions_are_held_for_longer_in_some_games_than_in_others() -> None:
    means = []
    for seed in range(60):
        steps = list(islice(random_actions(np.random.default_rng(seed), 6), 3000))
        assert set(steps) <= set(range(len(Action)))
        means.append(3000 / sum(1 for _ in groupby(steps)))
    # An action that is drawn twice in a row is held for longer than it was drawn for.
    assert min(means) < 2 * HOLD_STEPS[0]
    assert max(means) > HOLD_STEPS[1] / 2


def test_which_actions_are_likely_changes_during_a_game() -> None:
    steps = np.array(list(islice(random_actions(np.random.default_rng(0), 6), 6000)))
    shares = [np.bincount(part, minlength=len(Action)) / 300 for part in steps.reshape(20, 300)]
    assert np.ptp(shares, axis=0).max() > 0.4
