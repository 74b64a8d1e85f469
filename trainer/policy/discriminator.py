"""GAIL's discriminator: tells the states of demonstrations from those that a policy sees.

Generative adversarial imitation learning (Ho and Ermon 2016, algorithm 1) with these differences:

- It looks at observations alone, not at observations and actions. An observation holds the
  screens of the last four steps, in which one sees what was done. The action that stands for a
  step of a person's recording is only the one held longest in it, and comes a quarter of a second
  after what it answers: by its actions alone a policy, which holds each for a whole step, would
  be told from a person.
- The policy takes its step by PPO instead of TRPO, and before the discriminator instead of after
  it, so that it is paid by the one that it has met while playing.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
import torch
from torch import Tensor
from torch.nn import functional as F

from trainer.nn.devices import CPU
from trainer.nn.optimizers import optimizer_tensors, restore_optimizer
from trainer.nn.screens import take_screens
from trainer.reward.model import RewardModel, RewardNetwork
from trainer.reward.reward_trainer import new_network
from tril.recipes import GailRecipe

_WEIGHTS, _BATCHES = range(2)


class Discriminator:
    """A reward network whose output is the logit of "this state is from a demonstration".

    What is drawn for a round depends on the training seed and the round's number alone, so that a
    training that was interrupted goes on as if it had not been.

    Args:
        demonstrated: The observations in which the demonstrations acted, uint8 (N, 4, 84, 84).
        recipe: How it is learned.
        training_seed: Feeds every random choice.
        device: Where it is learned, and where its model is.

    Attributes:
        model: The network as a reward model, as of the last round.
        rounds: How often it has learned.
    """

    def __init__(
        self,
        demonstrated: Tensor,
        recipe: GailRecipe,
        training_seed: int,
        device: torch.device = CPU,
    ) -> None:
        self._demonstrated = demonstrated.to(device)
        self._device = device
        self._recipe = recipe
        self._training_seed = training_seed
        self._network = new_network(np.random.default_rng([training_seed, _WEIGHTS])).to(device)
        self._parameters = list(self._network.parameters())
        self._optimizer = torch.optim.Adam(
            self._parameters, lr=recipe.learning_rate, weight_decay=recipe.weight_decay
        )
        with torch.random.fork_rng(devices=[]):
            self.model = RewardModel((RewardNetwork().to(device),), (0.0,), (1.0,))
        self.rounds = 0
        self._publish()

    def learn(self, played: Tensor, tick: Callable[[], None]) -> dict[str, float]:
        """Learn to tell the states of a rollout from demonstrated ones.

        Args:
            played: The observations in which the policy acted, uint8 (M, 4, 84, 84), preprocessed
                as the demonstrated ones.
            tick: Called after every update; what it raises ends the round.

        Returns:
            Means over the round for the curves: discriminator_loss, in nats, and
            discriminator_accuracy, 0 to 1, of which 0.5 is what chance gives.
        """
        size = self._recipe.batch_size
        played = played.to(self._device)
        rng = np.random.default_rng([self._training_seed, _BATCHES, self.rounds])
        wanted = torch.cat([torch.zeros(size), torch.ones(size)]).to(self._device)
        losses, right = [], []
        for _ in range(self._recipe.updates):
            batch = torch.cat([_drawn(played, size, rng), _drawn(self._demonstrated, size, rng)])
            logits = self._network(batch)
            loss = F.binary_cross_entropy_with_logits(logits, wanted)
            self._optimizer.zero_grad()
            loss.backward()  # type: ignore[no-untyped-call]
            self._optimizer.step()
            losses.append(loss.detach())
            right.append(((logits.detach() > 0) == (wanted > 0)).float().mean())
            tick()
        self.rounds += 1
        self._publish()
        return {
            "discriminator_loss": torch.stack(losses).mean().item(),
            "discriminator_accuracy": torch.stack(right).mean().item(),
        }

    def tensors(self) -> dict[str, Tensor]:
        """Return all that its future depends on, its rounds apart, for a checkpoint."""
        own = {f"network.{name}": tensor for name, tensor in self._network.state_dict().items()}
        adam = optimizer_tensors(self._optimizer, self._parameters)
        return own | {f"optimizer.{name}": tensor for name, tensor in adam.items()}

    def restore(self, rounds: int, tensors: Mapping[str, Tensor]) -> None:
        """Go on from what ``tensors`` returned after so many rounds."""
        parts: dict[str, dict[str, Tensor]] = {"network": {}, "optimizer": {}}
        for name, tensor in tensors.items():
            part, _, rest = name.partition(".")
            parts[part][rest] = tensor
        self._network.load_state_dict(parts["network"])
        restore_optimizer(self._optimizer, self._parameters, parts["optimizer"])
        self.rounds = rounds
        self._publish()

    def _publish(self) -> None:
        self.model.members[0].load_state_dict(self._network.state_dict())


def _drawn(observations: Tensor, count: int, rng: np.random.Generator) -> Tensor:
    """Draw some observations, each as likely as the others."""
    places = torch.from_numpy(rng.integers(len(observations), size=count))
    return take_screens(observations, places.to(observations.device))
