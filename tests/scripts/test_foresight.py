"""What the emulator says would happen next."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from scripts.pretraining.foresight import HIT_WITHIN, MOVES, N_HITS, N_OUTCOMES, Lookahead
from tril.games.atari.starts import AtariStart
from tril.games.space_invaders import SPACE_INVADERS
from tril.games.space_invaders.ends import EndReason
from tril.games.space_invaders.memory import COLUMNS, FRAMES_PER_STEP, MAX_FRAMES, ROWS, Action
from tril.play.episode import Episode, EpisodeState


@pytest.fixture(scope="module")
def played() -> tuple[list[EpisodeState], Episode]:
    """The states of a game in which the cannon stands still and shoots until it is hit."""
    episode = Episode(SPACE_INVADERS.make_console(), AtariStart(40))
    states = [episode.save()]
    while episode.end is None:
        for _ in range(FRAMES_PER_STEP):
            if episode.end is None:
                episode.advance(Action.FIRE if len(states) % 2 else Action.NOOP)
        states.append(episode.save())
    return states, episode


@pytest.fixture(scope="module")
def lookahead() -> Lookahead:
    return Lookahead(SPACE_INVADERS.make_console())


def hits_of(outcomes: np.ndarray) -> np.ndarray:
    return outcomes[:N_HITS].reshape(len(MOVES), len(HIT_WITHIN))


def shots_of(outcomes: np.ndarray) -> np.ndarray:
    return outcomes[N_HITS:].reshape(len(MOVES), ROWS, COLUMNS)


def test_who_stays_where_the_game_was_lost_is_hit_as_soon(
    played: tuple[list[EpisodeState], Episode], lookahead: Lookahead
) -> None:
    states, episode = played
    assert episode.end == EndReason.HIT
    steps_left = 5
    outcomes = lookahead.outcomes(states[-1 - steps_left])
    assert outcomes.shape == (N_OUTCOMES,)
    staying = hits_of(outcomes)[0]
    assert staying.tolist() == [steps_left <= steps for steps in HIT_WITHIN]
    # A game ends within the same steps for good: who is hit within 4 is hit within 6.
    assert all(np.all(np.diff(row.astype(int)) >= 0) for row in hits_of(outcomes))


def test_a_shot_hits_the_alien_that_it_hits(
    played: tuple[list[EpisodeState], Episode], lookahead: Lookahead
) -> None:
    states, _ = played
    ready = [one for one in states if not one.readout["missile_in_air"] and one.end is None]
    for state in ready[:3]:
        other = Episode(SPACE_INVADERS.make_console(), AtariStart(0))
        other.restore(state)
        for frame in range(HIT_WITHIN[-1] * FRAMES_PER_STEP):
            if other.end is None:
                other.advance(Action.FIRE if frame < FRAMES_PER_STEP else Action.NOOP)
        new = other.taken[len(state.taken) :]
        expected = [(one.row, one.column) for one in new[:1]]
        found = shots_of(lookahead.outcomes(state))[0]
        assert np.argwhere(found).tolist() == [list(one) for one in expected]
    flying = next(one for one in states if one.readout["missile_in_air"] and one.end is None)
    assert not shots_of(lookahead.outcomes(flying)).any()


def test_looking_ahead_leaves_the_game_alone_and_knows_when_it_is_over(
    played: tuple[list[EpisodeState], Episode], lookahead: Lookahead
) -> None:
    states, episode = played
    before = episode.console.state_hash()
    over = lookahead.outcomes(states[-1])
    assert hits_of(over).all()
    assert not shots_of(over).any()
    lookahead.outcomes(states[0])
    assert episode.console.state_hash() == before


def test_the_end_of_time_is_not_foreseen(
    played: tuple[list[EpisodeState], Episode], lookahead: Lookahead
) -> None:
    state = played[0][-6]
    late = replace(state, actions=bytes(MAX_FRAMES - FRAMES_PER_STEP))
    expected = lookahead.outcomes(state)
    assert expected.any()
    assert np.array_equal(lookahead.outcomes(late), expected)
