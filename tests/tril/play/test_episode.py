import itertools

import pytest

from tests.tril.conftest import random_actions
from testsupport.space_invaders import ram
from tril.games.atari.console import AtariConsole
from tril.games.atari.starts import AtariStart
from tril.games.space_invaders import SPACE_INVADERS
from tril.games.space_invaders import memory as game
from tril.games.space_invaders.ends import Ending, EndReason
from tril.games.space_invaders.memory import Action
from tril.play.episode import Episode, EpisodeEnded

HIT_WHILE_IDLE = AtariStart(0)
"""A player who does not move from here is hit at frame 443."""


def play_idle(episode: Episode) -> None:
    while episode.end is None:
        episode.advance(Action.NOOP)


def test_a_hit_on_the_player_ends_the_episode_at_that_very_frame(console: AtariConsole) -> None:
    console.start(HIT_WHILE_IDLE)
    frame = 0
    while ram(console)[game.RAM_PHASE] != game.PHASE_HIT:
        console.act(Action.NOOP)
        frame += 1
    episode = Episode(console, HIT_WHILE_IDLE)
    play_idle(episode)
    assert (episode.end, episode.frame) == (EndReason.HIT, frame)
    assert frame == 443


def test_the_life_counter_ends_it_about_130_frames_later(console: AtariConsole) -> None:
    episode = Episode(console, HIT_WHILE_IDLE, Ending.LIFE_COUNTER)
    play_idle(episode)
    assert episode.end == EndReason.LIVES
    assert 128 <= episode.frame - 443 <= 131
    assert console.lives == 2


def test_an_episode_ends_after_300_steps(console: AtariConsole) -> None:
    # Nobody is hit in the first 150 frames from any start, so a short limit shows the rule.
    episode = Episode(console, AtariStart(3), max_frames=120)
    play_idle(episode)
    assert (episode.end, episode.frame) == (EndReason.STEPS, 120)
    assert Episode(console, AtariStart(3)).max_frames == 300 * 4


def test_a_hit_at_the_last_frame_is_a_hit(console: AtariConsole) -> None:
    episode = Episode(console, HIT_WHILE_IDLE, max_frames=443)
    play_idle(episode)
    assert episode.end == EndReason.HIT


def test_an_ended_episode_cannot_go_on(console: AtariConsole) -> None:
    episode = Episode(console, AtariStart(3), max_frames=1)
    episode.advance(Action.NOOP)
    with pytest.raises(EpisodeEnded, match="ended at frame 1: steps"):
        episode.advance(Action.NOOP)
    assert episode.frame == 1


@pytest.mark.parametrize("action", [-1, 6])
def test_an_action_that_does_not_exist_is_refused(console: AtariConsole, action: int) -> None:
    episode = Episode(console, AtariStart(3))
    with pytest.raises(ValueError, match="from 0 to 5"):
        episode.advance(action)
    assert episode.frame == 0


def test_held_fire_shoots_again_as_soon_as_the_missile_is_gone(console: AtariConsole) -> None:
    held = Episode(console, AtariStart(10), max_frames=300)
    in_air = []
    while held.end is None:
        held.advance(Action.FIRE)
        in_air.append(ram(console)[game.RAM_MISSILE_Y] != game.NO_MISSILE)
    launches = sum(now and not before for before, now in itertools.pairwise([False, *in_air]))
    assert held.counters["shots"] == launches >= 5


def test_an_episode_without_fire_has_no_shots_and_no_hits(console: AtariConsole) -> None:
    episode = Episode(console, AtariStart(10), max_frames=200)
    for action in [Action.LEFT, Action.RIGHT] * 100:
        episode.advance(action)
    assert (episode.counters["shots"], episode.taken) == (0, ())


def test_a_replay_of_the_actions_gives_the_same_episode(console: AtariConsole) -> None:
    first = Episode(console, AtariStart(64))
    for action in random_actions(seed=11, frames=1200, hold=9):
        if first.end is None:
            first.advance(action)
    again = Episode(SPACE_INVADERS.make_console(), AtariStart(64))
    for action in first.actions:
        again.advance(action)
    assert (again.taken, again.end, again.counters["shots"], again.frame) == (
        first.taken,
        first.end,
        first.counters["shots"],
        first.frame,
    )
    assert first.taken


def test_a_restored_episode_forgets_what_came_after(console: AtariConsole) -> None:
    episode = Episode(console, HIT_WHILE_IDLE)
    for action in random_actions(seed=12, frames=250):
        episode.advance(action)
    saved = episode.save()
    play_idle(episode)
    end, frame, hits = episode.end, episode.frame, episode.taken
    episode.restore(saved)
    assert (episode.end, episode.frame) == (None, 250)
    assert len(episode.actions) == 250
    play_idle(episode)
    assert (episode.end, episode.frame, episode.taken) == (end, frame, hits)


def test_no_frames_are_no_episode(console: AtariConsole) -> None:
    with pytest.raises(ValueError, match="at least 1 frame"):
        Episode(console, AtariStart(0), max_frames=0)
