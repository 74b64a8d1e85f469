"""Proximal policy optimisation (Schulman et al. 2017): stable-baselines3's, faster on processors.

The algorithm, its advantages and its losses are stable-baselines3's, and a test holds a whole
update equal to its own. What is different is where time was lost (see ScreenRolloutBuffer and
trainer.policy.networks; numbers of a minibatch are read once per rollout), explicit generators, a
stop within a minibatch's time, and three additions that are off unless the recipe asks for them:
a pull to the policy that training started from, a warm-up of the critic, and falling step sizes.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import torch
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.vec_env import VecEnv
from torch import Tensor
from torch.nn import functional as F

from trainer.nn.devices import CPU, device_of, forward_batch
from trainer.nn.precision import Precision
from trainer.nn.screens import channels_last_screens
from trainer.nn.seeding import torch_generator_from
from trainer.policy.networks import ScreenPolicy, channels_last, policy_arguments
from trainer.policy.rollout_buffer import Minibatch, ScreenRolloutBuffer
from trainer.policy.vec_env import FinishedEpisode, TrilVecEnv
from tril.recipes import PolicyRecipe


@dataclass
class Draws:
    """The generators of a training, all made of its training seed.

    Attributes:
        weights: Of the first weights; used once.
        actions: Of the actions taken in rollouts.
        order: Of the order in which rollouts are learned from.
    """

    weights: np.random.Generator
    actions: torch.Generator
    order: np.random.Generator

    @classmethod
    def of(cls, training_seed: int) -> Draws:
        """Make the generators."""
        sequences = np.random.SeedSequence(training_seed).spawn(3)
        actions = torch.Generator()
        actions.manual_seed(int(sequences[1].generate_state(1, np.uint64)[0] >> 1))
        return cls(
            np.random.default_rng(sequences[0]), actions, np.random.default_rng(sequences[2])
        )


class ImitationPPO(PPO):
    """PPO on a TrilVecEnv, by a PolicyRecipe.

    Args:
        env: The games and what is paid for them.
        recipe: Hyperparameters.
        steps: Length of the whole training, in steps.
        draws: Where chance comes from.
        tick: Called after every step of the games and every minibatch; what it raises ends the
            training there.
        on_episode: Called with every episode that has ended.
        precision: The numbers that the networks' layers multiply.
        device: Where the policy acts and learns.
    """

    policy: ScreenPolicy
    rollout_buffer: ScreenRolloutBuffer
    _last_obs: npt.NDArray[np.uint8]
    _last_episode_starts: npt.NDArray[np.bool_]

    def __init__(
        self,
        env: TrilVecEnv,
        recipe: PolicyRecipe,
        steps: int,
        draws: Draws,
        tick: Callable[[], None],
        on_episode: Callable[[FinishedEpisode], None],
        precision: Precision = Precision.FLOAT32,
        device: torch.device = CPU,
    ) -> None:
        self.recipe = recipe
        self.steps = steps
        self.draws = draws
        self.start_policy: ScreenPolicy | None = None
        self.update_values: dict[str, float] = {}
        self._tick = tick
        self._on_episode = on_episode
        self._precision = precision
        rate = recipe.learning_rate
        super().__init__(
            ScreenPolicy,
            env,
            learning_rate=(lambda left: rate * left) if recipe.anneal_lr else rate,
            n_steps=recipe.n_steps,
            batch_size=recipe.n_envs * recipe.n_steps // recipe.n_minibatches,
            n_epochs=recipe.n_epochs,
            gamma=recipe.gamma,
            gae_lambda=recipe.gae_lambda,
            clip_range=recipe.clip_range,
            ent_coef=recipe.ent_coef,
            vf_coef=recipe.vf_coef,
            max_grad_norm=recipe.max_grad_norm,
            rollout_buffer_class=ScreenRolloutBuffer,
            policy_kwargs=policy_arguments(recipe.network),
            device=device,
            _init_setup_model=False,
        )
        torch_generator_from(draws.weights, self._setup_model)
        channels_last(self.policy)

    def collect_rollouts(
        self,
        env: VecEnv,
        callback: BaseCallback,
        rollout_buffer: Any,
        n_rollout_steps: int,
    ) -> bool:
        """Play ``n_rollout_steps`` steps of all games; see OnPolicyAlgorithm.collect_rollouts."""
        self.policy.set_training_mode(False)
        callback.on_rollout_start()
        rollout_buffer.reset()
        ended = self._last_episode_starts
        for _ in range(n_rollout_steps):
            actions, values, log_probs = self._act(self._last_obs)
            observations, rewards, ended, infos = env.step(actions)
            self.num_timesteps += env.num_envs
            for index in np.flatnonzero(ended).tolist():
                self._on_episode(infos[index]["finished"])
            self._bootstrap(rewards, ended, infos)
            rollout_buffer.add(
                self._last_obs, actions, rewards, self._last_episode_starts, values, log_probs
            )
            self._last_obs = np.asarray(observations)
            self._last_episode_starts = ended
            self._tick()
        with torch.inference_mode():
            values = self._answers(torch.from_numpy(self._last_obs))[1]
        rollout_buffer.compute_returns_and_advantage(values, ended)
        callback.on_rollout_end()
        return True

    def _act(
        self, observations: npt.NDArray[np.uint8]
    ) -> tuple[npt.NDArray[np.int64], Tensor, Tensor]:
        """Draw actions; returns them, the states' values and the actions' log probabilities."""
        with torch.inference_mode():
            logits, values = self._answers(torch.from_numpy(observations))
            log_all = logits.log_softmax(1)
            drawn = torch.multinomial(log_all.exp(), 1, generator=self.draws.actions)
            return drawn[:, 0].numpy(), values, log_all.gather(1, drawn)[:, 0]

    def _answers(self, observations: Tensor) -> tuple[Tensor, Tensor]:
        """Return the policy's logits and values on the processor, where everything is drawn."""
        logits, values = self._ask(self.policy, observations)
        return logits.cpu(), values.cpu()

    def _ask(self, policy: ScreenPolicy, observations: Tensor) -> tuple[Tensor, Tensor]:
        """Return a policy's logits and values, computed as precisely as this training is."""
        device = device_of(policy)
        with self._precision.multiplying(device):
            return policy.logits_and_values(observations.to(device))

    def _bootstrap(
        self,
        rewards: npt.NDArray[np.float32],
        ended: npt.NDArray[np.bool_],
        infos: list[dict[str, Any]],
    ) -> None:
        """Add the value of the last state where an episode ended only because time was over.

        As stable-baselines3 does it (Pardo et al. 2018).
        """
        cut = [i for i in np.flatnonzero(ended).tolist() if infos[i]["TimeLimit.truncated"]]
        if not cut:
            return
        last = channels_last_screens(np.stack([infos[i]["terminal_observation"] for i in cut]))
        with torch.inference_mode():
            values = self._answers(last)[1]
        rewards[cut] += self.gamma * values.numpy()

    @property
    def is_warming_up(self) -> bool:
        """Whether only the critic learns yet."""
        return 0 < self.num_timesteps <= self.recipe.critic_warm_up_steps

    @property
    def pull(self) -> float:
        """Weight of the divergence from the start policy, falling to zero over the training."""
        return self.recipe.kl_coef * max(0.0, 1.0 - self.num_timesteps / self.steps)

    def train(self) -> None:
        """Learn from the rollout; see PPO.train."""
        self.policy.set_training_mode(True)
        self._update_learning_rate(self.policy.optimizer)
        pull = self.pull if self.start_policy is not None else 0.0
        wanted = self._start_log_probabilities() if pull and not self.is_warming_up else None
        collected: list[Tensor] = []
        for _ in range(self.n_epochs):
            for minibatch in self.rollout_buffer.minibatches(self.batch_size, self.draws.order):
                if self.is_warming_up:
                    loss, numbers = self._critic_loss(minibatch)
                else:
                    loss, numbers = self._loss(minibatch, wanted, pull)
                self.policy.optimizer.zero_grad()
                loss.backward()  # type: ignore[no-untyped-call]
                torch.nn.utils.clip_grad_norm_(self.policy.parameters(), self.max_grad_norm)
                self.policy.optimizer.step()
                collected.append(numbers)
                self._tick()
            self._n_updates += 1
        means = torch.stack(collected).mean(0).tolist()
        names = ("policy_loss", "value_loss", "entropy", "kl", "clipped", "pull")
        self.update_values = dict(zip(names, means, strict=True))

    def _loss(
        self, minibatch: Minibatch, wanted: Tensor | None, pull: float
    ) -> tuple[Tensor, Tensor]:
        """Return PPO's loss of a minibatch, and the numbers that the curves show."""
        logits, values = self._ask(self.policy, minibatch.observations)
        log_all = logits.log_softmax(1)
        log_probs = log_all.gather(1, minibatch.actions[:, None])[:, 0]
        advantages = minibatch.advantages
        advantages = (advantages - advantages.mean()) / (advantages.std() + 1e-8)
        log_ratio = log_probs - minibatch.old_log_probs
        ratio = log_ratio.exp()
        low, high = 1.0 - self.recipe.clip_range, 1.0 + self.recipe.clip_range
        policy_loss = -torch.min(advantages * ratio, advantages * ratio.clamp(low, high)).mean()
        value_loss = F.mse_loss(minibatch.returns, values)
        entropy = -(log_all.exp() * log_all).sum(1).mean()
        loss = policy_loss - self.ent_coef * entropy + self.vf_coef * value_loss
        divergence = loss.new_zeros(())
        if wanted is not None:
            divergence = F.kl_div(
                log_all, wanted[minibatch.indices], reduction="batchmean", log_target=True
            )
            loss = loss + pull * divergence
        with torch.no_grad():
            kl = (ratio - 1.0 - log_ratio).mean()
            clipped = ((ratio - 1.0).abs() > self.recipe.clip_range).float().mean()
            numbers = torch.stack([policy_loss, value_loss, entropy, kl, clipped, divergence])
        return loss, numbers

    def _critic_loss(self, minibatch: Minibatch) -> tuple[Tensor, Tensor]:
        """Return the loss of the value's last layer alone, so that the policy stays as it is."""
        with torch.no_grad(), self._precision.multiplying(device_of(self.policy)):
            features = self.policy.extract_features(minibatch.observations)
        logits, values = self.policy.heads(features)
        log_all = logits.detach().log_softmax(1)
        entropy = -(log_all.exp() * log_all).sum(1).mean()
        value_loss = F.mse_loss(minibatch.returns, values)
        zero = value_loss.new_zeros(())
        numbers = torch.stack([zero, value_loss.detach(), entropy, zero, zero, zero])
        return self.vf_coef * value_loss, numbers

    def _start_log_probabilities(self) -> Tensor:
        """Return the start policy's log probabilities over the rollout, float32 (N, 6)."""
        assert self.start_policy is not None
        size = forward_batch(device_of(self.start_policy))
        parts = []
        with torch.no_grad():
            for screens in torch.split(self.rollout_buffer.screens, size):
                logits, _ = self._ask(self.start_policy, screens)
                parts.append(logits.log_softmax(1))
                self._tick()
        return torch.cat(parts)
