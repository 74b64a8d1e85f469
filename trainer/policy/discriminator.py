"""GAIL's discriminator, which tells states of demonstrations from those that a policy visits.

Generative adversarial imitation learning (Ho and Ermon 2016, algorithm 1) with these differences:

- It sees observations only, not actions. An observation holds the screens of four steps, in which
  actions show. The action recorded for a step of a person's game is only the one held longest in
  it, a quarter of a second after what it reacts to: by its actions alone a policy, which holds each
  for a whole step, would be told from a person.
- The policy's update is PPO's instead of TRPO's, and comes before the discriminator's instead of
  after it, so that its rewards are those it collected while playing.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
import torch
from torch import Tensor
from torch.nn import functional as F

from trainer.nn.checkpoints import check_finite, restore_training, training_tensors
from trainer.nn.devices import CPU
from trainer.nn.screens import channels_last_screens, take_screens
from trainer.policy.imitation import ImitationTask
from trainer.reward.model import RewardModel, RewardNetwork, new_network
from tril.errors import Invalid
from tril.recipes import GailRecipe
from tril.recording import trajectory

_WEIGHTS, _BATCHES = range(2)


class Discriminator:
    """A reward network whose output is the logit of "this state is from a demonstration".

    What is sampled for a round depends on the training seed and the round's number alone, so that
    an interrupted training continues as if it had not been interrupted.

    Args:
        demonstrated: The observations in which the demonstrations acted, uint8 (N, 4, 84, 84).
        recipe: Recipe of the discriminator.
        training_seed: Seeds all random numbers.
        device: Device of the network and of ``model``.

    Attributes:
        model: The network as a reward model, as of the last round.
        rounds: Number of completed rounds.
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
        self._optimizer = torch.optim.Adam(
            self._network.parameters(), lr=recipe.learning_rate, weight_decay=recipe.weight_decay
        )
        with torch.random.fork_rng(devices=[]):
            self.model = RewardModel(RewardNetwork().to(device))
        self.rounds = 0
        self._update_model()

    @classmethod
    def of(cls, task: ImitationTask, device: torch.device) -> Discriminator:
        """Return an untrained discriminator of a task's perfect demonstrations.

        Raises:
            Invalid: There is none.
        """
        console = task.game.make_console()
        demonstrations = [
            trajectory(recording, console) for recording in task.perfect if recording.actions
        ]
        if not demonstrations:
            raise Invalid("GAIL needs at least one perfect demonstration to learn from.")
        # Not the last states: the policy's rollouts have none in which a game was over either.
        acted_in = np.concatenate(
            [demonstration.observations[:-1] for demonstration in demonstrations]
        )
        screens = channels_last_screens(acted_in)
        return cls(screens, task.recipe.gail, task.training_seed, device)

    def learn(self, played: Tensor, on_step: Callable[[], None]) -> dict[str, float]:
        """Learn to tell the states of a rollout from demonstrated ones.

        Args:
            played: The observations in which the policy acted, uint8 (M, 4, 84, 84).
            on_step: Called after every update; what it raises ends the round.

        Returns:
            Means over the round for the curves: discriminator_loss, in nats, and
            discriminator_accuracy, 0 to 1, which is 0.5 by chance.
        """
        size = self._recipe.batch_size
        played = played.to(self._device)
        rng = np.random.default_rng([self._training_seed, _BATCHES, self.rounds])
        labels = torch.cat([torch.zeros(size), torch.ones(size)]).to(self._device)
        losses, right = [], []
        for _ in range(self._recipe.updates):
            batch = torch.cat([_sample(played, size, rng), _sample(self._demonstrated, size, rng)])
            logits = self._network(batch)
            loss = F.binary_cross_entropy_with_logits(logits, labels)
            self._optimizer.zero_grad()
            loss.backward()  # type: ignore[no-untyped-call]
            self._optimizer.step()
            losses.append(loss.detach())
            right.append(((logits.detach() > 0) == (labels > 0)).float().mean())
            on_step()
        check_finite("discriminator", *self._network.parameters())
        self.rounds += 1
        self._update_model()
        return {
            "discriminator_loss": torch.stack(losses).mean().item(),
            "discriminator_accuracy": torch.stack(right).mean().item(),
        }

    def tensors(self) -> dict[str, Tensor]:
        """Return all that its future depends on, except its rounds, for a checkpoint."""
        return training_tensors(self._network, self._optimizer, ".")

    def restore(self, rounds: int, tensors: Mapping[str, Tensor]) -> None:
        """Restore what ``tensors`` returned after so many rounds."""
        restore_training(self._network, self._optimizer, tensors, ".")
        self.rounds = rounds
        self._update_model()

    def _update_model(self) -> None:
        self.model.network.load_state_dict(self._network.state_dict())


def _sample(observations: Tensor, count: int, rng: np.random.Generator) -> Tensor:
    """Return observations sampled uniformly with replacement."""
    indices = torch.from_numpy(rng.integers(len(observations), size=count))
    return take_screens(observations, indices.to(observations.device))
