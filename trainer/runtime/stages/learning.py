"""The stages that learn: trajectories, reward, check of the ranking, clone, imitator."""

from __future__ import annotations

from dataclasses import asdict, replace
from functools import partial

from trainer.nn.precision import Precision
from trainer.policy.cloning import train_clone
from trainer.policy.imitation import ImitationTask
from trainer.policy.imitator import train_imitator
from trainer.policy.networks import save_policy
from trainer.progress import Progress
from trainer.reward.advice import advice, warning
from trainer.reward.check import check_ranking
from trainer.reward.reward_trainer import train_reward_model
from trainer.reward.statements import understanding_of
from trainer.reward.wanted_aliens import labels_of
from trainer.runtime.run_data import RunData
from trainer.runtime.stages.snapshots import keep_snapshot
from tril.analysis.outcome import (
    CheckOutcome,
    ImitatorOutcome,
    RunOutcome,
    ToldStatement,
    WantedAliens,
)
from tril.vocabulary.moments import seconds_of
from tril.vocabulary.sentences import tell


def replay_demonstrations(data: RunData, progress: Progress) -> None:
    """Replay every demonstration of the run through an agent's eyes."""
    data.trajectories(data.snapshot.recordings, progress)


def learn_reward(data: RunData, progress: Progress) -> None:
    """Learn the reward model from the ranking and keep it."""
    context = data.context
    model = train_reward_model(
        data.preference_dataset,
        context.run.training_seed,
        progress,
        context.stage_folder("reward"),
        context.device,
    )
    data.keep_reward_model(model)


def check_reward(data: RunData, progress: Progress) -> RunOutcome:
    """Check whether the reward model has understood the ranking, and keep how sure it is."""
    context = data.context
    check, model = check_ranking(
        data.reward_model,
        data.preference_dataset,
        context.run.training_seed,
        progress,
        context.stage_folder("check"),
        context.device,
    )
    if model.spread is not None:
        data.keep_reward_model(model)
    ranked = data.snapshot.ranked
    method = context.recipe.reward.method
    inferred = method == "posterior"
    aliens_alone = inferred and context.recipe.method == "ppo"
    values = asdict(check) | {
        "predicted_returns": {ranked[i]: value for i, value in check.predicted_returns.items()},
        "final_levels": {ranked[i]: value for i, value in check.final_levels.items()},
        "advice": advice(check, aliens_alone=aliens_alone),
        "warning": warning(check),
        "wanted": _wanted_aliens(data) if inferred else None,
        "statements": _statements(data) if method == "statement" else [],
        "answers": data.snapshot.answers if method == "statement" else [],
    }
    return RunOutcome(check=CheckOutcome.model_validate(values))


def _wanted_aliens(data: RunData) -> WantedAliens:
    labels, order = labels_of(data.reward_model.network)
    return WantedAliens.of(labels.tolist(), order.tolist())


def _statements(data: RunData) -> list[ToldStatement]:
    dataset, game = data.preference_dataset, data.context.game
    understanding = understanding_of(dataset)
    # The ranked trajectories are the first ones, in the snapshot's order.
    ranked = data.snapshot.ranked
    seconds = [seconds_of(dataset.facts(index), game.clock) for index in range(len(ranked))]
    statements = []
    for told in tell(understanding.words, understanding.posterior, game, understanding.meant):
        contrast = understanding.contrast(told.statement, seconds, dataset.tiers)
        statements.append(
            ToldStatement(
                sentence=told.sentence,
                probability=round(told.probability, 3),
                subjects=list(told.subjects),
                kinds=list(told.kinds),
                detail=told.detail,
                shown=contrast and contrast.most.shown(ranked, game.clock),
                contrast=contrast and contrast.least.shown(ranked, game.clock),
            )
        )
    return statements


def learn_clone(data: RunData, progress: Progress) -> None:
    """Learn the clone of the perfect demonstrations and keep it."""
    context = data.context
    path = context.stage_folder("clone") / "clone.zip"
    policy, _ = train_clone(
        data.perfect_trajectories,
        context.game.controls.n_actions,
        context.recipe.cloning,
        context.run.training_seed,
        progress,
        context.device,
    )
    save_policy(policy, path)
    data.keep_policy("clone", path)


def learn_imitator(data: RunData, progress: Progress) -> RunOutcome:
    """Train the imitator as its recipe says, from its checkpoint if there is one; keep it.

    PPO begins with the run's clone or, as the recipe says, with a mixture of it with the policy
    that ships with Tril; or with the imitator of the run that it continues.
    """
    context = data.context
    task = ImitationTask(
        game=context.game,
        model=data.reward_model,
        recordings=list(data.recordings(data.snapshot.ranked).values()),
        tiers=data.index_tiers,
        recipe=context.recipe,
        steps=context.run.steps,
        training_seed=context.run.training_seed,
        behaviour=context.behaviour,
        perfect=list(data.recordings(data.snapshot.perfect).values()),
        mixes_start=context.run.parent_run_id is None,
    )
    folder = context.stage_folder("imitator")
    path = folder / "imitator.zip"
    with data.start_policy_file() as start_policy:
        result = train_imitator(
            replace(task, start_policy=start_policy),
            path,
            folder,
            progress,
            n_processes=min(context.threads, context.recipe.policy.n_envs),
            precision=Precision.of(context.settings.learning_precision, context.device),
            device=context.device,
            on_snapshot=partial(
                keep_snapshot, data, path=path, console=context.game.make_console()
            ),
        )
    data.keep_policy("imitator", path)
    return RunOutcome(
        imitator=ImitatorOutcome(
            best_steps=result.best_steps,
            precision=str(result.precision),
            device=context.device.type,
        )
    )
