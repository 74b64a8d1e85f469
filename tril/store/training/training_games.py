"""The games that an imitator plays while it still learns, kept so that a person can rank them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from sqlalchemy import select
from sqlalchemy.orm import Session

from tril.games.base import Cell
from tril.games.behaviours import Behaviour, score
from tril.store.borrowed import Traits, pick_evenly
from tril.store.models import EvaluationRow, RecordingRow
from tril.store.training.evaluations import N_PROPOSED

STEPS = "steps"
"""In a recording's conditions: training steps behind the policy that played it."""


def latest(session: Session, run_id: str) -> tuple[int, list[RecordingRow]]:
    """Return the games of a run's newest snapshot, and its training steps.

    Returns:
        Steps and games; 0 and none if no snapshot has been taken.
    """
    evaluated = select(EvaluationRow.recording_id).where(EvaluationRow.run_id == run_id)
    query = (
        select(RecordingRow)
        .where(RecordingRow.run_id == run_id, RecordingRow.id.not_in(evaluated))
        .order_by(RecordingRow.id.desc())
        .limit(N_PROPOSED)
    )
    rows = [row for row in session.scalars(query) if STEPS in row.conditions]
    if not rows:
        return 0, []
    steps: int = rows[0].conditions[STEPS]
    return steps, [row for row in reversed(rows) if row.conditions[STEPS] == steps]


def pick(behaviour: Behaviour, games: Sequence[tuple[Sequence[Cell], bool]]) -> Sequence[int]:
    """Return which games to keep: few, and unlike each other.

    Args:
        behaviour: What is taught.
        games: Of each, the items taken, in order of time, and whether the player died.

    Returns:
        At most N_PROPOSED indices, in order; the same ones for the same games.
    """
    traits = [_traits(behaviour, cells, died) for cells, died in games]
    return sorted(pick_evenly(traits, N_PROPOSED, np.random.default_rng(0)))


def _traits(behaviour: Behaviour, cells: Sequence[Cell], died: bool) -> Traits:
    found = score(behaviour, tuple(cells))
    targets, strays = (len(cells), 0) if found is None else (found.targets, found.strays)
    return targets, strays, died
