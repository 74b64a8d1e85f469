"""The evaluation games of runs."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from typing import Literal, NamedTuple

from sqlalchemy import select
from sqlalchemy.orm import Session, joinedload

from tril.analysis.summary import GameFigures, Policy, PolicySummary, summarise
from tril.games import game_named
from tril.games.behaviours import Score
from tril.store.changes import note_change
from tril.store.models import EvaluationRow, RecordingRow

POLICIES: tuple[Policy, ...] = ("imitator", "clone")

ActionSelection = Literal["greedy", "sampled", "sticky"]
ACTION_SELECTIONS: tuple[ActionSelection, ...] = ("greedy", "sampled", "sticky")
"""How a policy's actions are selected: the likeliest one; drawn by their probabilities; the
likeliest one, while the machine repeats actions at random. Runs of earlier versions have no sticky
games."""


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
        key: Key of the game.
        recording_id: Recording of the game.
        held_out: Whether no demonstration of the run began from this start.
        predicted_return: Sum of R over the game's observations.
        final_level: Mean level of R of its last 25 states.
        score: Score against the target; None for behaviours without one.
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
    """Return the keys of a run's played games."""
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


def headline_games(games: Iterable[EvaluationRow], policy: str) -> list[EvaluationRow]:
    """Return a policy's greedy games from held-out starts, which the headline figures are of."""
    return [
        row
        for row in games
        if row.held_out and (row.policy, row.action_selection) == (policy, "greedy")
    ]


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


def shown_game(games: Sequence[EvaluationRow], best: RecordingRow | None) -> EvaluationRow | None:
    """Return the imitator's game that is shown beside the best demonstration.

    Of its greedy games it is the one whose start is nearest, from a start that no training game
    began from if there is one. How it went does not count.

    Args:
        games: A run's evaluation games, loaded with their recordings.
        best: The best demonstration, if there is one.

    Returns:
        None before the imitator has played.
    """
    greedy = [row for row in games if row.policy == "imitator" and row.action_selection == "greedy"]
    candidates = [row for row in greedy if row.held_out] or greedy

    def distance(row: EvaluationRow) -> float:
        return 0.0 if best is None else _start_distance(row.recording.start, best.start)

    return min(candidates, key=distance, default=None)


def _start_distance(start: Mapping[str, float], other: Mapping[str, float]) -> float:
    """Return the sum of the differences of what two starts set; what one lacks is 0 there."""
    return sum(abs(start.get(name, 0) - other.get(name, 0)) for name in {*start, *other})
