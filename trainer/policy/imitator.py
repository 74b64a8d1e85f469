"""The imitator: a policy trained by PPO on the learned reward (TRIL, algorithm 1, step 3)."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np
import torch
from stable_baselines3.common.callbacks import BaseCallback

from trainer.nn.checkpoints import CheckpointDamaged
from trainer.nn.devices import CPU
from trainer.nn.precision import Precision
from trainer.policy.checkpoint import load_checkpoint, save_checkpoint
from trainer.policy.discriminator import Discriminator
from trainer.policy.imitation import (
    ImitationTask,
    ImitatorResult,
    Snapshot,
    SnapshotScore,
    best_mixture,
    best_snapshot,
    episode_metrics,
    evaluate_snapshot,
    training_starts,
)
from trainer.policy.networks import Policy, ScreenPolicy, load_network, save_policy
from trainer.policy.ppo import ImitationPPO, TrainingGenerators
from trainer.policy.reward_shaping import RewardShaping
from trainer.policy.vec_env import FinishedEpisode, TrilVecEnv
from trainer.progress import Progress
from tril.errors import Invalid
from tril.files.artifact_store import write_whole
from tril.play.vector.vector_game import DemonstrationLog, TrainingStarts, VectorGame
from tril.ranking import best_ranked
from tril.recording import Recording, replay

CHECKPOINT_INTERVAL_S = 45.0
"""A killed training loses at most this and one rollout."""

CURVE_EPISODES = 50
"""Whole games that a point of the curves averages."""

N_PARTS = 2
"""That the games are divided into: while one is played, actions are chosen for the other."""

_CHECKPOINT = "checkpoint.safetensors"
_BEST = "best.zip"


def train_imitator(
    task: ImitationTask,
    path: Path,
    checkpoint_folder: Path,
    progress: Progress,
    *,
    n_processes: int | None = None,
    precision: Precision = Precision.FLOAT32,
    device: torch.device = CPU,
    on_snapshot: Callable[[Snapshot], None] = lambda _: None,
) -> ImitatorResult:
    """Train an imitator by PPO and save its best snapshot.

    The policy of a warm start is one of them, so that what is saved is no worse by the reward.

    With the recipe's method "gail", a discriminator of the perfect demonstrations takes the place
    of the learned reward and learns after each rollout.

    Args:
        task: Behaviour, reward and demonstrations to train from.
        path: Where the policy is saved, for plain ``PPO.load``.
        checkpoint_folder: An existing folder of this training alone, from which an interrupted
            training continues.
        progress: Counts training steps; receives the curves after every rollout.
        n_processes: See VectorGame; affects the speed only.
        precision: Precision of the policy's layers while it learns.
        device: Device to learn and to compute rewards on.
        on_snapshot: Called with every snapshot that is taken.

    Raises:
        Invalid: A warm start has no policy of the imitator's network to begin with, or GAIL no
            perfect demonstration, or the recipe is of an earlier version that trained imitators in
            another way.
        CheckpointDamaged: The checkpoint differs from what was written.
        NotFinite: Learning has diverged.
        RunCancelled: Raised by ``progress``.
    """
    recipe = task.recipe.policy
    if task.recipe.method not in {"ppo", "gail"}:
        raise Invalid(
            f"This training's recipe trains the imitator by the method {task.recipe.method!r},"
            " which this version of Tril no longer has. Begin a new training with today's recipes."
        )
    discriminator = Discriminator.of(task, device) if task.recipe.method == "gail" else None
    reporter = _Reporter(task, progress)
    if not (checkpoint_folder / _CHECKPOINT).exists():
        reporter.on_step()
    # The discriminator's own model, not a copy, since it changes.
    model = discriminator.model if discriminator else task.model.on(device)
    games = VectorGame(
        task.game,
        recipe.n_envs,
        _training_starts(task),
        n_processes=n_processes,
        n_parts=N_PARTS,
        end_rule=task.game.known_end_rule(task.recipe.ending),
        sticky_action_probability=recipe.sticky_action_probability,
        training_seed=task.training_seed,
    )
    with games:
        env = TrilVecEnv(games, RewardShaping.of(model, recipe))
        ppo = ImitationPPO(
            env,
            recipe,
            task.steps,
            TrainingGenerators.from_seed(task.training_seed),
            reporter.on_step,
            reporter.on_episode,
            precision,
            device,
        )
        reporter.ppo = ppo
        callback = _TrainingCallback(
            task, ppo, env, checkpoint_folder, reporter, discriminator, on_snapshot
        )
        callback.restore_or_start()
        ppo.learn(
            max(0, task.steps - ppo.num_timesteps),
            callback=callback,
            log_interval=None,  # type: ignore[arg-type]
            reset_num_timesteps=False,
        )
        callback.finish()
    best = checkpoint_folder / _BEST
    try:
        # Its zip has a checksum of each member.
        load_network(best)
    except (Invalid, FileNotFoundError) as error:
        raise CheckpointDamaged(checkpoint_folder / _CHECKPOINT, error) from error
    write_whole(path, best.read_bytes())
    snapshots = callback.snapshots
    return ImitatorResult(tuple(snapshots), best_snapshot(snapshots).steps, precision)


def _start_network(task: ImitationTask, imitator: ScreenPolicy) -> ScreenPolicy:
    """Return the policy that a warm start begins with.

    Raises:
        Invalid: There is none, or its network differs from the imitator's.
    """
    if task.start_policy is None:
        raise Invalid("A warm start needs a policy to begin with, such as the run's clone.")
    start = load_network(task.start_policy)
    if start.features_extractor.features_dim != imitator.features_extractor.features_dim:
        raise Invalid(
            f"A warm start begins with a policy of the imitator's network, which is"
            f" {task.recipe.policy.network!r}; {task.start_policy.name} has another one."
        )
    return start


def _training_starts(task: ImitationTask) -> TrainingStarts:
    starts = training_starts(task.game, task.recipe)
    share = task.recipe.policy.demonstration_share
    opening_share = task.recipe.policy.opening_share
    if not share or not task.game.saves_states:
        return TrainingStarts(task.game, starts, opening_share=opening_share)
    best = best_ranked(task.tiers, task.recipe.policy.best_share)
    end_rule = task.game.known_end_rule(task.recipe.ending)
    logs = [
        DemonstrationLog(task.game, recording.start, _truncated_actions(end_rule, recording))
        for recording in (*(task.recordings[i] for i in best), *task.perfect)
        if recording.actions
    ]
    return TrainingStarts(task.game, starts, tuple(logs), share, opening_share)


def _truncated_actions(end_rule: str, recording: Recording) -> bytes:
    """Return a recording's actions up to the end of the game under another end rule.

    By the count of lives a game continues for two seconds after the player's death. Where the
    death ends the game, nothing can be learned from them.
    """
    if recording.end_rule == end_rule:
        return recording.actions
    return recording.until(replay(replace(recording, end_rule=end_rule)).n_frames).actions


class _Reporter:
    """Collects what the curves show and passes it on."""

    def __init__(self, task: ImitationTask, progress: Progress) -> None:
        self._task = task
        self._progress = progress
        self.ppo: ImitationPPO | None = None
        self.recent: deque[dict[str, float]] = deque(maxlen=CURVE_EPISODES)
        self._since = time.monotonic()
        self._steps_since = 0

    @property
    def steps(self) -> int:
        """Training steps done."""
        return min(self.ppo.num_timesteps, self._task.steps) if self.ppo else 0

    def on_step(self) -> None:
        """Report the steps done; a cancelled run stops here."""
        self._progress.advance(self.steps, self._task.steps)

    def on_episode(self, episode: FinishedEpisode) -> None:
        """Add a finished episode to the curves, unless it began in a demonstration."""
        if not episode.is_whole:
            return
        values = {"shaped_return": episode.shaped_return}
        if self._task.recipe.method != "gail":
            values["predicted_return"] = episode.predicted_return
        game = episode.game
        values |= episode_metrics(self._task.behaviour, episode.n_steps, game.taken, episode.died)
        self.recent.append(values)

    def steps_per_s(self) -> float:
        """Return the steps per second since the last call."""
        assert self.ppo is not None
        now, steps = time.monotonic(), self.ppo.num_timesteps
        rate = (steps - self._steps_since) / max(1e-9, now - self._since)
        self._since, self._steps_since = now, steps
        return rate

    def report_rollout(self, discriminator_metrics: Mapping[str, float]) -> None:
        """Report a point of the curves."""
        assert self.ppo is not None
        values = {"steps_per_s": self.steps_per_s(), **discriminator_metrics}
        values |= {
            name: value
            for name, value in self.ppo.update_metrics.items()
            if name in {"entropy", "value_loss", "kl", "kl_to_start"}
        }
        if self.recent:
            # Episodes in the checkpoint of an earlier version may lack a name.
            for name in self.recent[-1]:
                values[name] = float(
                    np.mean([metrics[name] for metrics in self.recent if name in metrics])
                )
        self._progress.advance(self.steps, self._task.steps, values)


class _TrainingCallback(BaseCallback):
    """Reports curves, takes snapshots and saves checkpoints between rollouts."""

    def __init__(
        self,
        task: ImitationTask,
        ppo: ImitationPPO,
        env: TrilVecEnv,
        folder: Path,
        reporter: _Reporter,
        discriminator: Discriminator | None,
        on_snapshot: Callable[[Snapshot], None],
    ) -> None:
        super().__init__()
        self._on_snapshot = on_snapshot
        self._discriminator = discriminator
        self._task = task
        self._ppo = ppo
        self._env = env
        self._folder = folder
        self._reporter = reporter
        self._saved_at = time.monotonic()
        self._rollouts = 0
        self.snapshots: list[SnapshotScore] = []

    def restore_or_start(self) -> None:
        """Continue from the checkpoint, or begin with the start policy for a warm start."""
        ppo, path = self._ppo, self._folder / _CHECKPOINT
        if path.exists():
            extra, discriminator_tensors = load_checkpoint(path, ppo, self._env)
            if self._discriminator:
                self._discriminator.restore(extra["discriminator_rounds"], discriminator_tensors)
            self.snapshots = [SnapshotScore(**snapshot) for snapshot in extra["snapshots"]]
            self._reporter.recent.extend(extra["recent"])
            self._reporter.steps_per_s()
        if self._task.recipe.policy.warm_start:
            start = _start_network(self._task, ppo.policy).to(ppo.device)
            if self._task.recipe.policy.kl_coef:
                ppo.start_policy = start
            if not ppo.num_timesteps:
                ppo.policy.load_state_dict(self._initial_policy(start).state_dict())
                if self._discriminator is None:
                    # PPO may lose what its start has learned; GAIL's reward changes by then.
                    self._evaluate()
        self._reporter.on_step()

    def _initial_policy(self, start: ScreenPolicy) -> ScreenPolicy:
        """Return the policy that PPO begins with: the start policy, or a mixture with it."""
        if not (self._task.recipe.policy.mixed_start and self._task.mixes_start):
            return start
        return best_mixture(self._task, start, self._env.reward_shaping, self._reporter.on_step)

    def _on_rollout_start(self) -> None:
        if self._rollouts:
            self._finish_rollout()
        self._rollouts += 1

    def _finish_rollout(self) -> None:
        self._reporter.report_rollout(self._train_discriminator())
        steps = self._ppo.num_timesteps
        last = max((s.steps for s in self.snapshots), default=0)
        is_due = any(last < step <= steps for step in self._task.recipe.policy.snapshot_steps)
        if is_due or (steps >= self._task.steps and last < steps):
            self._take_snapshot()
        if is_due or time.monotonic() - self._saved_at >= CHECKPOINT_INTERVAL_S:
            self._save()

    def _train_discriminator(self) -> dict[str, float]:
        """Train GAIL's discriminator on the rollout that the policy has just learned from."""
        if self._discriminator is None:
            return {}
        screens = self._ppo.rollout_buffer.screens
        return self._discriminator.learn(screens, self._reporter.on_step)

    def finish(self) -> None:
        """Do what is due after the last rollout."""
        if self._rollouts:
            self._finish_rollout()
        if not any(snapshot.steps for snapshot in self.snapshots):
            self._take_snapshot()
        self._save()

    def _take_snapshot(self) -> None:
        """Evaluate the policy, keep it if it is the best, and show it."""
        self._on_snapshot(self._evaluate())

    def _evaluate(self) -> Snapshot:
        """Evaluate the policy and keep it if it is the best."""
        policy, steps = self._ppo.policy, self._ppo.num_timesteps
        policy.set_training_mode(False)
        shaping, on_step = self._env.reward_shaping, self._reporter.on_step
        predicted_return, games = evaluate_snapshot(
            self._task.game, Policy(policy), shaping, self._task.recipe, on_step
        )
        self.snapshots.append(SnapshotScore(steps, predicted_return))
        if best_snapshot(self.snapshots).steps == steps:
            save_policy(policy, self._folder / _BEST)
        return Snapshot(policy, steps, games)

    def _save(self) -> None:
        extra: dict[str, Any] = {
            "snapshots": [asdict(snapshot) for snapshot in self.snapshots],
            "recent": list(self._reporter.recent),
        }
        discriminator_tensors = {}
        if self._discriminator:
            extra["discriminator_rounds"] = self._discriminator.rounds
            discriminator_tensors = self._discriminator.tensors()
        path = self._folder / _CHECKPOINT
        save_checkpoint(path, self._ppo, self._env, extra, discriminator_tensors)
        self._saved_at = time.monotonic()

    def _on_step(self) -> bool:
        return True
