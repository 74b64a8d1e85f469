"""The stages that learn: trajectories, reward, check of the ranking, clone, imitator."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from trainer.nn.precision import Precision
from trainer.policy.cloning import train_clone
from trainer.policy.dagger import train_by_dagger
from trainer.policy.imitation import ImitationTask
from trainer.policy.imitator import train_imitator
from trainer.policy.networks import save_policy
from trainer.progress import Progress
from trainer.reward.advice import advice, warning
from trainer.reward.check import check_ranking
from trainer.reward.reward_trainer import train_reward_model
from trainer.runtime.run_data import RunData


def replay_demonstrations(data: RunData, progress: Progress) -> dict[str, Any]:
    """Replay every demonstration of the run through an agent's eyes."""
    data.trajectories([*data.ranked, *data.perfect], progress)
    return {}


def learn_reward(data: RunData, progress: Progress) -> dict[str, Any]:
    """Learn the reward model from the ranking and keep it."""
    context = data.context
    model = train_reward_model(
        data.preference_dataset,
        context.training_seed,
        progress,
        context.stage_folder("reward"),
        context.device,
    )
    data.keep_reward_model(model)
    return {}


def check_reward(data: RunData, progress: Progress) -> dict[str, Any]:
    """Check whether the reward model has understood the ranking."""
    context = data.context
    check = check_ranking(
        data.reward_model,
        data.preference_dataset,
        context.training_seed,
        progress,
        context.stage_folder("check"),
        context.device,
    )
    data.forget_perturbed()
    found = check.to_dict()
    found["predicted_returns"] = {
        str(data.ranked[index]): value for index, value in check.predicted_returns.items()
    }
    return {"check": {**found, "advice": advice(check), "warning": warning(check)}}


def learn_clone(data: RunData, progress: Progress) -> dict[str, Any]:
    """Learn the clone of the perfect demonstrations and keep it."""
    context = data.context
    path = context.stage_folder("clone") / "clone.zip"
    policy, _ = train_clone(
        data.perfect_trajectories,
        context.recipe.cloning,
        context.training_seed,
        progress,
        context.device,
    )
    save_policy(policy, path)
    data.keep_policy("clone", path)
    return {}


def learn_imitator(data: RunData, progress: Progress) -> dict[str, Any]:
    """Train the imitator as its recipe says, from its checkpoint if there is one; keep it."""
    context = data.context
    demonstrations = data.recordings([*data.ranked, *data.perfect])
    task = ImitationTask(
        model=data.reward_model,
        recordings=[demonstrations[number] for number in data.ranked],
        tiers=data.index_tiers,
        recipe=context.recipe,
        steps=context.steps,
        training_seed=context.training_seed,
        behaviour=context.behaviour,
        perfect=[demonstrations[number] for number in data.perfect],
    )
    folder = context.stage_folder("imitator")
    path = folder / "imitator.zip"
    with data.policy_file("clone") as clone:
        if context.recipe.method == "dagger":
            result = train_by_dagger(task, path, folder, progress, context.device)
        else:
            result = train_imitator(
                replace(task, clone=clone),
                path,
                folder,
                progress,
                n_processes=min(context.courtesy.threads, context.recipe.policy.n_envs),
                precision=Precision.of(context.settings.learning_precision, context.device),
                device=context.device,
            )
    data.keep_policy("imitator", path)
    learned = {"precision": str(result.precision), "device": context.device.type}
    return {"imitator": {"best_steps": result.best_steps, **learned}}
