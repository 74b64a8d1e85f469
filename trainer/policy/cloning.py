"""Behaviour cloning: a policy learned from demonstrations by classification."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor
from torch.nn import functional as F

from trainer.nn.checkpoints import check_finite
from trainer.nn.devices import CPU, device_of, forward_batch
from trainer.nn.scaling import N_SCREENS
from trainer.nn.screens import channels_last_screens, take_screens
from trainer.policy.networks import ScreenPolicy, new_policy, pretrained_policy
from trainer.progress import Progress
from tril.errors import Invalid
from tril.recipes import CloningRecipe
from tril.recording import Trajectory


@dataclass(frozen=True)
class CloneResult:
    """How well a clone predicts the demonstrated actions.

    Attributes:
        accuracy: Share of the demonstrated actions that are the clone's likeliest, 0 to 1.
        held_out_accuracy: The same on the held-out demonstrations; None if there are none.
        epochs: The epoch of the lowest loss, whose weights are kept.
    """

    accuracy: float
    held_out_accuracy: float | None
    epochs: int


@dataclass(frozen=True)
class Transitions:
    """Observations and the actions taken in them.

    Attributes:
        observations: uint8 (N, 4, 84, 84), in channels-last order.
        actions: int64 (N,).
        n_actions: Number of the game's actions.
    """

    observations: Tensor
    actions: Tensor
    n_actions: int

    @classmethod
    def of(cls, trajectories: Sequence[Trajectory], n_actions: int) -> Transitions:
        """Collect the steps of trajectories; the last observation has no action."""
        observations = np.concatenate([t.observations[:-1] for t in trajectories])
        actions = np.concatenate([t.actions for t in trajectories])
        return cls(channels_last_screens(observations), torch.from_numpy(actions), n_actions)

    def on(self, device: torch.device) -> Transitions:
        """Return these transitions on a device."""
        return Transitions(self.observations.to(device), self.actions.to(device), self.n_actions)

    def class_weights(self) -> Tensor:
        """Return the loss weight of each action, float32 (n_actions,), with mean 1.

        The inverse square root of an action's share: a rare one, such as a shot after a long wait,
        counts for more without being taken all the time.
        """
        counts = F.one_hot(self.actions, self.n_actions).sum(0).float()
        weights = torch.where(counts > 0, counts.clamp(min=1.0).rsqrt(), 0.0)
        return weights * (counts.sum() / (weights * counts).sum())


def train_clone(
    trajectories: Sequence[Trajectory],
    n_actions: int,
    recipe: CloningRecipe,
    training_seed: int,
    progress: Progress,
    device: torch.device = CPU,
) -> tuple[ScreenPolicy, CloneResult]:
    """Learn a clone of demonstrations.

    Args:
        trajectories: The demonstrations.
        n_actions: Number of the game's actions.
        recipe: How it is learned.
        training_seed: Seeds all random numbers.
        progress: Counts epochs; receives loss, accuracy and held_out_accuracy.
        device: Device to learn on.

    Raises:
        Invalid: There is no demonstration.
        RunCancelled: Raised by ``progress``.
    """
    if not any(trajectory.n_steps for trajectory in trajectories):
        raise Invalid("A clone needs at least one perfect demonstration to learn from.")
    rng = np.random.default_rng(training_seed)
    learned, held_out = _split(trajectories, recipe.validation_share, rng)
    transitions = Transitions.of(learned, n_actions).on(device)
    validation = Transitions.of(held_out, n_actions).on(device) if held_out else None
    if recipe.pretrained:
        policy = pretrained_policy(recipe.learning_rate, device)
        if recipe.freeze_convolutions:
            policy.freeze_convolutions()
    else:
        policy = new_policy(recipe.network, n_actions, recipe.learning_rate, rng, device)
        if recipe.scale_layers:
            policy.scale_layers(_sample(learned, rng))
    best: tuple[float, dict[str, Tensor], CloneResult] | None = None
    for epoch in range(1, recipe.epochs + 1):
        loss, accuracy = _train_epoch(policy, transitions, recipe, epoch, rng, progress)
        check_finite("clone", *policy.parameters())
        values = {"loss": loss, "accuracy": accuracy}
        criterion = loss
        result = CloneResult(accuracy, None, epoch)
        if validation is not None:
            criterion, held_out_accuracy = _validate(
                policy, validation, transitions.class_weights()
            )
            values["held_out_accuracy"] = held_out_accuracy
            result = replace(result, held_out_accuracy=held_out_accuracy)
        progress.advance(epoch, recipe.epochs, values)
        if validation is None or best is None or criterion < best[0]:
            weights = {name: t.detach().clone() for name, t in policy.state_dict().items()}
            best = (criterion, weights, result)
        elif epoch - best[2].epochs >= recipe.patience:
            break
    assert best is not None
    policy.load_state_dict(best[1])
    return policy, best[2]


def _split(
    trajectories: Sequence[Trajectory], share: float, rng: np.random.Generator
) -> tuple[list[Trajectory], list[Trajectory]]:
    """Return the demonstrations to learn from, at least one, and the held-out ones."""
    n_held_out = min(round(share * len(trajectories)), len(trajectories) - 1)
    held_out = set(rng.permutation(len(trajectories)).tolist()[:n_held_out])
    return (
        [t for i, t in enumerate(trajectories) if i not in held_out],
        [t for i, t in enumerate(trajectories) if i in held_out],
    )


def _sample(trajectories: Sequence[Trajectory], rng: np.random.Generator) -> npt.NDArray[np.uint8]:
    """Return some of the observations, uint8 (N_SCREENS or fewer, 4, 84, 84)."""
    observations = np.concatenate([trajectory.observations for trajectory in trajectories])
    return observations[rng.permutation(len(observations))[:N_SCREENS]]


def _train_epoch(
    policy: ScreenPolicy,
    transitions: Transitions,
    recipe: CloningRecipe,
    epoch: int,
    rng: np.random.Generator,
    progress: Progress,
) -> tuple[float, float]:
    """Train for one epoch; return the mean loss and accuracy of its minibatches."""
    weights = transitions.class_weights()
    order = torch.from_numpy(rng.permutation(len(transitions.actions)))
    order = order.to(transitions.actions.device)
    losses, right = [], []
    for begin in range(0, len(order), recipe.batch_size):
        indices = order[begin : begin + recipe.batch_size]
        actions = transitions.actions[indices]
        logits, _ = policy.logits_and_values(take_screens(transitions.observations, indices))
        loss = F.cross_entropy(logits, actions, weights)
        policy.optimizer.zero_grad()
        loss.backward()  # type: ignore[no-untyped-call]
        policy.optimizer.step()
        losses.append(loss.detach())
        right.append((logits.argmax(1) == actions).float().mean())
        progress.advance(epoch - 1, recipe.epochs)
    return torch.stack(losses).mean().item(), torch.stack(right).mean().item()


def _validate(
    policy: ScreenPolicy, transitions: Transitions, weights: Tensor
) -> tuple[float, float]:
    """Return loss and accuracy on held-out transitions."""
    batches = torch.split(transitions.observations, forward_batch(device_of(policy)))
    with torch.no_grad():
        logits = torch.cat([policy.logits_and_values(batch)[0] for batch in batches])
    loss = F.cross_entropy(logits, transitions.actions, weights).item()
    return loss, (logits.argmax(1) == transitions.actions).float().mean().item()
