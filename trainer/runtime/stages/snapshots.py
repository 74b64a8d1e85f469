"""What a training shows of its imitator while it still learns."""

from __future__ import annotations

from pathlib import Path

from trainer.policy.imitation import Snapshot
from trainer.policy.networks import save_policy
from trainer.runtime.policy_games import add_game, verify_games
from trainer.runtime.run_data import RunData
from tril.games.base import Console
from tril.store.training import leases, training_games
from tril.teaching.proposals import pick_training_games


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
    outcomes = [(tuple(item.cell for item in game.taken), game.died) for game in snapshot.games]
    picked = [snapshot.games[i] for i in pick_training_games(context.behaviour, outcomes)]
    verified = verify_games(context, picked, console)
    sticky = context.recipe.policy.sticky_action_probability
    steps = {training_games.STEPS: snapshot.steps}
    with context.database.writing() as session:
        leases.owned(session, context.lease)
        for recording in verified:
            add_game(session, context, recording, "imitator", "greedy", sticky, **steps)
