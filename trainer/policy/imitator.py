"""The imitator: a policy trained by PPO on the learned reward (TRIL, algorithm 1, step 3)."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch
from stable_baselines3.common.callbacks import BaseCallback

from trainer.nn.devices import CPU
from trainer.nn.precision import Precision
from trainer.policy.checkpoint import load_checkpoint, save_checkpoint
from trainer.policy.cloning import best_demonstrations
from trainer.policy.discriminator import Discriminator
from trainer.policy.evaluation import play
from trainer.policy.networks import Policy, ScreenPolicy, load_network, save_policy
from trainer.policy.ppo import Draws, ImitationPPO
from trainer.policy.reward_shaping import RewardShaping
from trainer.policy.vec_env import FinishedEpisode, TrilVecEnv
from trainer.progress import Progress, Ticking
from trainer.reward.model import RewardModel
from tril.behaviours import Behaviour, score
from tril.errors import Invalid
from tril.files.artifact_store import write_whole
from tril.game.episode import Ending, Hit
from tril.game.starts import TRAINING_IDLE_FRAMES, Start, evaluation_start, spread_starts
from tril.game.vector.vector_game import DemonstrationLog, TrainingStarts, VectorGame
from tril.recipes import Recipe
from tril.recording import Recording

CHECKPOINT_EVERY_S = 45.0
"""A killed training loses at most this and one rollout."""

CURVE_EPISODES = 50
"""Whole games over which the curves are averaged."""

_CHECKPOINT = "checkpoint.safetensors"
_BEST = "best.zip"


@dataclass(frozen=True)
class ImitationTask:
    """What an imitator is trained from.

    Attributes:
        model: The learned reward.
        recordings: The ranked demonstrations.
        tiers: Indices into them, best tier first.
        perfect: The recordings marked as perfect; as in the best ranked ones, games may begin in
            them.
        clone: File of the run's clone, which a warm start begins with.
        recipe: How it is trained.
        steps: Steps of the training games, rounded up to whole rollouts.
        training_seed: Feeds every random choice.
        behaviour: For the curves of hits only; learning never looks at it.
    """

    model: RewardModel
    recordings: Sequence[Recording]
    tiers: Sequence[Sequence[int]]
    recipe: Recipe
    steps: int
    training_seed: int
    behaviour: Behaviour | None = None
    perfect: Sequence[Recording] = ()
    clone: Path | None = None


@dataclass(frozen=True)
class SnapshotScore:
    """How good the policy was in the middle of its training.

    Attributes:
        steps: After how many steps of the training games.
        predicted_return: Mean over games from training starts of what the learned reward pays, in
            the shape that the policy is trained on: with the unbounded raw R, whose offset is
            arbitrary, dying early may look best. With GAIL, of what its discriminator pays then.
    """

    steps: int
    predicted_return: float


@dataclass(frozen=True)
class ImitatorResult:
    """What a training gave.

    Attributes:
        snapshots: The policies that were compared, in the order of their steps.
        best_steps: After how many steps the saved policy, the best of them, was taken.
        precision: The numbers that it learned in.
    """

    snapshots: tuple[SnapshotScore, ...]
    best_steps: int
    precision: Precision


def train_imitator(
    task: ImitationTask,
    path: Path,
    checkpoint_folder: Path,
    progress: Progress,
    *,
    n_processes: int | None = None,
    precision: Precision = Precision.FLOAT32,
    device: torch.device = CPU,
    discriminator: Discriminator | None = None,
) -> ImitatorResult:
    """Train an imitator by PPO, or go on training it, and save the best snapshot.

    Args:
        task: What it is trained from.
        path: Where the policy is saved, for plain ``PPO.load``.
        checkpoint_folder: An existing folder of this training alone. What a training that was
            killed left there is gone on from.
        progress: Told of steps, with the curves after every rollout.
        n_processes: As of VectorGame; changes the speed only.
        precision: The numbers that the policy's layers multiply while it learns.
        device: Where the policy is learned and the rewards are computed.
        discriminator: Takes the place of the learned reward, and learns after each rollout.

    Raises:
        RunCancelled: Raised by ``progress``.
    """
    recipe = task.recipe.policy
    progress_at = _Reporter(task, progress, paid_by_model=discriminator is None)
    checkpoint = checkpoint_folder / _CHECKPOINT
    if not checkpoint.exists():
        progress_at.tick()
    # The discriminator's own model, which changes with it.
    model = discriminator.model if discriminator else task.model.on(device)
    payment = RewardShaping.of(model, recipe)
    games = VectorGame(
        recipe.n_envs,
        _training_starts(task),
        n_processes=n_processes,
        ending=Ending(task.recipe.ending),
        training_seed=task.training_seed,
    )
    with games:
        env = TrilVecEnv(games, payment)
        ppo = ImitationPPO(
            env,
            recipe,
            task.steps,
            Draws.of(task.training_seed),
            progress_at.tick,
            progress_at.add_episode,
            precision,
            device,
        )
        progress_at.ppo = ppo
        training = _Training(task, ppo, env, checkpoint_folder, progress_at, discriminator)
        training.begin()
        ppo.learn(
            max(0, task.steps - ppo.num_timesteps),
            callback=training,
            log_interval=None,  # type: ignore[arg-type]
            reset_num_timesteps=False,
        )
        training.end()
    write_whole(path, (checkpoint_folder / _BEST).read_bytes())
    return ImitatorResult(tuple(training.snapshots), training.best_steps, precision)


def _start_network(task: ImitationTask) -> ScreenPolicy:
    """Return the clone that a warm start begins with.

    Raises:
        Invalid: There is none, or its network is another one than the imitator's.
    """
    clone, own = task.recipe.cloning.network, task.recipe.policy.network
    if task.clone is None or clone != own:
        raise Invalid(
            f"A warm start begins with the run's clone, of the same network; the recipe's clone is"
            f" {clone!r}, its imitator {own!r}."
        )
    return load_network(task.clone)


def _training_starts(task: ImitationTask) -> TrainingStarts:
    idle_frames = idle_frames_of(task.recipe)
    share = task.recipe.policy.demonstration_share
    if not share:
        return TrainingStarts(idle_frames)
    best = best_demonstrations(task.tiers, task.recipe.policy.best_share)
    logs = [
        DemonstrationLog(recording.start, recording.actions)
        for recording in (*(task.recordings[i] for i in best), *task.perfect)
        if recording.actions
    ]
    return TrainingStarts(idle_frames, tuple(logs), share)


class _Reporter:
    """Keeps what the curves show and passes it on."""

    def __init__(self, task: ImitationTask, progress: Progress, paid_by_model: bool) -> None:
        self._task = task
        self._progress = progress
        self._paid_by_model = paid_by_model
        self.ppo: ImitationPPO | None = None
        self.recent: deque[dict[str, float]] = deque(maxlen=CURVE_EPISODES)
        self._since = time.monotonic()
        self._steps_since = 0

    @property
    def steps(self) -> int:
        """Steps done."""
        return min(self.ppo.num_timesteps, self._task.steps) if self.ppo else 0

    def tick(self) -> None:
        """Say where the training is; a cancelled run stops here."""
        self._progress.advance(self.steps, self._task.steps)

    def add_episode(self, episode: FinishedEpisode) -> None:
        """Note an episode that has ended; those begun in a demonstration are left out."""
        if not episode.is_whole:
            return
        values = {"paid_return": episode.paid}
        if self._paid_by_model:
            values["predicted_return"] = episode.predicted_return
        game = episode.game
        values |= game_values(self._task.behaviour, episode.n_steps, game.hits, episode.died)
        self.recent.append(values)

    def rate(self) -> float:
        """Return the steps per second since this was last asked."""
        assert self.ppo is not None
        now = time.monotonic()
        steps = self.ppo.num_timesteps - self._steps_since
        result = steps / max(1e-9, now - self._since)
        self._since, self._steps_since = now, self.ppo.num_timesteps
        return result

    def report_rollout(self, beside: Mapping[str, float]) -> None:
        """Pass the curves' next point on, with what was found of something that learns beside."""
        assert self.ppo is not None
        values = {"steps_per_s": self.rate(), **beside}
        values |= {
            name: value
            for name, value in self.ppo.update_values.items()
            if name in {"entropy", "value_loss", "kl", "pull"}
        }
        if self.recent:
            names = self.recent[-1]
            values |= {name: float(np.mean([e[name] for e in self.recent])) for name in names}
        self._progress.advance(self.steps, self._task.steps, values)


