"""Checkpoints of a PPO training: everything that its future depends on, in one file.

A training that is killed and goes on from its checkpoint ends with the same weights, bit by bit,
as one that was not, given the same number of threads, on the processor. A GPU may round otherwise.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import torch
from safetensors import SafetensorError, safe_open
from safetensors.torch import save
from torch import Tensor

from trainer.nn.optimizers import optimizer_tensors, restore_optimizer
from trainer.policy.ppo import ImitationPPO
from trainer.policy.vec_env import TrilVecEnv
from tril.errors import Invalid
from tril.files.artifact_store import write_whole

FORMAT = "tril-ppo-checkpoint"
FORMAT_VERSION = 1


def save_checkpoint(
    path: Path,
    ppo: ImitationPPO,
    env: TrilVecEnv,
    extra: dict[str, Any],
    beside: Mapping[str, Tensor] | None = None,
) -> None:
    """Write a checkpoint; call it between two rollouts only.

    Args:
        path: The file, replaced whole.
        ppo: The training.
        env: Its games.
        extra: What else is to be kept, JSON-ready.
        beside: Tensors of what learns beside the policy.
    """
    arrays = {f"games/{name}": array for name, array in env.save().items()}
    arrays["last/observations"] = ppo._last_obs
    arrays["last/episode_starts"] = ppo._last_episode_starts
    tensors = {name: torch.from_numpy(np.array(array)) for name, array in arrays.items()}
    tensors |= {f"policy/{name}": t for name, t in _own_tensors(ppo).items()}
    adam = optimizer_tensors(ppo.policy.optimizer, list(ppo.policy.parameters()))
    tensors |= {f"optimizer/{name}": t for name, t in adam.items()}
    tensors |= {f"beside/{name}": tensor for name, tensor in (beside or {}).items()}
    tensors["draws/actions"] = ppo.draws.actions.get_state()
    state = {
        "steps": ppo.num_timesteps,
        "updates": ppo._n_updates,
        "order": ppo.draws.order.bit_generator.state,
        "extra": extra,
    }
    metadata = {"format": FORMAT, "version": str(FORMAT_VERSION), "state": json.dumps(state)}
    write_whole(path, save({name: t.contiguous() for name, t in tensors.items()}, metadata))


def load_checkpoint(
    path: Path, ppo: ImitationPPO, env: TrilVecEnv
) -> tuple[dict[str, Any], dict[str, Tensor]]:
    """Put a training where its checkpoint was; returns ``extra`` and ``beside``.

    Args:
        path: The file.
        ppo: A training made with the same recipe, as yet untrained.
        env: Its games, not begun.

    Raises:
        Invalid: The file is no checkpoint of this version.
    """
    try:
        with safe_open(str(path), framework="pt") as file:
            metadata = file.metadata() or {}
            if (metadata.get("format"), metadata.get("version")) != (FORMAT, str(FORMAT_VERSION)):
                raise Invalid(
                    f"{path} is no checkpoint that this version can go on from. Remove it and the"
                    " training begins anew."
                )
            state = json.loads(metadata["state"])
            tensors = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118
    except SafetensorError as error:
        raise Invalid(f"{path} cannot be read: {error}. Remove it to begin anew.") from error
    groups: dict[str, dict[str, Tensor]] = {}
    for name, tensor in tensors.items():
        group, _, rest = name.partition("/")
        groups.setdefault(group, {})[rest] = tensor
    with torch.no_grad():
        for name, parameter in ppo.policy.named_parameters():
            parameter.copy_(groups["policy"][name])
    restore_optimizer(
        ppo.policy.optimizer, list(ppo.policy.parameters()), groups.get("optimizer", {})
    )
    ppo.draws.actions.set_state(groups["draws"]["actions"])
    ppo.draws.order.bit_generator.state = state["order"]
    ppo.num_timesteps = state["steps"]
    ppo._n_updates = state["updates"]
    env.restore({name: tensor.numpy() for name, tensor in groups["games"].items()})
    ppo._last_obs = groups["last"]["observations"].numpy()
    ppo._last_episode_starts = groups["last"]["episode_starts"].numpy()
    return state["extra"], groups.get("beside", {})


def _own_tensors(ppo: ImitationPPO) -> dict[str, Tensor]:
    # Not state_dict: that has the features extractor under three names.
    return {name: tensor.detach() for name, tensor in ppo.policy.named_parameters()}
