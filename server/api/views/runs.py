"""A training's row to what goes over HTTP."""

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
    return Run(
        id=row.id,
        behaviour_id=row.behaviour_id,
        behaviour_name=behaviour.name,
        example=row.example,
        recipe=row.recipe_name,
        recipe_values=row.recipe,
        steps=row.steps,
        training_seed=row.training_seed,
        learning_rate=row.recipe["policy"]["learning_rate"],
        go_on_anyway=row.go_on_anyway,
        ranking_revision=snapshot.ranking_revision if snapshot else None,
        n_ranked=len(snapshot.ranked) if snapshot else None,
        n_perfect=len(snapshot.perfect) if snapshot else None,
        status=row.status,
        stages=stage_views(row.example),
        stage=row.stage,
        stage_progress=row.stage_done,
        progress=overall_progress(row),
        remaining_s=row.remaining_s,
        message=row.message,
        worker_alive=runs.has_worker(session, row),
        versions=row.versions,
        headline=row.outcome.headline,
        created_at=row.created_at,
        started_at=row.started_at,
        finished_at=row.finished_at,
    )


def stage_views(example: bool) -> list[RunStage]:
    """Show the stages that a run goes through, in order."""
    return [
        RunStage(name=stage, label=stage.label, summary=stage.summary)
        for stage in stages_of(example)
    ]
