"""The verdict on a run."""

from __future__ import annotations

from typing import cast

from sqlalchemy.orm import Session

from tril.analysis.outcome import CheckOutcome
from tril.analysis.reward_alarm import RewardAlarm
from tril.analysis.verdict import Ended, RunFigures, Verdict, verdict
from tril.games.behaviours import score
from tril.games.measuring import mean_of, measured_before
from tril.recipes import recipe_from_dict
from tril.store import behaviours
from tril.store.models import BehaviourRow, RunRow, RunStatus
from tril.store.recordings import cells_of
from tril.store.training import evaluations
from tril.store.training.demonstrations import best_demonstration


def verdict_of(session: Session, run: RunRow, alarm: RewardAlarm | None) -> Verdict | None:
    """Return the verdict on a run; None until it is over.

    Args:
        session: The transaction.
        run: The run.
        alarm: Reward alarm of the run, if there is one.
    """
    status = RunStatus(run.status)
    if not status.is_over:
        return None
    recipe = recipe_from_dict(run.recipe)
    behaviour = session.get_one(BehaviourRow, run.behaviour_id)
    return verdict(
        RunFigures(
            ended=cast(Ended, str(status)),
            began=run.started_at is not None,
            steps=run.steps,
            default_steps=recipe.proposed_steps(ordered=behaviour.ordered),
            warm_up_steps=recipe.warm_up_steps,
            n_targets=behaviours.n_targets(session, run.behaviour_id),
            best_targets=_best_targets(session, run),
            headline=run.outcome.headline,
            is_alarmed=alarm is not None,
            sureness=_sureness(run.outcome.check),
            measures_met=_measures_met(session, run, behaviour),
        )
    )


def _sureness(check: CheckOutcome | None) -> float | None:
    """Return the probability of the likeliest statement, see ``RunFigures``."""
    if check is None or not check.statements or any(answer.meant for answer in check.answers):
        return None
    return check.statements[0].probability


def _measures_met(session: Session, run: RunRow, row: BehaviourRow) -> tuple[float, ...]:
    """Return the share of the imitator's games that meet each measure, see ``RunFigures``."""
    behaviour = behaviours.as_behaviour(row)
    games = evaluations.headline_games(evaluations.listing(session, run.id), "imitator")
    measured = [measured_before(behaviour.measures, one.recording.measured) for one in games]
    means = [mean_of(of_measure) for of_measure in zip(*measured, strict=True)]
    return tuple(mean.n_met / mean.n for mean in means if mean and mean.n_met is not None)


def _best_targets(session: Session, run: RunRow) -> int | None:
    """Return the targets of the best demonstration; None if that is not known."""
    best = best_demonstration(session, run)
    if best is None:
        return None
    behaviour = behaviours.as_behaviour(session.get_one(BehaviourRow, run.behaviour_id))
    hit = score(behaviour, cells_of(best))
    return None if hit is None else hit.targets
