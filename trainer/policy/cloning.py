"""Behaviour cloning: a policy learned from demonstrations by classification."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import torch
from torch import Tensor
from torch.nn import functional as F

from trainer.nn.devices import CPU, device_of, forward_batch
from trainer.nn.screens import channels_last_screens, take_screens
from trainer.policy.networks import ScreenPolicy, new_policy, save_policy
from trainer.progress import Progress
from tril.errors import Invalid
from tril.game.space_invaders import Action
from tril.recipes import CloningRecipe
from tril.recording import Trajectory


@dataclass(frozen=True)
class CloneResult:
    """How well a clone repeats what was demonstrated.

    Attributes:
        accuracy: Share of the demonstrated actions that are the clone's likeliest.
        left_out_accuracy: The same on the demonstrations left out; None if none were.
        epochs: Passes over the demonstrations after which the clone was best.
    """

    accuracy: float
    left_out_accuracy: float | None
    epochs: int


@dataclass(frozen=True)
class Examples:
    """Observations and what was done in them.

    Attributes:
        observations: uint8 (N, 4, 84, 84), in channels-last order.
        actions: int64 (N,).
    """

    observations: Tensor
    actions: Tensor

    @classmethod
    def of(cls, trajectories: Sequence[Trajectory]) -> Examples:
        """Collect the steps of trajectories; the last observation has no action."""
        observations = np.concatenate([t.observations[:-1] for t in trajectories])
        actions = np.concatenate([t.actions for t in trajectories])
        return cls(channels_last_screens(observations), torch.from_numpy(actions))

    def on(self, device: torch.device) -> Examples:
        """Return these examples on a device."""
        return Examples(self.observations.to(device), self.actions.to(device))

    def weights(self) -> Tensor:
        """Return the weight of each action, float32 (6,), mean 1 over the examples.

        The inverse square root of an action's share: a rare one, such as a shot after a long
        wait, counts for more, without being done all the time.
        """
        counts = F.one_hot(self.actions, len(Action)).sum(0).float()
        weights = torch.where(counts > 0, counts.clamp(min=1.0).rsqrt(), 0.0)
        return weights * (counts.sum() / (weights * counts).sum())


def train_clone(
    trajectories: Sequence[Trajectory],
    recipe: CloningRecipe,
    training_seed: int,
    path: Path,
    progress: Progress,
    device: torch.device = CPU,
) -> CloneResult:
    """Learn a clone of perfect demonstrations and save it.

    Args:
        trajectories: The perfect demonstrations.
        recipe: How it is learned.
        training_seed: Feeds every random choice.
        path: Where the policy is saved, for plain ``PPO.load``.
        progress: Told of epochs, with loss, accuracy and left_out_accuracy.
        device: Where it is learned.

    Raises:
        Invalid: There is no demonstration.
        RunCancelled: Raised by ``progress``.
    """
    policy, result = clone(trajectories, recipe, training_seed, progress, device)
    save_policy(policy, path)
    return result


def clone(
    trajectories: Sequence[Trajectory],
    recipe: CloningRecipe,
    training_seed: int,
    progress: Progress,
    device: torch.device = CPU,
) -> tuple[ScreenPolicy, CloneResult]:
    """Learn a clone; see train_clone."""
    if not any(trajectory.n_steps for trajectory in trajectories):
        raise Invalid("A clone needs at least one perfect demonstration to learn from.")
    rng = np.random.default_rng(training_seed)
    learned, left_out = _split(trajectories, recipe.validation_share, rng)
    examples = Examples.of(learned).on(device)
    held = Examples.of(left_out).on(device) if left_out else None
    policy = new_policy(recipe.network, recipe.learning_rate, rng, device)
    best: tuple[float, dict[str, Tensor], CloneResult] | None = None
    for epoch in range(1, recipe.epochs + 1):
        done = (epoch - 1, recipe.epochs)
        loss, accuracy = _learn_once(policy, examples, recipe, rng, progress, done)
        values = {"loss": loss, "accuracy": accuracy}
        judged = loss
        result = CloneResult(accuracy, None, epoch)
        if held is not None:
            judged, left_out_accuracy = _judge(policy, held, examples.weights())
            values["left_out_accuracy"] = left_out_accuracy
            result = replace(result, left_out_accuracy=left_out_accuracy)
        progress.advance(epoch, recipe.epochs, values)
        if held is None or best is None or judged < best[0]:
            weights = {name: t.detach().clone() for name, t in policy.state_dict().items()}
            best = (judged, weights, result)
        elif epoch - best[2].epochs >= recipe.patience:
            break
    assert best is not None
    policy.load_state_dict(best[1])
    return policy, best[2]


def _split(
    trajectories: Sequence[Trajectory], share: float, rng: np.random.Generator
) -> tuple[list[Trajectory], list[Trajectory]]:
    """Return the demonstrations to learn from and those left out, at least one of the former."""
    n_left_out = min(round(share * len(trajectories)), len(trajectories) - 1)
    order = rng.permutation(len(trajectories)).tolist()
    chosen = set(order[:n_left_out])
    return (
        [t for i, t in enumerate(trajectories) if i not in chosen],
        [t for i, t in enumerate(trajectories) if i in chosen],
    )


def _learn_once(
    policy: ScreenPolicy,
    examples: Examples,
    recipe: CloningRecipe,
    rng: np.random.Generator,
    progress: Progress,
    done: tuple[int, int],
) -> tuple[float, float]:
    """Go through the examples once; return the mean loss and the accuracy on the way."""
    weights = examples.weights()
    order = torch.from_numpy(rng.permutation(len(examples.actions)))
    order = order.to(examples.actions.device)
    losses, right = [], []
    for begin in range(0, len(order), recipe.batch_size):
        chosen = order[begin : begin + recipe.batch_size]
        actions = examples.actions[chosen]
        logits, _ = policy.logits_and_values(take_screens(examples.observations, chosen))
        loss = F.cross_entropy(logits, actions, weights)
        policy.optimizer.zero_grad()
        loss.backward()  # type: ignore[no-untyped-call]
        policy.optimizer.step()
        losses.append(loss.detach())
        right.append((logits.argmax(1) == actions).float().mean())
        progress.advance(*done)
    return torch.stack(losses).mean().item(), torch.stack(right).mean().item()


def _judge(policy: ScreenPolicy, examples: Examples, weights: Tensor) -> tuple[float, float]:
    """Return the loss and the accuracy on examples that are not learned from."""
    with torch.no_grad():
        logits = torch.cat(
            [
                policy.logits_and_values(part)[0]
                for part in torch.split(examples.observations, forward_batch(device_of(policy)))
            ]
        )
    loss = F.cross_entropy(logits, examples.actions, weights).item()
    return loss, (logits.argmax(1) == examples.actions).float().mean().item()


def best_demonstrations(tiers: Sequence[Sequence[int]], share: float) -> list[int]:
    """Return the indices of the best demonstrations: whole tiers from the top, at least one.

    Args:
        tiers: Indices, best tier first.
        share: Further tiers are taken as long as they fit into this share of all demonstrations.
    """
    most = share * sum(len(tier) for tier in tiers)
    chosen = list(tiers[0])
    for tier in tiers[1:]:
        if len(chosen) + len(tier) > most:
            break
        chosen += tier
    return chosen
