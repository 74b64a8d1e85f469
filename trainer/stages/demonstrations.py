"""The first stage of an example: the scripted demonstrations, made and ranked where missing."""

from __future__ import annotations

from typing import Any

import numpy as np
from sqlalchemy.orm import Session

from trainer.progress import Progress
from trainer.run_data import RunData
from tril.demonstrator import Demonstration, carry_out, example_tasks
from tril.game.console import Console
from tril.recording import verify
from tril.store import claims, rankings, recordings
from tril.store.models import RecordingRow, RecordingState, Source, Verification

TASK = "demonstration"
"""Name, in a scripted recording's conditions, of its number among the example's demonstrations."""

TIER = "tier"


def make_demonstrations(data: RunData, progress: Progress) -> dict[str, Any]:
    """Make the demonstrations that the behaviour lacks, rank them, and freeze them for the run.

    An example always learns from its own demonstrations in the order that they were made to have.
    They become the behaviour's ranking where there is none; a ranking of a person's stays as it
    is.
    """
    context = data.context
    tasks = example_tasks(context.behaviour, np.random.default_rng(context.training_seed))
    with context.database.reading() as session:
        made = set(_made(session, context.behaviour_id))
    console = Console()
    for number, task in enumerate(tasks):
        if number not in made:
            (demonstration,) = carry_out([task])
            verified = verify(demonstration.recording, console=console)
            with context.database.writing() as session:
                claims.owned(session, context.claim)
                recordings.add(
                    session,
                    context.behaviour_id,
                    verified.recording,
                    verified.replay,
                    Source.SCRIPTED,
                    perfect=demonstration.perfect,
                    notes=demonstration.plan.description,
                    conditions=_conditions(number, demonstration),
                )
        progress.advance(number + 1, len(tasks))
    _freeze(data)
    return {}


def _conditions(number: int, demonstration: Demonstration) -> dict[str, Any]:
    tier = None if demonstration.perfect else demonstration.plan.number
    return {TASK: number, TIER: tier}


def _made(session: Session, behaviour_id: int) -> dict[int, RecordingRow]:
    """Return the example's demonstrations that are there, by number, the oldest of each."""
    return {
        row.conditions[TASK]: row
        for row in recordings.listing(session, behaviour_id)
        if row.source == Source.SCRIPTED
        and row.state == RecordingState.KEPT
        and row.verification == Verification.VERIFIED
        and TASK in row.conditions
    }


def _freeze(data: RunData) -> None:
    context = data.context
    with context.database.writing() as session:
        run = claims.owned(session, context.claim)
        made = _made(session, context.behaviour_id)
        by_tier: dict[int, list[int]] = {}
        for _, row in sorted(made.items()):
            if row.conditions[TIER] is not None:
                by_tier.setdefault(row.conditions[TIER], []).append(row.id)
        tiers = [by_tier[tier] for tier in sorted(by_tier)]
        perfect = [row.id for _, row in sorted(made.items()) if row.conditions[TIER] is None]
        ranking = rankings.current(session, context.behaviour_id)
        if not ranking.tiers:
            ranking = rankings.save(
                session, context.behaviour_id, ranking.revision, tiers, change="example"
            )
        run.snapshot = context.snapshot = {
            "ranking_revision": ranking.revision if ranking.tiers == tiers else None,
            "tiers": tiers,
            "perfect": perfect,
        }
