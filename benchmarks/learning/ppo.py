"""Steps per second of PPO on the learned reward, against plain stable-baselines3.

    python -m benchmarks.learning.ppo

Both train on the same learned reward (plain PPO with one forward pass for all games per step, ours
with one for a whole rollout) with the recipe's network and hyperparameters, alternating whole
rollouts; the ratio is the median over the rounds. A third is plain PPO with the defaults for Atari
games. Plain means tril/SpaceInvaders-v0 in a SubprocVecEnv, a VecEnvWrapper that replaces the
game's reward by the learned one, and PPO as it is. Demonstration starts, warm start and KL penalty
are off, since plain PPO has none of them. Also measures how long ours plays, computes rewards and
learns, and how long the emulator, acting, rewards and learning take alone. Prints tables and a JSON
line.
"""

import argparse
import json
import statistics
import time
from collections import defaultdict
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt
import torch
from stable_baselines3 import PPO
from stable_baselines3.common.torch_layers import BaseFeaturesExtractor
from stable_baselines3.common.vec_env import SubprocVecEnv, VecEnvWrapper
from stable_baselines3.common.vec_env.base_vec_env import VecEnvObs, VecEnvStepReturn
from torch import Tensor, nn

import tril.play.env
from trainer.nn.devices import learning_device
from trainer.nn.precision import Precision
from trainer.nn.threads import one_thread
from trainer.policy.imitator import N_PARTS
from trainer.policy.networks import SIZES
from trainer.policy.ppo import ImitationPPO, TrainingGenerators
from trainer.policy.reward_shaping import RewardShaping
from trainer.policy.rollout_buffer import ScreenRolloutBuffer
from trainer.policy.vec_env import EpisodeEnd, TrilVecEnv
from trainer.reward.model import RewardModel, new_network
from tril.games.space_invaders import SPACE_INVADERS
from tril.play.vector.vector_game import TrainingStarts, VectorGame, VectorStep
from tril.recipes import RECIPES, PolicyRecipe

seconds: dict[str, float] = defaultdict(float)
"""Time spent by part, of our training."""


@contextmanager
def counted(part: str) -> Iterator[None]:
    """Add the block's time to a part."""
    begin = time.perf_counter()
    yield
    seconds[part] += time.perf_counter() - begin


@contextmanager
def kept(counts: dict[str, float]) -> Iterator[None]:
    """Restore the counts after the block, so that its time is not counted."""
    before = dict(counts)
    yield
    counts.update(before)


@dataclass(frozen=True)
class TimedModel(RewardModel):
    """A reward model whose time counts."""

    def score(self, observations: npt.NDArray[np.uint8]) -> npt.NDArray[np.float32]:
        """Return R; see RewardModel."""
        with counted("reward"):
            return super().score(observations)


class TimedGames(VectorGame):
    """Games whose time counts, as far as the caller waits for them."""

    def step_async(self, actions: npt.NDArray[Any], part: int = 0) -> None:
        """Begin a step; see VectorGame."""
        with counted("waiting"):
            super().step_async(actions, part)

    def step_wait(self, part: int = 0) -> VectorStep:
        """Finish a step; see VectorGame."""
        with counted("waiting"):
            return super().step_wait(part)


class TimedPPO(ImitationPPO):
    """PPO whose parts' time counts."""

    def _play(self, games: VectorGame, buffer: ScreenRolloutBuffer) -> list[EpisodeEnd]:
        with counted("playing"):
            return super()._play(games, buffer)

    def train(self) -> None:
        """Learn from the rollout; see ImitationPPO."""
        with counted("learning"):
            super().train()

    def measure_alone(self) -> dict[str, float]:
        """Return the seconds that the parts of a rollout take alone, one after the other."""
        env, buffer = self.env, self.rollout_buffer
        assert isinstance(env, TrilVecEnv)
        rng = np.random.default_rng(0)
        games, alone = env.games, {}
        begin = time.perf_counter()
        for _ in range(self.n_steps):
            for part, own in enumerate(games.parts):
                games.step_async(rng.integers(0, 6, len(own)), part)
            for part in range(len(games.parts)):
                games.step_wait(part)
        alone["emulator"] = time.perf_counter() - begin
        self._convolved.clear()
        begin = time.perf_counter()
        with one_thread():
            for step in range(self.n_steps):
                for own in games.parts:
                    self._act(buffer, step, own)
        alone["acting"] = time.perf_counter() - begin
        begin = time.perf_counter()
        env.judge(buffer.all_screens.numpy(), ())
        alone["reward"] = time.perf_counter() - begin
        begin = time.perf_counter()
        ImitationPPO.train(self)
        alone["learning"] = time.perf_counter() - begin
        return alone


