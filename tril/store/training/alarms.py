"""The reward alarm of a run."""

from __future__ import annotations

from sqlalchemy.orm import Session

from tril.analysis.reward_alarm import CURVES, RewardAlarm, reward_alarm
from tril.stages import Stage
from tril.store import behaviours
from tril.store.models import RunRow
from tril.store.training import metrics

MOST_STEPS = 2_000
"""Of long curves; the alarm compares means over sixths of them."""


def alarm_of(session: Session, run: RunRow) -> RewardAlarm | None:
    """Return the reward alarm that a run's curves give so far, if they do."""
    check = run.outcome.check
    if check is None or run.recipe.get("method", "ppo") != "ppo":
        # Only PPO learns from the learned reward.
        return None
    behaviour = behaviours.as_behaviour(behaviours.get(session, run.behaviour_id))
    return reward_alarm(
        metrics.curves(session, run.id, Stage.IMITATOR, CURVES, MOST_STEPS),
        None if behaviour.target is None else len(behaviour.target),
        list(check.predicted_returns.values()),
    )
