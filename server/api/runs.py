"""Trainings: start, follow, cancel, resume."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Query, Request

from server.api.results import run_results
from server.api.run_schemas import Metrics, Recipe, RewardTrace, Run, RunNew, RunResults
from server.api.run_views import run_view, stage_views
from server.dependencies import MAX_ID, Reading, RecordingId, RunId, Writing, services_of
from server.web.problems import CONFLICT, NOT_FOUND
from tril import jobs
from tril.recipes import RECIPES, recipe_named, with_values
from tril.store import behaviours, players, recordings
from tril.store.training import metrics, runs

router = APIRouter(tags=["runs"])


@router.get("/recipes")
def list_recipes(session: Reading) -> list[Recipe]:
    """Return the ways of learning, the one proposed first."""
    shown = []
    for recipe in RECIPES.values():
        estimate = jobs.estimate(session, recipe)
        shown.append(
            Recipe(
                name=recipe.name,
                summary=recipe.summary,
                default_steps=recipe.default_steps,
                learning_rate=recipe.policy.learning_rate,
                values=recipe.to_dict(),
                stages=stage_views(example=False),
                steps_per_s=estimate.steps_per_s,
                steps_per_s_measured=estimate.measured,
                overhead_s=estimate.overhead_s,
            )
        )
    return shown


@router.get("/runs", responses=NOT_FOUND)
def list_runs(
    session: Reading, behaviour_id: Annotated[int | None, Query(ge=1, le=MAX_ID)] = None
) -> list[Run]:
    """Return the trainings of a behaviour, or all, newest first."""
    if behaviour_id is not None:
        behaviours.get(session, behaviour_id)
    return [run_view(session, row) for row in runs.listing(session, behaviour_id)]


@router.post("/runs", status_code=201, responses=NOT_FOUND | CONFLICT)
def create_run(request: Request, new: RunNew) -> Run:
    """Start a training from the ranking as it stands; a worker takes it from the queue."""
    recipe = recipe_named(new.recipe)
    if new.learning_rate is not None:
        recipe = with_values(recipe, {"policy.learning_rate": new.learning_rate})
    services = services_of(request)
    with services.database.writing() as session:
        row = runs.create(
            session,
            new.behaviour_id,
            recipe,
            new.steps or recipe.default_steps,
            new.training_seed,
            new.go_on_anyway,
            new.example,
            players.owner(session).id,
        )
        shown = run_view(session, row)
    # Only once the run is stored: its job names a row that a worker has to find.
    services.jobs.enqueue(shown.id)
    return shown


@router.get("/runs/{run_id}", responses=NOT_FOUND)
def get_run(session: Reading, run_id: RunId) -> Run:
    """Return a training as it stands."""
    return run_view(session, runs.get(session, str(run_id)))


@router.delete("/runs/{run_id}", status_code=204, responses=NOT_FOUND | CONFLICT)
def delete_run(session: Writing, run_id: RunId) -> None:
    """Take a training that is over out of the lists."""
    runs.delete(session, str(run_id))


@router.post("/runs/{run_id}/cancel", responses=NOT_FOUND | CONFLICT)
def cancel_run(request: Request, run_id: RunId) -> Run:
    """Cancel a training; its worker stops within seconds and it can be resumed."""
    services_of(request).jobs.cancel(str(run_id))
    return _now(request, run_id)


@router.post("/runs/{run_id}/resume", responses=NOT_FOUND | CONFLICT)
def resume_run(request: Request, run_id: RunId) -> Run:
    """Go on with a training that was cancelled, stopped or failed."""
    services_of(request).jobs.resume(str(run_id))
    return _now(request, run_id)


@router.get("/runs/{run_id}/metrics", responses=NOT_FOUND)
def get_run_metrics(
    session: Reading, run_id: RunId, after: Annotated[int, Query(ge=0, le=2**63 - 1)] = 0
) -> Metrics:
    """Return the points of a training's curves that came after an earlier answer's ``last``."""
    runs.get(session, str(run_id))
    last, series = metrics.series(session, str(run_id), after)
    return Metrics(last=last, series=series)


@router.get("/runs/{run_id}/results", responses=NOT_FOUND)
def get_run_results(session: Reading, run_id: RunId) -> RunResults:
    """Return everything that a training has found so far."""
    return run_results(session, runs.get(session, str(run_id)))


@router.get("/runs/{run_id}/reward/{recording_id}", responses=NOT_FOUND)
def get_reward_trace(request: Request, run_id: RunId, recording_id: RecordingId) -> RewardTrace:
    """Return what a training's reward model says of every observation of a recording."""
    services = services_of(request)
    with services.database.reading() as session:
        runs.get(session, str(run_id))
        recording = recordings.as_recording(recordings.get(session, recording_id))
    rewards = services.rewards_of(str(run_id), recording)
    return RewardTrace(run_id=str(run_id), recording_id=recording_id, rewards=rewards)


def _now(request: Request, run_id: RunId) -> Run:
    with services_of(request).database.reading() as session:
        return run_view(session, runs.get(session, str(run_id)))
