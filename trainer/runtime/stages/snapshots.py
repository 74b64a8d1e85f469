"""What a training shows of its imitator while it still learns."""

from __future__ import annotations

from pathlib import Path

from trainer.policy.imitation import Snapshot
from trainer.policy.networks import save_policy
from trainer.runtime.run_data import RunData
from tril.game.console import Console
from tril.recording import verify
from tril.store import recordings
from tril.store.models import Source
from tril.store.training import leases, training_games


def keep_snapshot(data: RunData, snapshot: Snapshot, path: Path, console: Console) -> None:
    """Put a snapshot into the artifact store as the run's imitator so far, and keep some games.

    So it can be watched, its games can be ranked, and another run can go on from it before this
    one is done. A snapshot that is taken again after a crash adds no games; the last one of a
    training is passed over, because the evaluation follows.

    Args:
        data: The run.
        snapshot: The snapshot.
        path: Where its file is put.
        console: Replays the games.
    """
    context = data.context
    if snapshot.steps >= context.run.steps:
        return
    save_policy(snapshot.policy, path)
    data.keep_policy("imitator", path, snapshot.steps)
    with context.database.reading() as session:
        if training_games.latest(session, context.run_id)[0] == snapshot.steps:
            return
    sticky = context.recipe.policy.sticky_action_probability
    conditions = {"policy": "imitator", "action_selection": "greedy"} | (
        {"sticky_action_probability": sticky} if sticky else {}
    )
    outcomes = [
        (tuple((hit.row, hit.column) for hit in game.hits), game.end) for game in snapshot.games
    ]
    verified = []
    for index in training_games.pick(context.behaviour, outcomes):
        verified.append(verify(snapshot.games[index].recording, console=console))
        context.check_cancelled()
    with context.database.writing() as session:
        leases.owned(session, context.lease)
        for one in verified:
            recordings.add(
                session,
                context.run.behaviour_id,
                one.recording,
                one.replay,
                Source.POLICY,
                run_id=context.run_id,
                conditions=conditions | {training_games.STEPS: snapshot.steps},
            )