class PlainFeatures(BaseFeaturesExtractor):
    """NatureCNN as stable-baselines3 has it, with the small network's channels."""

    def __init__(self, observation_space: gymnasium.spaces.Box, network: str) -> None:
        size = SIZES[network]
        super().__init__(observation_space, size.features)
        first, second, third = size.channels
        self.cnn = nn.Sequential(
            nn.Conv2d(4, first, 8, 4),
            nn.ReLU(),
            nn.Conv2d(first, second, 4, 2),
            nn.ReLU(),
            nn.Conv2d(second, third, 3, 1),
            nn.ReLU(),
            nn.Flatten(),
            nn.Linear(third * 49, size.features),
            nn.ReLU(),
        )

    def forward(self, observations: Tensor) -> Tensor:
        """Return features, float32 (N, features), of observations, float32 (N, 4, 84, 84)."""
        return self.cnn(observations)  # type: ignore[no-any-return]


class LearnedReward(VecEnvWrapper):
    """Replaces the game's reward by the learned one, as one would with plain means."""

    def __init__(self, venv: SubprocVecEnv, shaping: RewardShaping) -> None:
        super().__init__(venv)
        self._shaping = shaping

    def reset(self) -> VecEnvObs:
        """Begin all games."""
        return self.venv.reset()

    def step_wait(self) -> VecEnvStepReturn:
        """Finish a step; the reward is that of the last state where an episode ended."""
        observations, _, ended, infos = self.venv.step_wait()
        reached = np.array(observations)
        died = np.zeros(len(reached), np.bool_)
        for index in np.flatnonzero(ended).tolist():
            reached[index] = infos[index]["terminal_observation"]
            died[index] = infos[index]["end"] == "hit"
        scores = self._shaping.model.score(reached)
        return observations, self._shaping.shape(scores, scores, died), ended, infos


def make_plain(
    recipe: PolicyRecipe, shaping: RewardShaping, training_seed: int, device: torch.device
) -> PPO:
    """Return plain PPO on plain environments."""

    def make_env() -> gymnasium.Env[Any, Any]:
        return gymnasium.make(tril.play.env.ENV_ID, reward="none")

    games = SubprocVecEnv([make_env] * recipe.n_envs)
    return PPO(
        "CnnPolicy",
        LearnedReward(games, shaping),
        learning_rate=recipe.learning_rate,
        n_steps=recipe.n_steps,
        batch_size=recipe.n_envs * recipe.n_steps // recipe.n_minibatches,
        n_epochs=recipe.n_epochs,
        gamma=recipe.gamma,
        gae_lambda=recipe.gae_lambda,
        clip_range=recipe.clip_range,
        ent_coef=recipe.ent_coef,
        vf_coef=recipe.vf_coef,
        max_grad_norm=recipe.max_grad_norm,
        seed=training_seed,
        device=device,
        policy_kwargs={
            "net_arch": [],
            "features_extractor_class": PlainFeatures,
            "features_extractor_kwargs": {"network": recipe.network},
        },
    )


def make_atari_defaults(shaping: RewardShaping, training_seed: int, device: torch.device) -> PPO:
    """Return plain PPO with stable-baselines3's settings for Atari: NatureCNN, 8 x 128."""

    def make_env() -> gymnasium.Env[Any, Any]:
        return gymnasium.make(tril.play.env.ENV_ID, reward="none")

    return PPO(
        "CnnPolicy",
        LearnedReward(SubprocVecEnv([make_env] * 8), shaping),
        learning_rate=2.5e-4,
        n_steps=128,
        batch_size=256,
        n_epochs=4,
        clip_range=0.1,
        ent_coef=0.01,
        vf_coef=0.5,
        seed=training_seed,
        device=device,
    )


