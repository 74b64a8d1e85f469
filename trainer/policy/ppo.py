"""Proximal policy optimisation (Schulman et al. 2017): stable-baselines3's, faster on CPUs.

The algorithm, its advantages and its losses are stable-baselines3's; a test compares a whole update
with its own. The differences are speed (see ScreenRolloutBuffer and trainer.policy.networks;
statistics of minibatches are read once per rollout), explicit generators, cancellation within a
minibatch, and three options: a KL penalty towards the policy that training started from, a warm-up
of the critic, and annealing of the learning rate.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import torch
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.logger import Logger
from stable_baselines3.common.vec_env import VecEnv
from torch import Tensor
from torch.nn import functional as F

from trainer.nn.checkpoints import check_finite
from trainer.nn.devices import CPU, device_of, forward_batch
from trainer.nn.precision import Precision
from trainer.nn.screens import channels_last_screens
from trainer.nn.seeding import torch_seeded
from trainer.nn.threads import one_thread
from trainer.policy.networks import ScreenPolicy, channels_last, policy_arguments
from trainer.policy.rollout_buffer import Minibatch, ScreenRolloutBuffer
from trainer.policy.vec_env import EpisodeEnd, FinishedEpisode, TrilVecEnv
from tril.play.vector.vector_game import VectorGame
from tril.recipes import PolicyRecipe


@dataclass
class TrainingGenerators:
    """The random number generators of a training.

    Attributes:
        weights: For the initial weights; used once.
        actions: For the actions sampled in rollouts.
        minibatches: For the order of a rollout's steps in minibatches.
    """

    weights: np.random.Generator
    actions: torch.Generator
    minibatches: np.random.Generator

    @classmethod
    def from_seed(cls, training_seed: int) -> TrainingGenerators:
        """Return independent generators of a training seed."""
        sequences = np.random.SeedSequence(training_seed).spawn(3)
        actions = torch.Generator()
        actions.manual_seed(int(sequences[1].generate_state(1, np.uint64)[0] >> 1))
        return cls(
            np.random.default_rng(sequences[0]), actions, np.random.default_rng(sequences[2])
        )


class ImitationPPO(PPO):
    """PPO on a TrilVecEnv, by a PolicyRecipe.

    Args:
        env: The environments.
        recipe: Hyperparameters.
        steps: Length of the whole training, in steps.
        generators: Sources of randomness.
        on_step: Called after every step of the environments and every minibatch; what it raises
            ends the training there.
        on_episode: Called with every episode that has ended.
        precision: Precision of the networks' layers.
        device: Device on which the policy acts and learns.

    Attributes:
        start_policy: The policy that the KL penalty is towards; None without one.
        update_metrics: Means over the minibatches of the last update.
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
        generators: TrainingGenerators,
        on_step: Callable[[], None],
        on_episode: Callable[[FinishedEpisode], None],
        precision: Precision = Precision.FLOAT32,
        device: torch.device = CPU,
    ) -> None:
        self.recipe = recipe
        self.steps = steps
        self.generators = generators
        self.start_policy: ScreenPolicy | None = None
        self.update_metrics: dict[str, float] = {}
        self._convolved: list[Tensor] = []
        self._on_step = on_step
        self._on_episode = on_episode
        self._precision = precision
        rate = recipe.learning_rate
        super().__init__(
            ScreenPolicy,
            env,
            # The last rollout may end beyond the training's length.
            learning_rate=(lambda remaining: rate * max(remaining, 0.0))
            if recipe.anneal_lr
            else rate,
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
        # The default logger leaves a folder in the system's temporary folder.
        self.set_logger(Logger(folder=None, output_formats=[]))
        with torch_seeded(generators.weights):
            self._setup_model()
        channels_last(self.policy)
        if recipe.freeze_convolutions:
            self.policy.freeze_convolutions()

    def collect_rollouts(
        self,
        env: VecEnv,
        callback: BaseCallback,
        rollout_buffer: Any,
        n_rollout_steps: int,
    ) -> bool:
        """Play ``n_rollout_steps`` steps of all games; see OnPolicyAlgorithm.collect_rollouts.

        While the games of one part are played, actions are chosen for the next part. All rewards
        are computed at the end.
        """
        assert isinstance(env, TrilVecEnv)
        self.policy.set_training_mode(False)
        callback.on_rollout_start()
        rollout_buffer.begin(self._last_obs)
        self._convolved.clear()
        with one_thread():
            ends = self._play(env.games, rollout_buffer)
        self._last_obs = rollout_buffer.last_screens.numpy()
        rewards, episodes = env.judge(rollout_buffer.all_screens.numpy(), ends)
        check_finite("reward", torch.from_numpy(rewards))
        for episode in episodes:
            self._on_episode(episode)
        self._bootstrap(rewards, ends)
        rollout_buffer.put_rewards(rewards)
        with torch.inference_mode():
            values = self._forward_on_cpu(rollout_buffer.last_screens)[1]
        rollout_buffer.compute_returns_and_advantage(values, self._last_episode_starts)
        callback.on_rollout_end()
        return True

    def _play(self, games: VectorGame, buffer: ScreenRolloutBuffer) -> list[EpisodeEnd]:
        """Play a rollout into the buffer and return where episodes ended, in order of time."""
        ends: list[EpisodeEnd] = []
        last_ended = self._last_episode_starts.copy()
        for step in range(buffer.buffer_size + 1):
            for part, part_games in enumerate(games.parts):
                if step:
                    played = games.step_wait(part)
                    buffer.put_screens(step, part_games, played.observations)
                    last_ended[part_games.start : part_games.stop] = played.ended
                    ends += [
                        EpisodeEnd(
                            step - 1,
                            game,
                            played.terminal_observations[game.game - part_games.start].copy(),
                        )
                        for game in played.finished
                    ]
                if step < buffer.buffer_size:
                    games.step_async(self._act(buffer, step, part_games), part)
            if step:
                self.num_timesteps += games.n_games
                self._on_step()
            if step < buffer.buffer_size:
                buffer.episode_starts[step] = last_ended
        self._last_episode_starts = last_ended
        return ends

    def _act(self, buffer: ScreenRolloutBuffer, step: int, games: range) -> npt.NDArray[np.int64]:
        """Sample the actions of some games in a step, int64 (games,), and store them."""
        with torch.inference_mode():
            inputs = buffer.screens_of(step, games)
            if self.recipe.freeze_convolutions:
                inputs = self._convolve(inputs)
                self._convolved.append(inputs)
            logits, values = self._forward_on_cpu(inputs)
            log_all = logits.log_softmax(1)
            actions = torch.multinomial(log_all.exp(), 1, generator=self.generators.actions)
            log_probs = log_all.gather(1, actions)[:, 0]
        sampled: npt.NDArray[np.int64] = actions[:, 0].numpy()
        buffer.put_actions(step, games, sampled, values, log_probs)
        return sampled

    def _forward_on_cpu(self, observations: Tensor) -> tuple[Tensor, Tensor]:
        """Return the policy's logits and values on the CPU, where actions are sampled."""
        logits, values = self._forward(self.policy, observations)
        return logits.cpu(), values.cpu()

    def _forward(self, policy: ScreenPolicy, inputs: Tensor) -> tuple[Tensor, Tensor]:
        """Return a policy's logits and values of screens, or of what ``_inputs`` makes of them."""
        return policy.heads(self._features(policy, inputs))

    def _features(self, policy: ScreenPolicy, inputs: Tensor) -> Tensor:
        """Return a policy's features, in the precision of this training."""
        device = device_of(policy)
        with self._precision.autocast(device):
            if inputs.dim() == 2:
                return policy.features_extractor.features_of(inputs.to(device))
            return policy.extract_features(inputs.to(device))

    def _convolve(self, screens: Tensor) -> Tensor:
        """Return the outputs of the policy's convolutions for screens, (N, channels * 7 * 7)."""
        device = device_of(self.policy)
        with self._precision.autocast(device):
            return self.policy.features_extractor.convolve(screens.to(device))

    def _inputs(self) -> Tensor:
        """Return the policy's inputs: the rollout's screens.

        Where the convolutions are frozen, what they made of the screens when the policy acted: it
        is the same in every epoch, and for the start policy.
        """
        if not self.recipe.freeze_convolutions:
            return self.rollout_buffer.screens
        return torch.cat(self._convolved)

    def _bootstrap(self, rewards: npt.NDArray[np.float32], ends: Sequence[EpisodeEnd]) -> None:
        """Add the discounted value of the last state to rewards of truncated episodes, in place.

        As stable-baselines3 does (Pardo et al. 2018).
        """
        cut = [end for end in ends if end.is_truncated]
        if not cut:
            return
        last = channels_last_screens(np.stack([end.last_observation for end in cut]))
        with torch.inference_mode():
            values = self._forward_on_cpu(last)[1]
        for end, value in zip(cut, values.tolist(), strict=True):
            rewards[end.step, end.game.game] += self.gamma * value

    @property
    def is_warming_up(self) -> bool:
        """Whether only the critic learns at present."""
        return 0 < self.num_timesteps <= self.recipe.critic_warm_up_steps

    @property
    def current_kl_coef(self) -> float:
        """Coefficient of the KL divergence from the start policy, annealed linearly to zero."""
        return self.recipe.kl_coef * max(0.0, 1.0 - self.num_timesteps / self.steps)

    def train(self) -> None:
        """Learn from the rollout; see PPO.train."""
        self.policy.set_training_mode(True)
        self._update_learning_rate(self.policy.optimizer)
        kl_coef = self.current_kl_coef if self.start_policy is not None else 0.0
        inputs = self._inputs()
        start_log_probs = None
        if kl_coef and not self.is_warming_up:
            start_log_probs = self._start_log_probs(inputs)
        minibatch_stats: list[Tensor] = []
        rng = self.generators.minibatches
        for _ in range(self.n_epochs):
            for minibatch in self.rollout_buffer.minibatches(inputs, self.batch_size, rng):
                if self.is_warming_up:
                    loss, stats = self._critic_loss(minibatch)
                else:
                    loss, stats = self._loss(minibatch, start_log_probs, kl_coef)
                self.policy.optimizer.zero_grad()
                loss.backward()  # type: ignore[no-untyped-call]
                norm = torch.nn.utils.clip_grad_norm_(self.policy.parameters(), self.max_grad_norm)
                check_finite("gradient of the imitator", norm, loss)
                self.policy.optimizer.step()
                minibatch_stats.append(stats)
                self._on_step()
            self._n_updates += 1
        means = torch.stack(minibatch_stats).mean(0).tolist()
        names = ("policy_loss", "value_loss", "entropy", "kl", "clip_fraction", "kl_to_start")
        self.update_metrics = dict(zip(names, means, strict=True))

    def _loss(
        self, minibatch: Minibatch, start_log_probs: Tensor | None, kl_coef: float
    ) -> tuple[Tensor, Tensor]:
        """Return PPO's loss of a minibatch, and its statistics in the order of update_metrics."""
        logits, values = self._forward(self.policy, minibatch.inputs)
        log_all = logits.log_softmax(1)
        log_probs = log_all.gather(1, minibatch.actions[:, None])[:, 0]
        advantages = minibatch.advantages
        # One step has no standard deviation, see stable-baselines3's #1028.
        if len(advantages) > 1:
            advantages = (advantages - advantages.mean()) / (advantages.std() + 1e-8)
        log_ratio = log_probs - minibatch.old_log_probs
        ratio = log_ratio.exp()
        low, high = 1.0 - self.recipe.clip_range, 1.0 + self.recipe.clip_range
        policy_loss = -torch.min(advantages * ratio, advantages * ratio.clamp(low, high)).mean()
        value_loss = F.mse_loss(minibatch.returns, values)
        entropy = -(log_all.exp() * log_all).sum(1).mean()
        loss = policy_loss - self.ent_coef * entropy + self.vf_coef * value_loss
        kl_to_start = loss.new_zeros(())
        if start_log_probs is not None:
            target = start_log_probs[minibatch.indices]
            kl_to_start = F.kl_div(log_all, target, reduction="batchmean", log_target=True)
            loss = loss + kl_coef * kl_to_start
        with torch.no_grad():
            kl = (ratio - 1.0 - log_ratio).mean()
            clip_fraction = ((ratio - 1.0).abs() > self.recipe.clip_range).float().mean()
            stats = [policy_loss, value_loss, entropy, kl, clip_fraction, kl_to_start]
            return loss, torch.stack(stats)

    def _critic_loss(self, minibatch: Minibatch) -> tuple[Tensor, Tensor]:
        """Return the loss of the value head alone, which leaves the policy unchanged."""
        with torch.no_grad():
            features = self._features(self.policy, minibatch.inputs)
        logits, values = self.policy.heads(features)
        log_all = logits.detach().log_softmax(1)
        entropy = -(log_all.exp() * log_all).sum(1).mean()
        value_loss = F.mse_loss(minibatch.returns, values)
        zero = value_loss.new_zeros(())
        stats = torch.stack([zero, value_loss.detach(), entropy, zero, zero, zero])
        return self.vf_coef * value_loss, stats

    def _start_log_probs(self, inputs: Tensor) -> Tensor:
        """Return the start policy's log probabilities over the rollout, float32 (N, 6)."""
        assert self.start_policy is not None
        size = forward_batch(device_of(self.start_policy))
        parts = []
        with torch.no_grad():
            for part in torch.split(inputs, size):
                logits, _ = self._forward(self.start_policy, part)
                parts.append(logits.log_softmax(1))
                self._on_step()
        return torch.cat(parts)
