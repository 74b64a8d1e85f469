"""Trainings as the API shows them."""

from __future__ import annotations

from sqlalchemy.orm import Session

from server.api.schemas.runs import Run, RunStage
from tril.jobs import overall_progress
from tril.stages import stages_of
from tril.store.models import BehaviourRow, RunRow
from tril.store.training import runs


def run_view(session: Session, row: RunRow) -> Run:
    """Show a training."""
    snapshot = row.snapshot
    behaviour = session.get_one(BehaviourRow, row.behaviour_id)
    return Run.of(
        row,
        behaviour_name=behaviour.name,
        imported=row.is_imported,
        recipe=row.recipe_name,
        recipe_values=row.recipe,
        learning_rate=row.recipe["policy"]["learning_rate"],
        ranking_revision=snapshot.ranking_revision if snapshot else None,
        queue_position=runs.queue_position(session, row),
        n_ranked=len(snapshot.ranked) if snapshot else None,
        n_perfect=len(snapshot.perfect) if snapshot else None,
        stages=stage_views(row.example),
        stage_progress=row.stage_done,
        progress=overall_progress(session, row),
        worker_alive=runs.has_worker(session, row),
        headline=row.outcome.headline,
    )


def stage_views(example: bool) -> list[RunStage]:
    """Show the stages that a run goes through, in order."""
    return [RunStage.of(stage, name=stage) for stage in stages_of(example)]
