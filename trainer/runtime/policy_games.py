"""The games of a run's policies, each one a verified recording."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from sqlalchemy.orm import Session

from trainer.policy.evaluation import EvaluatedGame
from trainer.runtime.context import RunContext
from tril.games.base import Console
from tril.games.measuring import measurable
from tril.recording import Verified, verify
from tril.store import recordings
from tril.store.models import RecordingRow, Source
from tril.store.training.evaluations import ActionSelection


def verify_games(
    context: RunContext, games: Sequence[EvaluatedGame], console: Console
) -> list[Verified]:
    """Replay games on a console, which shows that each is what it claims to be."""
    measures = measurable(context.game, context.behaviour.measures)
    verified = []
    for game in games:
        verified.append(verify(game.recording, console=console, measures=measures))
        context.check_cancelled()
    return verified


def add_game(
    session: Session,
    context: RunContext,
    game: Verified,
    policy: str,
    action_selection: ActionSelection,
    sticky_action_probability: float,
    **further_conditions: Any,
) -> RecordingRow:
    """Add a game of a run's policy to the recordings.

    Args:
        session: The database session.
        context: The run.
        game: The game.
        policy: "imitator" or "clone".
        action_selection: Action selection of the policy.
        sticky_action_probability: Probability of repeating the last frame's action.
        **further_conditions: Further conditions of the recording.
    """
    conditions: dict[str, Any] = {"policy": policy, "action_selection": action_selection}
    if sticky_action_probability:
        conditions["sticky_action_probability"] = sticky_action_probability
    return recordings.add(
        session,
        context.run.behaviour_id,
        game.recording,
        game.replay,
        Source.POLICY,
        run_id=context.run_id,
        conditions=conditions | further_conditions,
    )
