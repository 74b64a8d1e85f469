"""Pretraining: a policy that has learned to see and to survive, and no behaviour.

A clone of a dozen games begins with random weights, hits hardly anything from starts that the games
do not show, and dies; PPO then has to learn to see, to dodge and to aim at once. What all
behaviours have in common is learned here once. First the layers below the heads learn to tell from
screens of varied play what the console's memory holds, how soon a cannon would be hit that stays or
goes to one side, and which alien it would hit if it shot. Then PPO learns to survive with the
convolutions as they are: all that it is paid for is not to be hit, and its episodes begin after
openings and within varied games. No alien is worth anything.

    python -m scripts.pretraining.policy

makes the weights that ship with Tril anew; it takes half an hour on two cores.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt
import torch
from torch import nn

from scripts.pretraining.memory_reading import N_GAMES, Screens, play_games, train_readings
from trainer.nn.checkpoints import save_tensors
from trainer.nn.precision import Precision
from trainer.nn.seeding import torch_seeded
from trainer.policy.evaluation import play
from trainer.policy.imitation import ImitationTask
from trainer.policy.imitator import train_imitator
from trainer.policy.networks import (
    PRETRAINED,
    Policy,
    ScreenPolicy,
    load_network,
    new_policy,
    save_policy,
    shared_weights,
)
from trainer.progress import NullProgress
from trainer.reward.model import RewardModel, new_network
from tril.demonstrators.space_invaders.varied_play import play_varied
from tril.games.atari.starts import EVALUATION_START_COUNT
from tril.games.space_invaders import SPACE_INVADERS
from tril.recipes import FAST, with_values
from tril.recording import Recording

N_EPOCHS = 20
"""Passes over the screens."""

STEPS = 600_000
"""Training steps of PPO."""

N_STARTING_GAMES = 64
"""Varied games that half of the episodes begin within."""

RECIPE = with_values(
    FAST,
    {
        "policy.kl_coef": 0.0,
        "policy.critic_warm_up_steps": 0,
        "policy.ent_coef": 0.002,
        "policy.freeze_convolutions": True,
        "policy.death_penalty": 1.0,
        "policy.reward_scale": 1.0,
        "policy.learning_rate": 5e-4,
        "policy.best_share": 1.0,
        "policy.demonstration_share": 0.5,
        "policy.opening_share": 1.0,
        "policy.sticky_action_probability": 0.25,
    },
)
"""How PPO learns to survive."""


@dataclass(frozen=True)
class NoReward(RewardModel):
    """A reward that is 0 everywhere, so that only being hit counts."""

    @classmethod
    def new(cls) -> NoReward:
        """Return one."""
        return cls(new_network(np.random.default_rng(0)), one=1.0)

    def score(self, observations: npt.NDArray[np.uint8]) -> npt.NDArray[np.float32]:
        """Return zeros, float32 (N,)."""
        return np.zeros(len(observations), np.float32)


def pretrain_vision(
    screens: Screens, seed: int
) -> tuple[ScreenPolicy, dict[str, dict[str, float]]]:
    """Train the layers below the heads to predict varying memory and each move's outcome.

    Args:
        screens: Screens with outcomes.
        seed: Seeds all random numbers.

    Returns:
        The policy, whose heads are random, and the figures of ``train_readings``.
    """
    rng = np.random.default_rng(seed)
    policy = new_policy(FAST.policy.network, SPACE_INVADERS.controls.n_actions, 0.0, rng)
    targets = [screens.memory(screens.varying()), screens.hits(), screens.shots()]
    n_flags = sum(target.flags.shape[1] for target in targets)
    with torch_seeded(rng):
        predicted = nn.Linear(policy.features_extractor.features_dim, n_flags)
    weights = [*policy.features_extractor.parameters(), *predicted.parameters()]
    figures = train_readings(
        lambda inputs: predicted(policy.extract_features(inputs)),
        weights,
        screens,
        targets,
        N_EPOCHS,
        rng,
    )
    return policy, figures


def pretrain_survival(
    policy: ScreenPolicy, games: Sequence[Recording], steps: int, seed: int, folder: Path
) -> ScreenPolicy:
    """Train a policy to survive by PPO.

    Args:
        policy: Policy to begin with.
        games: Half of the episodes begin within them.
        steps: Training steps.
        seed: Seeds all random numbers.
        folder: For checkpoints.
    """
    start, path = folder / "start.zip", folder / "survivor.zip"
    save_policy(policy, start)
    task = ImitationTask(
        game=SPACE_INVADERS,
        model=NoReward.new(),
        recordings=games,
        tiers=[list(range(len(games)))],
        recipe=RECIPE,
        steps=steps,
        training_seed=seed,
        start_policy=start,
    )
    precision = Precision.of("auto", torch.device("cpu"))
    train_imitator(task, path, folder, NullProgress(), precision=precision)
    return load_network(path)


def save_pretrained(policy: ScreenPolicy, path: Path, figures: str) -> None:
    """Write a policy's weights in half precision, as ``pretrained_policy`` reads them."""
    weights = {name: one.half() for name, one in shared_weights(policy).items()}
    save_tensors(path, weights, {"figures": figures})


def death_rate(policy: ScreenPolicy) -> float:
    """Return the share of sticky games after the evaluation starts' openings that are lost."""
    openings = [
        SPACE_INVADERS.starts.evaluation_opening(number) for number in range(EVALUATION_START_COUNT)
    ]
    games = play(SPACE_INVADERS, Policy(policy), openings, "sticky")
    return float(np.mean([game.died for game in games]))


def main() -> None:
    """Make the weights anew."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--games", type=int, default=N_GAMES)
    parser.add_argument("--steps", type=int, default=STEPS)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("-o", "--output", type=Path, default=PRETRAINED)
    arguments = parser.parse_args()
    screens = play_games(arguments.games, arguments.seed, arguments.processes, look_ahead=True)
    policy, figures = pretrain_vision(screens, arguments.seed)
    del screens
    rng, console = np.random.default_rng([arguments.seed, 1]), SPACE_INVADERS.make_console()
    games = [play_varied(rng, console).recording for _ in range(N_STARTING_GAMES)]
    with tempfile.TemporaryDirectory() as folder:
        policy = pretrain_survival(policy, games, arguments.steps, arguments.seed, Path(folder))
    figures_text = json.dumps(
        figures | {"n_steps": arguments.steps, "death_rate": death_rate(policy)}
    )
    save_pretrained(policy, arguments.output, figures_text)
    sys.stdout.write(f"{figures_text}\n")


if __name__ == "__main__":
    main()
