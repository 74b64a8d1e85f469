"""Trainings: start, follow, cancel and resume."""

from __future__ import annotations

import contextlib
from typing import Annotated
from uuid import UUID

from fastapi import APIRouter, Query, Request

from server.api.schemas.runs import Metrics, Recipe, Run, RunNew, RunResults, RunUpdate
from server.api.views.results import run_results
from server.api.views.runs import run_view, stage_views
from server.dependencies import (
    MAX_ID,
    MAX_LISTED,
    PageLimit,
    ReadSession,
    RunId,
    Who,
    WriteSession,
    services_of,
)
from server.web.problems import CONFLICT, NOT_FOUND
from tril import jobs
from tril.errors import Conflict
from tril.games import DEFAULT_GAME, game_named, game_of
from tril.recipes import recipe_named, recipes_for, with_values
from tril.store import behaviours
from tril.store.training import metrics, runs
from tril.teaching import new_run

MOST_STEPS = 2_000
"""Of a stage in one answer: a screen is no wider."""

router = APIRouter(tags=["runs"])


@router.get("/recipes", responses=NOT_FOUND)
def list_recipes(
    session: ReadSession,
    game: Annotated[str, Query(max_length=160, description="Its name.")] = DEFAULT_GAME,
    has_target: Annotated[
        bool, Query(description="Whether the behaviour says which items are wanted.")
    ] = True,
) -> list[Recipe]:
    """Return the recipes that a behaviour can be trained with, the proposed one first."""
    shown = []
    for recipe in recipes_for(game_named(game).pretrained, has_target).values():
        estimate = jobs.estimate(session, recipe)
        shown.append(
            Recipe(
                name=recipe.name,
                summary=recipe.summary,
                default_steps=recipe.default_steps,
                ordered_steps=recipe.proposed_steps(ordered=True),
                warm_up_steps=recipe.warm_up_steps,
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
    session: ReadSession,
    behaviour_id: Annotated[int | None, Query(ge=1, le=MAX_ID)] = None,
    active: Annotated[bool, Query(description="Only those that are not over.")] = False,
    before: Annotated[
        UUID | None, Query(description="Only those that follow this one in the list.")
    ] = None,
    limit: PageLimit = MAX_LISTED,
) -> list[Run]:
    """Return the trainings of a behaviour, or of all, newest first.

    At most 200 are returned: ask for further ones with ``before``.
    """
    if behaviour_id is not None:
        behaviours.get(session, behaviour_id)
    last = None if before is None else str(before)
    rows = runs.listing(session, behaviour_id, active_only=active, before=last, limit=limit)
    return [run_view(session, row) for row in rows]


@router.post("/runs", status_code=201, responses=NOT_FOUND | CONFLICT)
def create_run(request: Request, who: Who, new: RunNew) -> Run:
    """Start a training from the current ranking; a worker takes it from the queue."""
    services = services_of(request)
    with services.database.writing() as session:
        taught = behaviours.as_behaviour(behaviours.get(session, new.behaviour_id))
        recipe = recipe_named(new.recipe, game_of(taught).pretrained)
        if new.learning_rate is not None:
            recipe = with_values(recipe, {"policy.learning_rate": new.learning_rate})
        row = new_run.create_run(
            session,
            new.behaviour_id,
            recipe,
            new.steps,
            new.training_seed,
            new.go_on_anyway,
            new.example,
            who.player_id,
            max_queued=services.settings.max_queued_runs,
            max_queued_of_player=services.settings.max_queued_runs_per_player,
            max_of_player=services.settings.max_runs_per_player,
            parent_run_id=None if new.parent_run_id is None else str(new.parent_run_id),
            device=new.device,
        )
        shown = run_view(session, row)
    # After the commit, because the worker looks for the run's row.
    services.jobs.enqueue(shown.id)
    if new.cancel_parent and shown.parent_run_id is not None:
        with contextlib.suppress(Conflict):  # It is over.
            services.jobs.cancel(shown.parent_run_id, who.player_id)
    return shown


@router.get("/runs/{run_id}", responses=NOT_FOUND)
def get_run(session: ReadSession, run_id: RunId) -> Run:
    """Return a training."""
    return run_view(session, runs.get(session, str(run_id)))


@router.patch("/runs/{run_id}", responses=NOT_FOUND)
def update_run(session: WriteSession, who: Who, run_id: RunId, update: RunUpdate) -> Run:
    """Change the name or the notes of a training; omitted fields stay."""
    return run_view(
        session, runs.describe(session, str(run_id), update.name, update.notes, who.player_id)
    )


@router.delete("/runs/{run_id}", status_code=204, responses=NOT_FOUND | CONFLICT)
def delete_run(session: WriteSession, who: Who, run_id: RunId) -> None:
    """Delete a training that has ended; it can be restored."""
    runs.delete(session, str(run_id), who.player_id)


@router.post("/runs/{run_id}/restore", responses=NOT_FOUND)
def restore_run(session: WriteSession, who: Who, run_id: RunId) -> Run:
    """Restore a deleted training, with everything it had."""
    return run_view(session, runs.restore(session, str(run_id), who.player_id))


@router.post("/runs/{run_id}/cancel", responses=NOT_FOUND | CONFLICT)
def cancel_run(request: Request, who: Who, run_id: RunId) -> Run:
    """Cancel a training; its worker stops within seconds. It can be resumed."""
    services_of(request).jobs.cancel(str(run_id), who.player_id)
    return _now(request, run_id)


@router.post("/runs/{run_id}/resume", responses=NOT_FOUND | CONFLICT)
def resume_run(request: Request, run_id: RunId) -> Run:
    """Resume a training that was cancelled, stopped or failed."""
    services_of(request).jobs.resume(str(run_id))
    return _now(request, run_id)


@router.get("/runs/{run_id}/metrics", responses=NOT_FOUND)
def get_run_metrics(
    session: ReadSession, run_id: RunId, after: Annotated[int, Query(ge=0, le=MAX_ID)] = 0
) -> Metrics:
    """Return the points of a training's curves that are newer than an earlier answer's ``last``.

    Of a stage with more than 2,000 newer steps about as many are returned, evenly spaced.
    """
    runs.get(session, str(run_id))
    last, series = metrics.series(session, str(run_id), after, MOST_STEPS)
    return Metrics(last=last, series=series)


@router.get("/runs/{run_id}/results", responses=NOT_FOUND)
def get_run_results(request: Request, session: ReadSession, who: Who, run_id: RunId) -> RunResults:
    """Return the results of a training so far."""
    run = runs.get(session, str(run_id))
    return run_results(session, who, run, services_of(request).vocabularies)


def _now(request: Request, run_id: RunId) -> Run:
    with services_of(request).database.reading() as session:
        return run_view(session, runs.get(session, str(run_id)))