class _Training(BaseCallback):
    """What happens between two rollouts: curves, snapshots, checkpoints."""

    def __init__(
        self,
        task: ImitationTask,
        ppo: ImitationPPO,
        env: TrilVecEnv,
        folder: Path,
        reporter: _Reporter,
        discriminator: Discriminator | None,
    ) -> None:
        super().__init__()
        self._discriminator = discriminator
        self._task = task
        self._ppo = ppo
        self._env = env
        self._folder = folder
        self._reporter = reporter
        self._saved_at = time.monotonic()
        self._rollouts = 0
        self.snapshots: list[SnapshotScore] = []

    @property
    def best_steps(self) -> int:
        """Steps of the best snapshot; of equally good ones the latest."""
        return max(self.snapshots, key=lambda s: (s.predicted_return, s.steps)).steps

    def begin(self) -> None:
        """Take the checkpoint up, or make the first policy."""
        ppo, folder = self._ppo, self._folder
        if (folder / _CHECKPOINT).exists():
            extra, beside = load_checkpoint(folder / _CHECKPOINT, ppo, self._env)
            if self._discriminator:
                self._discriminator.restore(extra["discriminator_rounds"], beside)
            self.snapshots = [SnapshotScore(**snapshot) for snapshot in extra["snapshots"]]
            self._reporter.recent.extend(extra["recent"])
            self._reporter.rate()
        if self._task.recipe.policy.warm_start:
            start = _start_network(self._task).to(ppo.device)
            if self._task.recipe.policy.kl_coef:
                ppo.start_policy = start
            if not ppo.num_timesteps:
                ppo.policy.load_state_dict(start.state_dict())
        self._reporter.tick()

    def _on_rollout_start(self) -> None:
        if self._rollouts:
            self._between_rollouts()
        self._rollouts += 1

    def _between_rollouts(self) -> None:
        self._reporter.report_rollout(self._learn_beside())
        done = self._ppo.num_timesteps
        last = max((s.steps for s in self.snapshots), default=0)
        is_due = any(last < due <= done for due in self._task.recipe.policy.snapshot_steps)
        if is_due or (done >= self._task.steps and last < done):
            self._take_snapshot()
        if is_due or time.monotonic() - self._saved_at >= CHECKPOINT_EVERY_S:
            self._save()

    def _learn_beside(self) -> dict[str, float]:
        """Let the discriminator learn from the rollout that the policy has just learned from."""
        if self._discriminator is None:
            return {}
        screens = self._ppo.rollout_buffer.screens
        return self._discriminator.learn(screens, self._reporter.tick)

    def end(self) -> None:
        """Do what is due after the last rollout."""
        if self._rollouts:
            self._between_rollouts()
        if not self.snapshots:
            self._take_snapshot()
        self._save()

    def _take_snapshot(self) -> None:
        """Judge the policy by the learned reward on training starts; keep it if it is the best."""
        self._ppo.policy.set_training_mode(False)
        policy = Policy(self._ppo.policy)
        judged = judge(policy, self._env.payment, self._task.recipe, self._reporter.tick)
        self.snapshots.append(SnapshotScore(self._ppo.num_timesteps, judged))
        if self.best_steps == self._ppo.num_timesteps:
            save_policy(self._ppo.policy, self._folder / _BEST)

    def _save(self) -> None:
        extra: dict[str, Any] = {
            "snapshots": [asdict(snapshot) for snapshot in self.snapshots],
            "recent": list(self._reporter.recent),
        }
        beside = None
        if self._discriminator:
            extra["discriminator_rounds"] = self._discriminator.rounds
            beside = self._discriminator.tensors()
        save_checkpoint(self._folder / _CHECKPOINT, self._ppo, self._env, extra, beside)
        self._saved_at = time.monotonic()

    def _on_step(self) -> bool:
        return True


