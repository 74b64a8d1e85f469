from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from stable_baselines3 import PPO

from tests.trainer.samples import random_model, short_recording
from trainer.policy.evaluation import play
from trainer.policy.reward_shaping import RewardShaping
from trainer.policy.vec_env import FinishedEpisode, TrilVecEnv
from tril.game.episode import EndReason
from tril.game.space_invaders import Action
from tril.game.starts import Start
from tril.game.vector.vector_game import DemonstrationLog, TrainingStarts, VectorGame
from tril.recording import Recording, trajectory

MODEL = random_model(zero=-0.5, one=0.5)


def make_env(
    kind: str = "level", starts: TrainingStarts | None = None, max_frames: int = 1200
) -> TrilVecEnv:
    games = VectorGame(
        2, starts or TrainingStarts(), n_processes=1, max_frames=max_frames, training_seed=5
    )
    return TrilVecEnv(games, RewardShaping(MODEL, kind, 5.0))


@pytest.fixture
def env() -> Iterator[TrilVecEnv]:
    made = make_env()
    yield made
    made.close()


def play_until_an_end(env: TrilVecEnv, action: Action) -> tuple[list[Any], dict[str, Any], int]:
    env.reset()
    rewards = []
    while True:
        _, shaped, ended, infos = env.step(np.full(2, action))
        rewards.append(shaped.copy())
        if ended.any():
            index = int(np.flatnonzero(ended)[0])
            return [row[index] for row in rewards], infos[index], index


@pytest.mark.parametrize("kind", ["sigmoid", "level", "difference"])
def test_rewards_are_those_of_the_replayed_game_to_its_last_state(kind: str) -> None:
    env = make_env(kind)
    rewards, info, _ = play_until_an_end(env, Action.FIRE)
    env.close()
    finished: FinishedEpisode = info["finished"]
    game = finished.game
    replayed = trajectory(Recording(game.start, game.actions))
    np.testing.assert_array_equal(info["terminal_observation"], replayed.observations[-1])
    states = MODEL.score(replayed.observations)
    expected = env.reward_shaping.shaped_return(states, game.end)
    assert sum(rewards) == pytest.approx(expected, rel=1e-3, abs=1e-3)
    assert finished.shaped_return == pytest.approx(sum(rewards), rel=1e-5)
    assert finished.predicted_return == pytest.approx(float(states[1:].sum()), rel=1e-3)
    assert finished.n_steps == replayed.n_steps == len(rewards)
    assert finished.died == (game.end is EndReason.HIT)
    assert not info["TimeLimit.truncated"]
    assert info["episode"] == {"r": finished.shaped_return, "l": finished.n_steps}


def test_a_game_that_runs_out_of_time_is_truncated_and_nothing_is_deducted() -> None:
    env = make_env(max_frames=40)
    rewards, info, _ = play_until_an_end(env, Action.NOOP)
    env.close()
    assert info["TimeLimit.truncated"]
    assert not info["finished"].died
    assert len(rewards) == 10


def test_games_begun_in_a_demonstration_are_not_whole() -> None:
    recording = short_recording()
    log = DemonstrationLog(recording.start, recording.actions)
    env = make_env(starts=TrainingStarts(demonstrations=(log,), demonstration_share=1.0))
    _, info, _ = play_until_an_end(env, Action.NOOP)
    env.close()
    finished = info["finished"]
    assert finished.is_whole == (finished.game.first_step == 0)
    assert (
        finished.game.actions[: 4 * finished.game.first_step]
        == (recording.actions[: 4 * finished.game.first_step])
    )


def test_a_restored_env_goes_on_as_the_first_one(env: TrilVecEnv) -> None:
    rng = np.random.default_rng(0)
    actions = rng.integers(0, 6, (30, 2))
    env.reset()
    for row in actions[:10]:
        env.step(row)
    saved = {name: array.copy() for name, array in env.save().items()}
    expected = [env.step(row) for row in actions[10:]]
    kept = [(rewards, ended) for _, rewards, ended, _ in expected]
    other = make_env()
    other.restore(saved)
    for row, (rewards, ended) in zip(actions[10:], kept, strict=True):
        _, other_rewards, other_ended, _ = other.step(row)
        np.testing.assert_array_equal(other_rewards, rewards)
        np.testing.assert_array_equal(other_ended, ended)
    other.close()


def test_plain_stable_baselines3_trains_on_it(env: TrilVecEnv) -> None:
    model = PPO("CnnPolicy", env, n_steps=8, batch_size=8, n_epochs=1, device="cpu", seed=1)
    model.learn(16)
    assert model.num_timesteps == 16


def test_evaluation_scores_the_same_states(env: TrilVecEnv) -> None:
    class Fires:
        def probabilities(self, observations: Any) -> Any:
            return np.eye(6, dtype=np.float32)[np.full(len(observations), Action.FIRE)]

    [game] = play(Fires(), [Start(50)], "greedy", model=MODEL, n_processes=1)
    states = MODEL.score(trajectory(game.recording).observations)
    assert game.rewards is not None
    np.testing.assert_allclose(game.rewards, states, rtol=1e-3, atol=1e-4)
