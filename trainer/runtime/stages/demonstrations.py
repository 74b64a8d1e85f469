"""The first stage of an example: the scripted demonstrations, made and ranked where missing."""

from __future__ import annotations

from typing import Any

import numpy as np
from sqlalchemy.orm import Session

from trainer.progress import Progress
from trainer.runtime.run_data import RunData
from tril.analysis.outcome import ExampleOutcome, RunOutcome, RunSnapshot
from tril.demonstrators import (
    N_PERFECT,
    SCRIPTED,
    Demonstration,
    ExampleKind,
    Judgement,
    PlannedGame,
    example_tasks,
    execute,
    kind_named,
    rank_example,
)
from tril.recording import verify
from tril.store import rankings, recordings
from tril.store.models import RecordingRow, RecordingState, Source, Verification
from tril.store.training import leases

TASK = "demonstration"
"""Name, in a scripted recording's conditions, of its number among the example's demonstrations."""

TIER = "tier"
"""Of its plan's number; none if it is perfect."""

KIND = "example_kind"
"""Of the example that it belongs to; absent in the ordinary one."""

SEED = "example_seed"
"""Of what seeds the ranking mistakes; absent in the ordinary one."""


def make_demonstrations(data: RunData, progress: Progress) -> RunOutcome | None:
    """Make the demonstrations that the behaviour lacks, rank them, and freeze them for the run.

    An example always learns from its own demonstrations in the order that they were made to have.
    Those of the ordinary example become the behaviour's ranking where there is none; a ranking of
    a person's stays as it is. Those of another kind belong to the run that made them, outside the
    library, and later runs of that kind use them too.

    Returns:
        For kinds other than the ordinary one: the kind, the order that the games should have and
        the one that they are given.
    """
    context = data.context
    kind = kind_named(context.run.example_kind)
    rng = np.random.default_rng(context.run.training_seed)
    tasks = example_tasks(context.behaviour, rng, N_PERFECT, kind)
    with context.database.reading() as session:
        made_numbers = set(_existing_demonstrations(session, context.run.behaviour_id, kind))
    console = context.game.make_console()
    for number, task in enumerate(tasks):
        if number not in made_numbers:
            (demonstration,) = execute([task])
            verified = verify(demonstration.recording, console=console)
            with context.database.writing() as session:
                leases.owned(session, context.lease)
                recordings.add(
                    session,
                    context.run.behaviour_id,
                    verified.recording,
                    verified.replay,
                    Source.SCRIPTED,
                    run_id=None if kind == SCRIPTED else context.run_id,
                    perfect=demonstration.perfect,
                    notes=demonstration.notes,
                    conditions=_conditions(number, demonstration)
                    | _conditions_of_kind(kind, context.run.training_seed),
                )
        progress.advance(number + 1, len(tasks))
    judgement = _freeze(data, kind)
    if kind == SCRIPTED:
        return None
    return RunOutcome(example=ExampleOutcome(kind=kind.name, **judgement.to_dict()))


def _conditions(number: int, demonstration: Demonstration) -> dict[str, Any]:
    tier = None if demonstration.perfect else demonstration.plan.number
    return {TASK: number, TIER: tier} | demonstration.conditions


def _conditions_of_kind(kind: ExampleKind, example_seed: int) -> dict[str, Any]:
    return {} if kind == SCRIPTED else {KIND: kind.name, SEED: example_seed}


def _existing_demonstrations(
    session: Session, behaviour_id: int, kind: ExampleKind
) -> dict[int, RecordingRow]:
    """Return the example's existing demonstrations by number, the oldest of each."""
    return {
        row.conditions[TASK]: row
        for row in recordings.listing(session, behaviour_id, with_policies=kind != SCRIPTED)
        if row.source == Source.SCRIPTED
        and row.state == RecordingState.KEPT
        and row.verification == Verification.VERIFIED
        and TASK in row.conditions
        and row.conditions.get(KIND, SCRIPTED.name) == kind.name
    }


def _freeze(data: RunData, kind: ExampleKind) -> Judgement:
    context = data.context
    with context.database.writing() as session:
        run = leases.owned(session, context.lease)
        made_rows = [
            row
            for _, row in sorted(
                _existing_demonstrations(session, context.run.behaviour_id, kind).items()
            )
        ]
        outcomes = {
            row.id: _planned_game(row) for row in made_rows if row.conditions[TIER] is not None
        }
        perfect = [row.id for row in made_rows if row.conditions[TIER] is None]
        example_seed = made_rows[0].conditions.get(SEED, context.run.training_seed)
        judgement = rank_example(context.behaviour, kind, outcomes, example_seed)
        tiers = [list(tier) for tier in judgement.given.tiers]
        ranking = rankings.current(session, context.run.behaviour_id)
        if kind == SCRIPTED and not ranking.tiers:
            ranking = rankings.save(
                session, context.run.behaviour_id, ranking.revision, tiers, change="example"
            )
        run.snapshot = RunSnapshot(
            ranking_revision=ranking.revision if ranking.tiers == tiers else None,
            tiers=tiers,
            perfect=perfect,
        )
    context.run = run
    return judgement


def _planned_game(row: RecordingRow) -> PlannedGame:
    return PlannedGame(row.conditions[TIER], recordings.cells_of(row), row.end)
