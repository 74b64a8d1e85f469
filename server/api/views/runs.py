"""A training's row to what goes over HTTP."""

from __future__ import annotations

from typing import Any

from sqlalchemy.orm import Session

from server.api.schemas.runs import Headline, Run
from tril.jobs import overall_progress, stages_of
from tril.store.models import BehaviourRow, RunRow
from tril.store.processes import is_fresh


def run_view(session: Session, row: RunRow) -> Run:
    """Show a training."""
    snapshot = row.snapshot or {}
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
        ranking_revision=snapshot.get("ranking_revision"),
        n_ranked=sum(map(len, snapshot["tiers"])) if snapshot else None,
        n_perfect=len(snapshot["perfect"]) if snapshot else None,
        status=row.status,
        stages=list(stages_of(row)),
        stage=row.stage,
        stage_progress=row.stage_done,
        progress=overall_progress(row),
        remaining_s=row.remaining_s,
        message=row.message,
        worker_alive=is_fresh(row.heartbeat_at),
        versions=row.versions,
        headline=_headline(row.outcome),
        created_at=row.created_at,
        started_at=row.started_at,
        finished_at=row.finished_at,
    )


def _headline(outcome: dict[str, Any]) -> Headline | None:
    found = outcome.get("headline")
    return None if found is None else Headline.model_validate(found)
