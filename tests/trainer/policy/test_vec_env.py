from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import pytest

from tests.trainer.samples import random_model, short_recording
from trainer.policy.evaluation import play
from trainer.policy.reward_shaping import RewardShaping
from trainer.policy.vec_env import EpisodeEnd, FinishedEpisode, TrilVecEnv
from tril.games.atari.starts import AtariStart
from tril.games.space_invaders import SPACE_INVADERS
from tril.games.space_invaders.ends import EndReason
from tril.games.space_invaders.memory import Action
from tril.play.vector.vector_game import DemonstrationLog, TrainingStarts, VectorGame
from tril.recording import Recording, trajectory

MODEL = random_model(zero=-0.5, one=0.5)


def make_env(
    kind: str = "level", starts: TrainingStarts | None = None, max_frames: int = 1200
) -> TrilVecEnv:
    games = VectorGame(
        SPACE_INVADERS,
        2,
        starts or TrainingStarts(SPACE_INVADERS),
        n_processes=1,
        max_frames=max_frames,
        training_seed=5,
    )
    return TrilVecEnv(games, RewardShaping(MODEL, kind, 5.0))


@pytest.fixture
def env() -> Iterator[TrilVecEnv]:
    made = make_env()
    yield made
    made.close()


class Rollout(NamedTuple):
    rewards: npt.NDArray[np.float32]
    episodes: list[FinishedEpisode]
    ends: list[EpisodeEnd]
    last: npt.NDArray[np.uint8]


def play_rollout(
    env: TrilVecEnv, first: npt.NDArray[np.uint8], actions: npt.NDArray[np.int64]
) -> Rollout:
    """Play actions (T, N) and judge them."""
    screens, ends = [first.copy()], []
    for step, row in enumerate(actions):
        played = env.games.step(row)
        screens.append(played.observations.copy())
        ends += [
            EpisodeEnd(step, one, played.terminal_observations[one.game].copy())
            for one in played.finished
        ]
    return Rollout(*env.judge(np.concatenate(screens), ends), ends, screens[-1])


def play_until_an_end(
    env: TrilVecEnv, action: Action, steps: int = 60
) -> tuple[npt.NDArray[np.float32], EpisodeEnd, FinishedEpisode]:
    """Play rollouts until an episode ends; return its rewards in the order of time."""
    observations = env.reset()
    assert isinstance(observations, np.ndarray)
    before: list[npt.NDArray[np.float32]] = []
    while True:
        actions = np.full((steps, 2), action)
        rewards, episodes, ends, observations = play_rollout(env, observations, actions)
        if ends:
            whole = np.concatenate([*before, rewards[: ends[0].step + 1]])
            return whole[:, ends[0].game.game], ends[0], episodes[0]
        before.append(rewards)


@pytest.mark.parametrize("kind", ["sigmoid", "level", "difference"])
def test_rewards_are_those_of_the_replayed_game_to_its_last_state(kind: str) -> None:
    env = make_env(kind)
    rewards, end, finished = play_until_an_end(env, Action.FIRE)
    env.close()
    game = finished.game
    assert game is end.game
    replayed = trajectory(Recording(SPACE_INVADERS, game.start, game.actions))
    np.testing.assert_array_equal(end.last_observation, replayed.observations[-1])
    states = MODEL.score(replayed.observations)
    expected = env.reward_shaping.shaped_return(states, game.died)
    assert rewards.sum() == pytest.approx(expected, rel=1e-3, abs=1e-3)
    assert finished.shaped_return == pytest.approx(float(rewards.sum()), rel=1e-5)
    assert finished.predicted_return == pytest.approx(float(states[1:].sum()), rel=1e-3)
    assert finished.n_steps == replayed.n_steps == len(rewards)
    assert finished.n_steps > 60, "The episode goes on from one rollout to the next."
    assert finished.died == (game.end == EndReason.HIT)
    assert not end.is_truncated


def test_episodes_that_end_in_one_rollout_are_counted_one_by_one() -> None:
    env = make_env("difference", max_frames=40)
    first = env.reset()
    assert isinstance(first, np.ndarray)
    rewards, episodes, ends, _ = play_rollout(env, first, np.full((25, 2), Action.NOOP))
    assert [end.step for end in ends] == [9, 9, 19, 19]
    assert [episode.n_steps for episode in episodes] == [10] * 4
    for end, episode in zip(ends, episodes, strict=True):
        own = rewards[end.step - 9 : end.step + 1, end.game.game]
        assert episode.shaped_return == pytest.approx(float(own.sum()), rel=1e-5)
        last = MODEL.score(end.last_observation[None])
        beginning = env.reward_shaping.model.level(last) - own.sum()
        # What it gained is what lies between its own first and last state.
        replayed = trajectory(Recording(SPACE_INVADERS, end.game.start, end.game.actions))
        level = MODEL.level(MODEL.score(replayed.observations[:1]))
        assert float(beginning[0]) == pytest.approx(float(level[0]), abs=1e-4)
    env.close()


def test_a_game_that_runs_out_of_time_is_truncated_and_nothing_is_deducted() -> None:
    env = make_env(max_frames=40)
    rewards, end, finished = play_until_an_end(env, Action.NOOP)
    env.close()
    assert end.is_truncated
    assert not finished.died
    assert len(rewards) == 10


def test_games_begun_in_a_demonstration_are_not_whole() -> None:
    recording = short_recording()
    log = DemonstrationLog(SPACE_INVADERS, recording.start, recording.actions)
    env = make_env(
        starts=TrainingStarts(SPACE_INVADERS, demonstrations=(log,), demonstration_share=1.0)
    )
    _, _, finished = play_until_an_end(env, Action.NOOP)
    env.close()
    assert finished.is_whole == (finished.game.first_step == 0)
    assert (
        finished.game.actions[: 4 * finished.game.first_step]
        == (recording.actions[: 4 * finished.game.first_step])
    )


def test_a_restored_env_goes_on_as_the_first_one(env: TrilVecEnv) -> None:
    rng = np.random.default_rng(0)
    actions = rng.integers(0, 6, (300, 2))
    first = env.reset()
    assert isinstance(first, np.ndarray)
    last = play_rollout(env, first, actions[:20]).last
    saved = {name: array.copy() for name, array in env.save().items()}
    expected = play_rollout(env, last, actions[20:])
    assert expected.ends
    other = make_env()
    restored = other.restore(saved)
    np.testing.assert_array_equal(restored, last)
    found = play_rollout(other, restored, actions[20:])
    np.testing.assert_array_equal(found.rewards, expected.rewards)
    assert found.episodes == expected.episodes
    other.close()


def test_evaluation_scores_the_same_states(env: TrilVecEnv) -> None:
    class Fires:
        def probabilities(self, observations: Any) -> Any:
            return np.eye(6, dtype=np.float32)[np.full(len(observations), Action.FIRE)]

    [game] = play(SPACE_INVADERS, Fires(), [AtariStart(50)], "greedy", model=MODEL, n_processes=1)
    states = MODEL.score(trajectory(game.recording).observations)
    assert game.rewards is not None
    np.testing.assert_allclose(game.rewards, states, rtol=1e-3, atol=1e-4)
