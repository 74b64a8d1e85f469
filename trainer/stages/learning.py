"""The stages that learn: trajectories, reward, check of the ranking, clone, imitator."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from trainer.policy.cloning import train_clone
from trainer.policy.imitator import ImitationTask, train_imitator
from trainer.progress import Progress
from trainer.reward.check import (
    PASSING_HELD_OUT_ACCURACY,
    PASSING_TAU,
    RankingCheck,
    check_ranking,
)
from trainer.reward.training import train_reward
from trainer.run_data import RunData

MOST_CONFUSED = 3
"""Pairs of tiers that the advice names."""


def replay_demonstrations(data: RunData, progress: Progress) -> dict[str, Any]:
    """Replay every demonstration of the run through an agent's eyes."""
    data.trajectories([*data.ranked, *data.perfect], progress)
    return {}


def learn_reward(data: RunData, progress: Progress) -> dict[str, Any]:
    """Learn the reward model from the ranking and keep it."""
    context = data.context
    model = train_reward(
        data.ranked_trajectories,
        data.index_tiers,
        context.recipe.reward,
        context.training_seed,
        progress,
        context.stage_folder("reward"),
    )
    data.keep_reward_model(model)
    return {}


def check_reward(data: RunData, progress: Progress) -> dict[str, Any]:
    """Check whether the reward model has understood the ranking."""
    context = data.context
    check = check_ranking(
        data.reward_model,
        data.ranked_trajectories,
        data.index_tiers,
        context.recipe.reward,
        context.training_seed,
        progress,
        context.stage_folder("check"),
    )
    found = check.to_dict()
    found["predicted_returns"] = {
        str(data.ranked[index]): value for index, value in check.predicted_returns.items()
    }
    return {"check": {**found, "advice": advice(check)}}


def advice(check: RankingCheck) -> str:
    """Say to a person what of their ranking was not understood, and what to do."""
    if check.passed:
        return ""
    measured = [f"Kendall's tau is {check.tau:.2f} (at least {PASSING_TAU} is needed)"]
    if check.held_out_accuracy is not None:
        measured.append(
            f"{check.held_out_accuracy:.0%} of the pairs with demonstrations left out are in "
            f"order (at least {PASSING_HELD_OUT_ACCURACY:.0%} is needed)"
        )
    pairs = [f"{pair.better} and {pair.worse}" for pair in check.confused[:MOST_CONFUSED]]
    more = len(check.confused) - len(pairs)
    confused = ""
    if pairs:
        confused = (
            f" It confuses tiers {', '.join(pairs)}{f' and {more} more pairs' if more else ''}."
        )
    return (
        f"The reward model has not understood the ranking: {'; '.join(measured)}.{confused} It "
        "needs other demonstrations or another order. You can also go on anyway."
    )


def learn_clone(data: RunData, progress: Progress) -> dict[str, Any]:
    """Learn the clone of the perfect demonstrations and keep it."""
    context = data.context
    path = context.stage_folder("clone") / "clone.zip"
    train_clone(
        data.perfect_trajectories, context.recipe.cloning, context.training_seed, path, progress
    )
    data.keep_policy("clone", path)
    return {}


def learn_imitator(data: RunData, progress: Progress) -> dict[str, Any]:
    """Train the imitator on the learned reward, from its checkpoint if there is one; keep it."""
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
        result = train_imitator(
            replace(task, clone=clone),
            path,
            folder,
            progress,
            n_processes=min(context.courtesy.threads, context.recipe.policy.n_games),
        )
    data.keep_policy("imitator", path)
    return {"imitator": {"best_steps": result.best_steps}}
