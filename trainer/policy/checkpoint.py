"""Checkpoints of a PPO training: everything that its future depends on, in one file.

A training that is killed and continues from its checkpoint ends with the same weights, bit by bit,
as an uninterrupted one, on the CPU with the same number of threads. A GPU may round differently.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import torch
from safetensors import SafetensorError
from torch import Tensor

from trainer.nn.checkpoints import (
    CheckpointDamaged,
    load_tensors,
    optimizer_tensors,
    prefixed,
    restore_optimizer,
    save_tensors,
    split_by_prefix,
)
from trainer.policy.ppo import ImitationPPO
from trainer.policy.vec_env import TrilVecEnv
from tril.errors import Invalid

FORMAT = "tril-ppo-checkpoint"
FORMAT_VERSION = 1


def save_checkpoint(
    path: Path,
    ppo: ImitationPPO,
    env: TrilVecEnv,
    extra: dict[str, Any],
    discriminator: Mapping[str, Tensor],
) -> None:
    """Write a checkpoint, between two rollouts.

    Args:
        path: The file, replaced as a whole.
        ppo: The training.
        env: Environments of the training.
        extra: Further JSON-ready state.
        discriminator: Tensors of GAIL's discriminator; empty without one.
    """
    arrays = {f"games/{name}": array for name, array in env.save().items()}
    arrays["last/observations"] = ppo._last_obs
    arrays["last/episode_starts"] = ppo._last_episode_starts
    parameters = dict(ppo.policy.named_parameters())
    tensors = {name: torch.from_numpy(np.array(array)) for name, array in arrays.items()}
    # Not state_dict, which has the features extractor under three names.
    tensors |= prefixed("policy", {name: p.detach() for name, p in parameters.items()})
    adam = optimizer_tensors(ppo.policy.optimizer, list(parameters.values()))
    tensors |= prefixed("optimizer", adam) | prefixed("beside", discriminator)
    tensors["draws/actions"] = ppo.generators.actions.get_state()
    state = {
        "steps": ppo.num_timesteps,
        "updates": ppo._n_updates,
        "order": ppo.generators.minibatches.bit_generator.state,
        "extra": extra,
    }
    metadata = {"format": FORMAT, "version": str(FORMAT_VERSION), "state": json.dumps(state)}
    save_tensors(path, tensors, metadata)


def load_checkpoint(
    path: Path, ppo: ImitationPPO, env: TrilVecEnv
) -> tuple[dict[str, Any], dict[str, Tensor]]:
    """Restore a training from its checkpoint.

    Args:
        path: The file.
        ppo: A new training by the same recipe.
        env: Environments of the training, not reset yet.

    Returns:
        What save_checkpoint got as ``extra`` and ``discriminator``.

    Raises:
        CheckpointDamaged: The file is not as it was written.
        Invalid: It is no checkpoint of this format version.
    """
    try:
        tensors, metadata = load_tensors(path)
    except SafetensorError as error:
        raise CheckpointDamaged(path, error) from error
    if (metadata.get("format"), metadata.get("version")) != (FORMAT, str(FORMAT_VERSION)):
        raise Invalid(
            f"{path} is no checkpoint that this version can continue from. Remove it and the"
            " training begins anew."
        )
    state = json.loads(metadata["state"])
    groups = split_by_prefix(tensors)
    parameters = dict(ppo.policy.named_parameters())
    with torch.no_grad():
        for name, parameter in parameters.items():
            parameter.copy_(groups["policy"][name])
    restore_optimizer(ppo.policy.optimizer, list(parameters.values()), groups.get("optimizer", {}))
    ppo.generators.actions.set_state(groups["draws"]["actions"])
    ppo.generators.minibatches.bit_generator.state = state["order"]
    ppo.num_timesteps = state["steps"]
    ppo._n_updates = state["updates"]
    env.restore({name: tensor.numpy() for name, tensor in groups["games"].items()})
    ppo._last_obs = groups["last"]["observations"].numpy()
    ppo._last_episode_starts = groups["last"]["episode_starts"].numpy()
    return state["extra"], groups.get("beside", {})
