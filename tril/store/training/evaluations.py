"""The evaluation games of runs."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Sequence
from typing import Literal, NamedTuple

import numpy as np
from sqlalchemy import select
from sqlalchemy.orm import Session, joinedload

from tril.analysis.summary import GameFigures, Policy, PolicySummary, summarise
from tril.games import game_named
from tril.games.behaviours import Score
from tril.store.borrowed import pick_evenly
from tril.store.changes import note_change
from tril.store.models import EvaluationRow

POLICIES: tuple[Policy, ...] = ("imitator", "clone")

ActionSelection = Literal["greedy", "sampled", "sticky"]
ACTION_SELECTIONS: tuple[ActionSelection, ...] = ("greedy", "sampled", "sticky")
"""How a policy's actions are selected: the likeliest one; drawn by their probabilities; the
likeliest one, while the machine repeats actions at random. Runs of earlier versions have no sticky
games."""


N_PROPOSED = 8
"""Games of an imitator that are proposed for the ranking at most."""


class EvaluationKey(NamedTuple):
    """Names one evaluation game of a run."""

    policy: str
    action_selection: str
    start_number: int


def add(
    session: Session,
    run_id: str,
    key: EvaluationKey,
    recording_id: int,
    held_out: bool,
    predicted_return: float | None,
    final_level: float | None,
    score: Score | None,
) -> EvaluationRow:
    """Add one evaluation game.

    Args:
        session: The transaction.
        run_id: The run whose policy played.
        key: Which game.
        recording_id: Its recording.
        held_out: Whether no demonstration of the run began from this start.
        predicted_return: Sum of R over the game's observations.
        final_level: Mean level of R of its last 25 states.
        score: Its hits compared with the target; None for behaviours without one.
    """
    row = EvaluationRow(
        run_id=run_id,
        **key._asdict(),
        held_out=held_out,
        recording_id=recording_id,
        predicted_return=predicted_return,
        final_level=final_level,
        targets=None if score is None else score.targets,
        strays=None if score is None else score.strays,
        order_errors=None if score is None else score.order_errors,
    )
    session.add(row)
    session.flush()
    note_change(session, "run", run_id)
    return row


def played(session: Session, run_id: str) -> set[EvaluationKey]:
    """Return which games of a run have been played."""
    query = select(EvaluationRow.policy, EvaluationRow.action_selection, EvaluationRow.start_number)
    rows = session.execute(query.where(EvaluationRow.run_id == run_id))
    return {EvaluationKey(*row) for row in rows}


def listing(session: Session, run_id: str) -> list[EvaluationRow]:
    """Return a run's evaluation games with their recordings, by start number."""
    query = (
        select(EvaluationRow)
        .where(EvaluationRow.run_id == run_id)
        .options(joinedload(EvaluationRow.recording))
        .order_by(EvaluationRow.start_number, EvaluationRow.policy, EvaluationRow.action_selection)
    )
    return list(session.scalars(query))


def proposed_games(
    games: Sequence[EvaluationRow], kept_starts: Collection[int], n_targets: int | None
) -> list[EvaluationRow]:
    """Return the games of the imitator that a person had best rank: few, and unlike each other.

    They are greedy and sticky ones, which show what the imitator does at its best and where it
    doesn't recover, spread evenly over action selections, targets and strays, or over the number of
    items taken for a behaviour without target cells. Where all of them are perfect, which teaches
    nothing, sampled ones that are not are added. A later run that learns from a game takes its
    start for seen, so some starts are kept for its headline figures.

    Args:
        games: A run's evaluation games, loaded with their recordings.
        kept_starts: Starts to leave out, unless there are games from no others.
        n_targets: Target cells of the behaviour, None without any.

    Returns:
        At most N_PROPOSED, by start number; the same ones for the same games.
    """
    own = [g for g in games if g.policy == "imitator"]
    starts = {g.start_number for g in own if g.action_selection != "sampled"}
    shown = [g for g in own if g.start_number in (starts - set(kept_starts) or starts)]
    candidates = [g for g in shown if g.action_selection != "sampled"]
    if all(figures_of(g, n_targets).perfect for g in candidates):
        candidates = [
            g
            for g in shown
            if g.action_selection != "sampled" or not figures_of(g, n_targets).perfect
        ]
    traits = [
        (g.action_selection, len(g.recording.taken) if g.targets is None else g.targets, g.strays)
        for g in candidates
    ]
    picked = pick_evenly(traits, N_PROPOSED, np.random.default_rng(0))
    return [candidates[place] for place in sorted(picked)]


def figures_of(row: EvaluationRow, n_targets: int | None = None) -> GameFigures:
    """Return the figures of an evaluation game, loaded with its recording."""
    game = game_named(row.recording.game)  # its clock counts steps, however long it may be
    return GameFigures(
        targets=row.targets,
        strays=row.strays,
        order_errors=row.order_errors,
        steps=game.clock.n_steps(row.recording.n_frames),
        died=game.is_death(row.recording.end),
        predicted_return=row.predicted_return,
        n_targets=n_targets,
    )


def summaries(
    games: Sequence[EvaluationRow], n_targets: int | None
) -> dict[tuple[str, str], PolicySummary]:
    """Return means over the games from held-out starts, by policy and action selection.

    Args:
        games: A run's evaluation games, loaded with their recordings.
        n_targets: Target cells of the behaviour, None without any.
    """
    groups: dict[tuple[str, str], list[GameFigures]] = defaultdict(list)
    for row in games:
        if row.held_out:
            groups[row.policy, row.action_selection].append(figures_of(row, n_targets))
    order = [(policy, how) for policy in POLICIES for how in ACTION_SELECTIONS]
    return {key: summarise(groups[key]) for key in order if key in groups}