def make_ours(
    recipe: PolicyRecipe,
    shaping: RewardShaping,
    training_seed: int,
    precision: Precision,
    device: torch.device,
) -> TimedPPO:
    """Return our PPO on our games."""
    games = TimedGames(
        SPACE_INVADERS,
        recipe.n_envs,
        TrainingStarts(SPACE_INVADERS),
        n_parts=N_PARTS,
        training_seed=training_seed,
    )
    model = shaping.model
    timed = TimedModel(model.network, model.offset, model.scale, model.zero, model.one)
    env = TrilVecEnv(games, replace(shaping, model=timed))
    generators = TrainingGenerators.from_seed(training_seed)
    return TimedPPO(env, recipe, 10**9, generators, lambda: None, lambda _: None, precision, device)


def rate(model: PPO, steps: int) -> float:
    """Train for this many steps and return how many were done in a second."""
    before = model.num_timesteps
    begin = time.perf_counter()
    model.learn(steps, log_interval=None, reset_num_timesteps=before == 0)  # type: ignore[arg-type]
    return (model.num_timesteps - before) / (time.perf_counter() - begin)


def measure(
    name: str,
    rounds: int,
    rollouts: int,
    precision: Precision,
    device: torch.device,
    freeze_convolutions: bool = False,
) -> dict[str, float]:
    """Measure a recipe's PPO in turns with plain PPO, print a table and return the figures."""
    recipe = replace(
        RECIPES[name].policy,
        kl_coef=0.0,
        critic_warm_up_steps=0,
        reward="level",
        freeze_convolutions=freeze_convolutions,
    )
    network = new_network(np.random.default_rng(0))
    shaping = RewardShaping.of(RewardModel(network).on(device), recipe)
    steps = recipe.n_envs * recipe.n_steps * rollouts
    ours = make_ours(recipe, shaping, 0, precision, device)
    plain = make_plain(recipe, shaping, 0, device)
    defaults = make_atari_defaults(shaping, 0, device)
    models = {"plain": plain, "defaults": defaults, "ours": ours}
    for model in models.values():
        rate(model, 1)  # not counted: the first rollout starts processes and threads
    seconds.clear()
    rates, alone = [], []
    for _ in range(rounds):
        rates.append({kind: rate(model, steps) for kind, model in models.items()})
        with kept(seconds):
            alone.append(ours.measure_alone())
    for model in models.values():
        assert model.env is not None
        model.env.close()
    result = {f"{kind}_per_s": statistics.median(one[kind] for one in rates) for kind in models} | {
        f"over_{kind}": statistics.median(one["ours"] / one[kind] for one in rates)
        for kind in ("plain", "defaults")
    }
    whole = sum(steps / one["ours"] for one in rates)
    parts = ("playing", "waiting", "reward", "learning")
    shares = {part: seconds[part] / whole for part in parts}
    shares["rest"] = 1.0 - sum(shares.values()) + shares["waiting"]  # a part of playing
    # Shares of the whole that the parts of as many rollouts would take alone.
    shares |= {
        f"{part} alone": rollouts * sum(one[part] for one in alone) / whole for part in alone[0]
    }
    print(
        f"recipe {name}: network {recipe.network}, {recipe.n_envs} x {recipe.n_steps},"
        f" ours in {precision}, all on {device}"
    )
    print(f"  ours                                      {result['ours_per_s']:>6.0f} steps/s")
    for kind, said in (("plain", "same network"), ("defaults", "Atari defaults")):
        print(
            f"  plain stable-baselines3, {said:<16} {result[f'{kind}_per_s']:>6.0f} steps/s, ratio"
            f" {result[f'over_{kind}']:.2f}"
        )
    print("  " + ", ".join(f"{part} {share:.0%}" for part, share in shares.items()))
    return result | {f"{part}_share".replace(" ", "_"): share for part, share in shares.items()}


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--recipe", choices=list(RECIPES), action="append")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--rollouts", type=int, default=2, help="rollouts in a turn")
    parser.add_argument("--precision", choices=["auto", *Precision], default="auto")
    parser.add_argument("--device", choices=["auto", "cpu", "cuda"], default="auto")
    parser.add_argument(
        "--freeze-convolutions", action="store_true", help="ours learns the layers above them"
    )
    arguments = parser.parse_args()
    device = learning_device(arguments.device)
    precision = Precision.of(arguments.precision, device)
    result = {
        name: measure(
            name,
            arguments.rounds,
            arguments.rollouts,
            precision,
            device,
            arguments.freeze_convolutions,
        )
        for name in arguments.recipe or list(RECIPES)
    }
    threads = torch.get_num_threads()
    print(json.dumps({"benchmark": "ppo", "threads": threads, **vars(arguments), **result}))


if __name__ == "__main__":
    main()
