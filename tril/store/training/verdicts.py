"""The verdict on a run."""

from __future__ import annotations

from typing import cast

from sqlalchemy.orm import Session

from tril.analysis.extrapolation import true_quantity
from tril.analysis.reward_alarm import RewardAlarm
from tril.analysis.verdict import Ended, RunFigures, Verdict, verdict
from tril.behaviours import score
from tril.recipes import recipe_from_dict
from tril.store import behaviours, recordings
from tril.store.models import BehaviourRow, RunRow, RunStatus


def verdict_of(session: Session, run: RunRow, alarm: RewardAlarm | None) -> Verdict | None:
    """Return what came of a run, in words; None until it is over.

    Args:
        session: The transaction.
        run: The run.
        alarm: Its reward alarm, if there is one.
    """
    status = RunStatus(run.status)
    if not status.is_over:
        return None
    recipe = recipe_from_dict(run.recipe)
    behaviour = session.get_one(BehaviourRow, run.behaviour_id)
    return verdict(
        RunFigures(
            ended=cast(Ended, str(status)),
            steps=run.steps,
            default_steps=recipe.proposed_steps(ordered=behaviour.ordered),
            warm_up_steps=recipe.warm_up_steps,
            n_targets=behaviours.n_targets(session, run.behaviour_id),
            best_targets=_best_targets(session, run),
            headline=run.outcome.headline,
            is_alarmed=alarm is not None,
        )
    )


def _best_targets(session: Session, run: RunRow) -> int | None:
    """Return the targets of the demonstration that is worth most; None if that is not known.

    Of all of them, since the order may be wrong at the top.
    """
    if run.snapshot is None:
        return None
    behaviour = behaviours.as_behaviour(session.get_one(BehaviourRow, run.behaviour_id))
    rows = recordings.by_ids(session, run.snapshot.recordings).values()
    scores = [score(behaviour, tuple((r, c) for r, c, _ in row.hits)) for row in rows]
    known = [one for one in scores if one is not None]
    best = max(known, key=lambda one: true_quantity(one.targets, one.strays), default=None)
    return None if best is None else best.targets
