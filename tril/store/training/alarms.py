"""What the curves of a run warn of."""

from __future__ import annotations

from sqlalchemy.orm import Session

from tril.analysis.reward_alarm import CURVES, RewardAlarm, reward_alarm
from tril.stages import Stage
from tril.store import behaviours
from tril.store.models import RunRow
from tril.store.training import metrics


def alarm_of(session: Session, run: RunRow) -> RewardAlarm | None:
    """Return the alarm that a run's imitator earns more predicted return without playing better.

    It is made of the curves each time it is asked for, so a run that is being trained has it as
    soon as they show it, and a run of an earlier version has it too.
    """
    check = run.outcome.check
    if check is None or run.recipe.get("method", "ppo") != "ppo":
        # Only PPO is paid by the learned reward.
        return None
    behaviour = behaviours.as_behaviour(behaviours.get(session, run.behaviour_id))
    return reward_alarm(
        metrics.curves(session, run.id, Stage.IMITATOR, CURVES),
        None if behaviour.target is None else len(behaviour.target),
        list(check.predicted_returns.values()),
    )
