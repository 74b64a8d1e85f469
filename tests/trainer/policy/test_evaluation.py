"""Evaluation games on the real emulator."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest
import torch

from testsupport.space_invaders import evaluation_start
from trainer.policy.evaluation import EvaluatedGame, opening_steps, play
from trainer.reward.model import RewardModel, RewardNetwork, predicted_return
from tril.games import game_named
from tril.games.space_invaders import SPACE_INVADERS
from tril.games.space_invaders.ends import Ending, EndReason
from tril.games.space_invaders.memory import Action
from tril.play.agent import STICKY_ACTION_PROBABILITY, AgentGame
from tril.recording import Recording, trajectory, verify

STARTS = tuple(evaluation_start(number) for number in (0, 1, 2))


class _Constant:
    """Prefers one action over all others, whatever it sees."""

    def __init__(self, action: Action, share: float = 0.9) -> None:
        self._row = np.full(len(Action), (1 - share) / (len(Action) - 1), np.float32)
        self._row[action] = share

    def probabilities(self, observations: npt.NDArray[np.uint8]) -> npt.NDArray[np.float32]:
        return np.repeat(self._row[None], len(observations), axis=0)


def _model() -> RewardModel:
    torch.manual_seed(1)
    return RewardModel(RewardNetwork())


def test_greedy_games_are_recordings_that_verify_with_the_return_of_their_trajectory() -> None:
    model = _model()
    games = play(SPACE_INVADERS, _Constant(Action.FIRE), STARTS, "greedy", model=model)
    assert [game.start for game in games] == list(STARTS)
    for game in games:
        assert set(game.recording.actions) == {Action.FIRE}
        verified = verify(game.recording, [hit.cell for hit in game.taken])
        assert verified.replay.end == game.end
        assert game.taken
        expected = predicted_return(model, trajectory(game.recording).observations)
        assert game.predicted_return is not None
        np.testing.assert_allclose(game.predicted_return, expected, rtol=1e-4, atol=1e-3)


def test_games_by_the_published_ending_are_kept_to_their_end() -> None:
    model = _model()
    (game,) = play(
        SPACE_INVADERS,
        _Constant(Action.NOOP),
        STARTS[:1],
        "greedy",
        model=model,
        end_rule=Ending.LIFE_COUNTER,
    )
    assert game.end == EndReason.LIVES
    verified = verify(game.recording)
    assert (verified.n_cut, verified.replay.end) == (0, EndReason.LIVES)
    seen = trajectory(verified.recording)
    assert (seen.end, seen.n_steps) == (EndReason.LIVES, game.recording.n_steps)
    assert game.predicted_return is not None
    expected = predicted_return(model, seen.observations)
    np.testing.assert_allclose(game.predicted_return, expected, rtol=1e-4, atol=1e-3)


def _actions(games: list[EvaluatedGame]) -> list[bytes]:
    return [game.recording.actions for game in games]


def test_sampled_games_follow_their_seed_and_not_the_games_beside_them() -> None:
    actor = _Constant(Action.RIGHT, share=0.4)
    together = play(SPACE_INVADERS, actor, STARTS, "sampled", sampling_seed=4)
    assert _actions(together) == _actions(
        play(SPACE_INVADERS, actor, STARTS, "sampled", sampling_seed=4)
    )
    assert _actions(together)[1:2] == _actions(
        play(SPACE_INVADERS, actor, STARTS[1:2], "sampled", sampling_seed=4)
    )
    assert _actions(together) != _actions(
        play(SPACE_INVADERS, actor, STARTS, "sampled", sampling_seed=5)
    )
    steps = [actions[::4] for actions in _actions(together)]
    right = sum(step.count(Action.RIGHT) for step in steps) / sum(map(len, steps))
    assert 0.3 < right < 0.5


class _Turning:
    """Prefers another action at every step."""

    def __init__(self) -> None:
        self._step = 0

    def probabilities(self, observations: npt.NDArray[np.uint8]) -> npt.NDArray[np.float32]:
        self._step += 1
        action = (Action.LEFT, Action.RIGHT)[self._step % 2]
        return np.repeat(np.eye(len(Action), dtype=np.float32)[[action]], len(observations), axis=0)


def test_sticky_games_are_greedy_ones_recorded_as_executed() -> None:
    games = play(SPACE_INVADERS, _Turning(), STARTS, "sticky", sampling_seed=3)
    late = n_changes = 0
    for game in games:
        verify(game.recording, [hit.cell for hit in game.taken])
        actions = game.recording.actions
        # The first step's action has none before it that it differs from for certain.
        changes = range(4, len(actions), 4)
        chosen = [(Action.LEFT, Action.RIGHT)[(frame // 4 + 1) % 2] for frame in changes]
        late += sum(actions[f] != action for f, action in zip(changes, chosen, strict=True))
        n_changes += len(changes)
    assert abs(late / n_changes - STICKY_ACTION_PROBABILITY) < 0.06
    greedy = play(SPACE_INVADERS, _Turning(), STARTS, "greedy")
    assert {len(set(game.recording.actions[4:8])) for game in greedy} == {1}


def test_sticky_games_follow_their_start_and_not_the_games_beside_them() -> None:
    together = play(SPACE_INVADERS, _Turning(), STARTS, "sticky", sampling_seed=3)
    assert _actions(together)[2:] == _actions(
        play(SPACE_INVADERS, _Turning(), STARTS[2:], "sticky", sampling_seed=3)
    )
    assert _actions(together) != _actions(
        play(SPACE_INVADERS, _Turning(), STARTS, "sticky", sampling_seed=4)
    )
    twins = play(SPACE_INVADERS, _Turning(), (STARTS[0], STARTS[0]), "sticky", sampling_seed=3)
    assert twins[0].recording.actions != twins[1].recording.actions
    assert twins[0].recording.actions == together[0].recording.actions


def test_the_stickiness_asked_for_counts_more_than_the_action_selection() -> None:
    (game,) = play(SPACE_INVADERS, _Turning(), STARTS[:1], "sticky", sticky_action_probability=1.0)
    assert set(game.recording.actions) == {Action.NOOP}


@pytest.mark.parametrize(("name", "some_left_out"), [("gym:Blackjack-v1", True), ("pong", False)])
def test_openings_that_end_a_game_are_not_counted(name: str, some_left_out: bool) -> None:
    game = game_named(name)
    console = game.make_console()
    played = []
    for number in range(8):
        opening = game.starts.evaluation_opening(number)
        agent = AgentGame(console, max_frames=40 * game.clock.frames_per_step)
        n_steps = agent.begin(opening)
        while agent.end is None:
            agent.step(0)
        recording = Recording(game, opening.start, agent.episode.actions)
        assert opening_steps(recording, opening) == n_steps
        assert opening_steps(recording, opening.start) == 0
        played.append(n_steps == len(opening.actions))
    console.close()
    assert all(played) != some_left_out
