"""Learning a reward model from preferences (T-REX, Brown et al. 2019, section 4).

The loss is the cross entropy of preferring the better of two fragments with a probability given by
their sums of R (Bradley-Terry), as in T-REX and the thesis.
"""

from __future__ import annotations

import json
import time
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import numpy as np
import numpy.typing as npt
import torch
from safetensors import SafetensorError
from torch.nn import functional as F

from trainer.nn.checkpoints import (
    CheckpointDamaged,
    check_finite,
    load_tensors,
    restore_training,
    save_tensors,
    training_tensors,
)
from trainer.nn.devices import CPU
from trainer.progress import Progress
from trainer.reward.fragment_logits import FragmentLogits, Seed
from trainer.reward.model import RewardModel, RewardNetwork, Spread, new_network
from trainer.reward.preference_dataset import PreferenceDataset
from trainer.reward.statements import StatementTrainer, spread_of_statements, understanding_of
from trainer.reward.wanted_aliens import WantedAliensTrainer
from tril.errors import Invalid
from tril.recording import LEVEL_STEPS

CHECKPOINT_INTERVAL_S = 30.0

WORST_STATES = 0.05
"""Share of the states at whose R the level of a statement is 0."""

_CURVE_POINTS = 200
"""Maximum number of points that a training adds to a curve."""

_WEIGHTS = 0
"""Number of the random stream of the first weights; fragment_logits has the others."""


def train_reward_model(
    dataset: PreferenceDataset,
    training_seed: int,
    progress: Progress,
    checkpoint_folder: Path | None = None,
    device: torch.device = CPU,
) -> RewardModel:
    """Learn a reward model from preferences.

    Args:
        dataset: Dataset to train on, with its recipe.
        training_seed: Seeds all random numbers. The same seed gives the same model on the CPU with
            the same number of threads; a GPU may round differently.
        progress: Counts updates; receives loss and accuracy by method "paper".
        checkpoint_folder: An existing folder of this training alone, from which an interrupted
            training continues. None saves nothing.
        device: Device to learn on; the model returned is on the CPU.

    Raises:
        Invalid: There are fewer than two tiers, all states have the same reward, or the recipe is
            of an earlier version that learned rewards in another way.
        RunCancelled: Raised by ``progress``.
    """
    checkpoint = checkpoint_folder and checkpoint_folder / "network.safetensors"
    trainer = network_trainer(
        dataset, dataset.recipe.updates, (training_seed, 0), checkpoint, device
    )
    return calibrate(trainer.train(progress), dataset).on(CPU)


def network_trainer(
    dataset: PreferenceDataset,
    updates: int,
    seed: Seed,
    checkpoint: Path | None = None,
    device: torch.device = CPU,
) -> RewardTrainer | WantedAliensTrainer | StatementTrainer:
    """Return the trainer of one network by the dataset's recipe; see RewardTrainer."""
    if dataset.recipe.method == "posterior":
        return WantedAliensTrainer(dataset, updates, seed)
    if dataset.recipe.method == "statement":
        return StatementTrainer(dataset, updates, seed, device)
    if dataset.recipe.method != "paper":
        raise Invalid(
            f"This training's recipe learns the reward by the method {dataset.recipe.method!r},"
            " which this version of Tril no longer has. Begin a new training with today's recipes."
        )
    return RewardTrainer(dataset, updates, seed, checkpoint, device)


