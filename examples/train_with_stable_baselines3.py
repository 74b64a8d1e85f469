"""Train plain stable-baselines3 on the game, without anything else of this project.

    python examples/train_with_stable_baselines3.py --steps 100000 --output agent.zip

The environment is a Gymnasium environment like any other. Its reward is the points of the aliens
shot; the hits of every episode are in its info.
"""

import argparse
from pathlib import Path

import gymnasium
import numpy as np
import numpy.typing as npt
from stable_baselines3 import PPO
from stable_baselines3.common.evaluation import evaluate_policy
from stable_baselines3.common.monitor import Monitor
from stable_baselines3.common.vec_env import DummyVecEnv

import tril.play.env

COLUMN_2 = [(row, 1) for row in range(6)]


def make_env() -> gymnasium.Env[npt.NDArray[np.uint8], np.int64]:
    """Return a monitored environment."""
    return Monitor(gymnasium.make(tril.play.env.ENV_ID, target=COLUMN_2))


def main() -> None:
    """Train, save, evaluate and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--steps", type=int, default=100_000, help="steps to train for")
    parser.add_argument("--rollout-steps", type=int, default=128, help="per game and rollout")
    parser.add_argument("--games", type=int, default=8, help="games side by side")
    parser.add_argument("--episodes", type=int, default=5, help="episodes to evaluate on")
    parser.add_argument("--seed", type=int, default=0, help="training seed")
    parser.add_argument("--output", type=Path, default=Path("agent.zip"))
    arguments = parser.parse_args()

    games = DummyVecEnv([make_env] * arguments.games)
    agent = PPO(
        "CnnPolicy",
        games,
        n_steps=arguments.rollout_steps,
        batch_size=arguments.rollout_steps * arguments.games // 4,
        n_epochs=4,
        learning_rate=3e-4,
        ent_coef=0.01,
        seed=arguments.seed,
        verbose=1,
    )
    agent.learn(arguments.steps)
    agent.save(arguments.output)
    mean, deviation = evaluate_policy(agent, make_env(), n_eval_episodes=arguments.episodes)
    print(f"{mean:.0f} points per game (standard deviation {deviation:.0f}) in {arguments.output}")


if __name__ == "__main__":
    main()
