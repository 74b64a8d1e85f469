"""Which moments of ranked games show a statement."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.tril.vocabulary.test_facts import STEERED, played
from tril.demonstrators import play_randomly
from tril.games import game_named
from tril.games.base import Clock
from tril.games.settings import GameSettings
from tril.games.space_invaders import SPACE_INVADERS
from tril.vocabulary.facts import Vocabulary
from tril.vocabulary.moments import (
    MOMENT_S,
    Moment,
    contrast,
    seconds_of,
    steps_per_second,
)
from tril.vocabulary.posterior import Tiers
from tril.vocabulary.sentences import tell
from tril.vocabulary.understanding import understand
from tril.vocabulary.watched import Watched, things_of

N_SECONDS = 12


def values(*peaks: tuple[int, float]) -> list[np.ndarray]:
    """Return a game for each peak: a statement holds for five seconds from one on, else by 0."""
    games = []
    for second, height in peaks:
        game = np.zeros(N_SECONDS)
        game[second : second + MOMENT_S] = height
        games.append(game)
    return games


def test_moments_are_of_the_best_game_where_it_holds_most_and_of_a_bad_one_where_least() -> None:
    games = values((3, 0.5), (7, 0.9), (2, 2.0), (0, -0.7))
    found = contrast(games, [[0], [1], [2, 3]])
    assert found is not None
    # Game 2 has more of it than any, but is not among the better half.
    assert found.most == Moment(1, 7, MOMENT_S)
    assert found.least == Moment(3, 0, MOMENT_S)


def test_of_equal_moments_those_of_the_best_and_the_worst_game_are_shown() -> None:
    found = contrast(values((3, 1.0), (5, 1.0), (4, 1.0), (6, 1.0)), [[2], [0], [1], [3]])
    assert found is not None
    assert (found.most.game, found.least.game) == (2, 3)


def test_where_the_halves_do_not_differ_so_all_games_are_looked_at() -> None:
    low, high = np.zeros(N_SECONDS), np.ones(N_SECONDS)
    found = contrast([low, high], [[0], [1]])
    assert found is not None
    assert (found.most.game, found.least.game) == (1, 0)


@pytest.mark.parametrize("tiers", [[[0], [1]], [[1, 0]], []])
def test_what_never_differs_has_no_moments(tiers: Tiers) -> None:
    assert contrast([np.ones(N_SECONDS), np.ones(N_SECONDS)], tiers) is None


def test_games_that_are_not_ranked_or_too_short_for_a_second_are_passed_over() -> None:
    games = [*values((3, 9.0), (1, 1.0)), np.zeros(0), np.zeros(3)]
    found = contrast(games, [[1], [2], [3]])
    assert found is not None
    assert found.most == Moment(1, 1, MOMENT_S)
    # A game that is shorter than a moment is shown whole.
    assert found.least == Moment(3, 0, 3)


def test_a_moment_is_of_a_recording_by_its_frames() -> None:
    shown = Moment(1, 2, 5).shown([7, 9], SPACE_INVADERS.clock)
    assert (shown.recording_id, shown.first_frame, shown.n_frames) == (9, 120, 300)
    slow = Clock(frame_rate_hz=30, frames_per_step=1)
    assert Moment(0, 2, 5).shown([7], slow).first_frame == 60


def test_seconds_are_means_and_what_counts_no_more_is_left_out() -> None:
    clock = replace(SPACE_INVADERS.clock, max_steps=40)
    per_second = steps_per_second(clock)
    assert per_second == 15
    facts = np.zeros((50, 2), np.float32)
    facts[:15, 0], facts[15:20, 1] = 1, 0.5
    assert seconds_of(facts, clock).tolist() == [[1, 0], [0, pytest.approx(1 / 6, abs=1e-3)]]


def test_what_is_steered_is_further_to_the_left_in_the_moment_of_the_better_game(
    words: Vocabulary,
) -> None:
    games = [played(100 + place, centre=18.0 * place + 12) for place in range(8)]
    summaries = np.stack([words.summary(words.facts(one)) for one in games])
    tiers = [[place] for place in range(8)]
    understood = understand(words, summaries, tiers)
    told = tell(words, understood.posterior, game_named("pong"))
    clock = SPACE_INVADERS.clock
    seconds = [seconds_of(words.facts(one), clock) for one in games]
    found = understood.contrast(told[0].statement, seconds, tiers)
    assert found is not None

    def mean_x(moment: Moment) -> float:
        blobs = games[moment.game].blobs
        begin = moment.second * steps_per_second(clock)
        end = begin + moment.n_seconds * steps_per_second(clock)
        shown = (blobs["step"] >= begin) & (blobs["step"] < end) & (blobs["colour"] == STEERED)
        return float(blobs["x"][shown].mean())

    assert mean_x(found.most) < mean_x(found.least) - 50


def test_things_of_a_step_have_their_kinds_and_boxes(words: Vocabulary) -> None:
    game = played(3)
    things = things_of(game, words)
    assert len(things) == 2 * game.n_steps
    at_seven = {int(one["kind"]): one for one in things[things["step"] == 7]}
    assert set(at_seven) == {0, 1}
    assert words.player is not None
    steered = at_seven[words.player]
    assert (steered["width"], steered["height"], steered["top"]) == (8, 6, 178)
    assert steered["left"] == pytest.approx(game.blobs["x"][14] - 3.5, abs=0.51)


def test_a_watched_game_is_read_as_it_was_packed(words: Vocabulary) -> None:
    console = game_named("pong").with_settings(GameSettings(max_steps=60)).make_console()
    recording = play_randomly(np.random.default_rng(1), console).recording
    watched = Watched.of(recording, console, words)
    console.close()
    again = Watched.unpack(watched.pack())
    assert np.array_equal(again.summary, watched.summary)
    assert again.seconds.shape == (4, words.n_facts)
    assert np.array_equal(again.seconds, watched.seconds)
    assert again.things(10).tolist() == watched.things(10).tolist()
    assert not len(again.things(61))
    assert not len(again.without_things().things(10))
