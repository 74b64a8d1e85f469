"""GAIL (Ho and Ermon 2016): PPO that is paid for states which look like demonstrated ones."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import torch

from trainer.nn.devices import CPU
from trainer.nn.precision import Precision
from trainer.nn.screens import channels_last_screens
from trainer.policy.discriminator import Discriminator
from trainer.policy.imitator import ImitationTask, ImitatorResult, train_imitator
from trainer.progress import Progress
from tril.errors import Invalid
from tril.game.console import Console
from tril.recording import trajectory


def train_by_gail(
    task: ImitationTask,
    path: Path,
    checkpoint_folder: Path,
    progress: Progress,
    *,
    n_processes: int | None = None,
    precision: Precision = Precision.FLOAT32,
    device: torch.device = CPU,
) -> ImitatorResult:
    """Train an imitator on the perfect demonstrations; as train_imitator in all else.

    Args:
        task: What it is trained from; the ranking and the learned reward are not looked at.
        path: As of train_imitator.
        checkpoint_folder: As of train_imitator.
        progress: As of train_imitator, with discriminator_loss and discriminator_accuracy.
        n_processes: As of train_imitator.
        precision: As of train_imitator.
        device: As of train_imitator.

    Raises:
        Invalid: There is no perfect demonstration.
        RunCancelled: Raised by ``progress``.
    """
    demonstrated, recipe = _demonstrated(task), task.recipe.gail
    discriminator = Discriminator(demonstrated, recipe, task.training_seed, device)
    return train_imitator(
        task,
        path,
        checkpoint_folder,
        progress,
        n_processes=n_processes,
        precision=precision,
        device=device,
        discriminator=discriminator,
    )


def _demonstrated(task: ImitationTask) -> torch.Tensor:
    """Return the observations in which the demonstrations acted, uint8 (N, 4, 84, 84).

    They are in channels-last order.
    """
    console = Console()
    shown = [trajectory(recording, console) for recording in task.perfect if recording.actions]
    if not shown:
        raise Invalid("GAIL needs at least one perfect demonstration to learn from.")
    # The last state is left out: the policy's rollouts have none in which a game was over either.
    return channels_last_screens(np.concatenate([one.observations[:-1] for one in shown]))