class RewardTrainer:
    """Trains one reward network from fragments (method "paper").

    Args:
        dataset: Dataset to train on, with its recipe.
        updates: Gradient updates.
        seed: Seeds all random numbers.
        checkpoint: File from which an interrupted training continues; None saves nothing.
        device: Device to learn on.
    """

    def __init__(
        self,
        dataset: PreferenceDataset,
        updates: int,
        seed: Seed,
        checkpoint: Path | None = None,
        device: torch.device = CPU,
    ) -> None:
        recipe = dataset.recipe
        self._updates = updates
        self._checkpoint = checkpoint
        self.network = new_network(np.random.default_rng([*seed, _WEIGHTS])).to(device)
        self._optimizer = torch.optim.Adam(self.network.parameters(), lr=recipe.learning_rate)
        self._logits = FragmentLogits(self.network, dataset, updates, seed)
        self._recent: list[tuple[float, float]] = []

    def train(self, progress: Progress) -> RewardNetwork:
        """Train the network and return it; ``progress`` counts updates."""
        n_done = self._load()
        saved_at = time.monotonic()
        if n_done:
            progress.advance(n_done, self._updates)
        interval = max(1, self._updates // _CURVE_POINTS)
        for update in range(n_done + 1, self._updates + 1):
            self._update(update)
            values = None
            is_last = update == self._updates
            if update % interval == 0 or is_last:
                loss, accuracy = np.mean(self._recent, axis=0)
                values = {"loss": float(loss), "accuracy": float(accuracy)}
                self._recent.clear()
            progress.advance(update, self._updates, values)
            if is_last or time.monotonic() - saved_at >= CHECKPOINT_INTERVAL_S:
                self._save(update)
                saved_at = time.monotonic()
        return self.network

    def _update(self, update: int) -> None:
        logits = self._logits(update - 1)
        # Cross entropy between two sums is softplus of their difference.
        loss = F.softplus(-logits).mean()
        self._optimizer.zero_grad()
        loss.backward()  # type: ignore[no-untyped-call]
        self._optimizer.step()
        check_finite("reward model", loss)
        self._recent.append((loss.item(), (logits > 0).float().mean().item()))

    def _save(self, update: int) -> None:
        if self._checkpoint is None:
            return
        tensors = training_tensors(self.network, self._optimizer)
        state = json.dumps({"update": update, "recent": self._recent})
        save_tensors(self._checkpoint, tensors, {"state": state})

    def _load(self) -> int:
        """Continue from the checkpoint, if there is one; return the number of updates done."""
        if self._checkpoint is None or not self._checkpoint.exists():
            return 0
        try:
            tensors, metadata = load_tensors(self._checkpoint)
        except SafetensorError as error:
            raise CheckpointDamaged(self._checkpoint, error) from error
        restore_training(self.network, self._optimizer, tensors)
        state = json.loads(metadata["state"])
        self._recent = [(loss, accuracy) for loss, accuracy in state["recent"]]
        return int(state["update"])


def calibrate(network: RewardNetwork, dataset: PreferenceDataset) -> RewardModel:
    """Make a reward model of a trained network.

    Of a pretrained network, whose scale has no meaning, R is scaled to a standard deviation of 1
    over all states of the ranked demonstrations and shifted so that the tier of lowest mean R has a
    mean of 0. A game that ends early is then no better than the worst demonstration going on.
    Where R is a statement, its level is 0 where nothing is earned, or at the worst states of ranked
    and varied games if they lose, so that an agent never gains by dying, and 1 in the mean of the
    best games.

    Args:
        network: The network.
        dataset: Dataset that the network was trained on.

    Raises:
        Invalid: The network gives all states the same value.
    """
    if dataset.recipe.method == "statement":
        spread = spread_of_statements(network, understanding_of(dataset))
        return calibrate_reading(network, dataset, spread)
    model = RewardModel(network)
    if dataset.recipe.pretrained:
        offset, scale = standardisation(network, dataset)
        if scale < 1e-6:
            raise Invalid(
                "The reward model gives all states the same value: nothing was learned from this"
                " ranking. Use other demonstrations."
            )
        model = RewardModel(network, offset, scale)
    best = dataset.best
    rewards = _rewards(model, dataset, dict.fromkeys((*dataset.ranked, *best)))
    first_level = float(np.mean([values[:LEVEL_STEPS].mean() for values in rewards.values()]))
    best_level = float(np.mean([rewards[index][-LEVEL_STEPS:].mean() for index in best]))
    if dataset.recipe.pretrained:
        # The best games may hit nothing; readings alone must not set the scale then.
        best_level = max(best_level, first_level + 1.0 / model.scale)
    if not best_level > first_level:
        # Nothing was learned, which the check of the ranking reports. Any scale keeps R usable.
        best_level = first_level + 1.0
    return replace(model, zero=first_level, one=best_level)


def calibrate_reading(
    network: RewardNetwork, dataset: PreferenceDataset, spread: Spread | None
) -> RewardModel:
    """Make a reward model of a network that reads facts off the screen; see ``calibrate``.

    Args:
        network: The network.
        dataset: Dataset whose games set the scale.
        spread: How sure R is; None if that is not known.

    Raises:
        Invalid: The network gives all states the same value.
    """
    plain = RewardModel(network)
    ranked = _rewards(plain, dataset, dict.fromkeys((*dataset.ranked, *dataset.best)))
    varied = [plain.score(game.observations[1:]) for game in dataset.varied]
    all_rewards = np.concatenate([*ranked.values(), *varied])
    # About 0, not about the mean: a statement may be that the game goes on.
    scale, offset = float(np.sqrt((all_rewards**2).mean())), float(all_rewards.mean())
    if scale < 1e-6:
        raise Invalid(
            "The reward model gives all states the same value: nothing was learned from this"
            " ranking. Use other demonstrations."
        )
    # 0 is what a game earns that is over.
    over_level = (min(float(np.quantile(all_rewards, WORST_STATES)), 0.0) - offset) / scale
    best = np.concatenate([ranked[index] for index in dataset.best])
    best_level = max((float(best.mean()) - offset) / scale, over_level + 0.5)
    if spread:
        spread = replace(spread, weight=spread.weight / scale)
    return RewardModel(network, offset, scale, over_level, best_level, spread)


def standardisation(network: RewardNetwork, dataset: PreferenceDataset) -> tuple[float, float]:
    """Return the offset and the scale of a network's output, see ``calibrate``."""
    outputs = _rewards(RewardModel(network), dataset, dataset.ranked)
    offset = min(float(np.mean([outputs[i].mean() for i in tier])) for tier in dataset.tiers)
    return offset, float(np.concatenate(list(outputs.values())).std())


def _rewards(
    model: RewardModel, dataset: PreferenceDataset, indices: Iterable[int]
) -> dict[int, npt.NDArray[np.float32]]:
    return {index: dataset.score(model, index) for index in indices}
