import numpy as np
import pytest

from tests.tril.conftest import random_actions
from tril.games.atari.starts import AtariStart
from tril.games.base import Console
from tril.games.space_invaders import SPACE_INVADERS
from tril.games.space_invaders.ends import Ending, EndReason
from tril.play.agent import AgentGame, StickyActions
from tril.play.episode import EpisodeEnded
from tril.play.saved_game import pack_game, unpack_game


def test_a_step_is_four_frames_of_one_action(console: Console) -> None:
    game = AgentGame(console)
    game.reset(AtariStart(5))
    game.step(2)
    game.step(4)
    assert game.episode.actions == bytes([2, 2, 2, 2, 4, 4, 4, 4])
    assert game.steps == 2


def test_a_game_lasts_at_most_300_steps(console: Console) -> None:
    # Nobody is hit in the first 200 frames.
    game = AgentGame(console, max_frames=200)
    game.reset(AtariStart(5))
    while game.end is None:
        game.step(0)
    assert (game.end, game.steps, game.episode.frame) == (EndReason.STEPS, 50, 200)
    with pytest.raises(EpisodeEnded):
        game.step(0)


def test_a_game_that_has_not_begun_can_not_be_stepped(console: Console) -> None:
    with pytest.raises(RuntimeError, match="call reset"):
        AgentGame(console).step(0)


def test_sticky_actions_repeat_the_action_before_about_as_often_as_told(console: Console) -> None:
    game = AgentGame(console, sticky=StickyActions(0.25, np.random.default_rng(0)))
    repeated = frames = 0
    for start in range(4):
        game.reset(AtariStart(start))
        for step in range(60):
            game.step(2 + step % 2)
            last = game.episode.actions[-4:]
            repeated += last[0] != 2 + step % 2
            frames += 1
            assert set(last) <= {0, 2, 3}
    assert 0.15 < repeated / frames < 0.35


def test_sticky_actions_are_drawn_from_the_given_generator_only(console: Console) -> None:
    def executed(seed: int) -> bytes:
        game = AgentGame(console, sticky=StickyActions(0.5, np.random.default_rng(seed)))
        game.reset(AtariStart(70))
        for action in random_actions(seed=2, frames=40, hold=1):
            game.step(action)
        return game.episode.actions

    assert executed(3) == executed(3)
    assert executed(3) != executed(4)


def test_a_probability_above_one_is_refused() -> None:
    with pytest.raises(ValueError, match="probability from 0 to 1"):
        StickyActions(1.5, np.random.default_rng(0))


@pytest.mark.parametrize("frames", [0, 120, 123])
def test_a_packed_game_goes_on_as_it_did(console: Console, frames: int) -> None:
    actions = random_actions(seed=8, frames=400, hold=3)
    game = AgentGame(console, Ending.LIFE_COUNTER)
    game.reset(AtariStart(19))
    for action in actions[:frames]:
        game.advance(action)
    packed = pack_game(game.save())
    assert unpack_game(packed, SPACE_INVADERS.make_console()).episode.actions == bytes(
        actions[:frames]
    )
    for action in actions[frames:]:
        game.advance(action)
    other = AgentGame(SPACE_INVADERS.make_console(), Ending.LIFE_COUNTER)
    other.restore(unpack_game(packed, SPACE_INVADERS.make_console()))
    for action in actions[frames:]:
        other.advance(action)
    assert other.taken == game.taken
    assert other.episode.counters["shots"] == game.episode.counters["shots"] > 0
    assert other.console.ram_bytes() == game.console.ram_bytes()
    np.testing.assert_array_equal(other.observation, game.observation)


def test_a_packed_game_of_another_version_is_refused(console: Console) -> None:
    game = AgentGame(console)
    game.reset(AtariStart(1))
    data = pack_game(game.save())
    with pytest.raises(ValueError, match="version 2, got 7"):
        unpack_game(b"\x07" + data[1:], SPACE_INVADERS.make_console())