def game_values(
    behaviour: Behaviour | None, n_steps: int, hits: Sequence[Hit], died: bool
) -> dict[str, float]:
    """Return what the curves show of a training game; hits where the behaviour has targets."""
    values = {"episode_steps": float(n_steps), "death_rate": float(died)}
    cells = tuple((hit.row, hit.column) for hit in hits)
    scored = score(behaviour, cells) if behaviour else None
    if scored is not None:
        values |= {"hits": float(scored.targets), "strays": float(scored.strays)}
    return values


def judge(
    policy: Policy, payment: RewardShaping, recipe: Recipe, tick: Callable[[], None]
) -> float:
    """Return the mean of what a policy's greedy games from training starts are paid.

    Args:
        policy: The policy.
        payment: What pays.
        recipe: How many games, and what ends them.
        tick: Called after every step of the games; what it raises ends them.
    """
    games = play(
        policy,
        judging_starts(recipe),
        "greedy",
        model=payment.model,
        ending=Ending(recipe.ending),
        progress=Ticking(tick),
    )
    totals = [payment.total(game.rewards, game.end) for game in games if game.rewards is not None]
    return float(np.mean(totals))


def judging_starts(recipe: Recipe) -> list[Start]:
    """Return starts of the training games, spread over all of them, to judge snapshots by."""
    return spread_starts(recipe.policy.snapshot_episodes, idle_frames_of(recipe))


def idle_frames_of(recipe: Recipe) -> tuple[int, ...]:
    """Return the idle frames that whole training games begin with."""
    own = tuple(evaluation_start(number).idle_frames for number in recipe.policy.own_starts)
    return own or TRAINING_IDLE_FRAMES
