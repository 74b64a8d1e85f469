"""A run, read from the database as an entry of the ledger."""

from __future__ import annotations

from collections import defaultdict

from sqlalchemy.orm import Session

from trainer.reporting.ledger import (
    DEVICE,
    PRECISION,
    Entry,
    LedgerCell,
    LedgerDemonstration,
    LedgerGame,
)
from tril.analysis.outcome import ImitatorOutcome, RunOutcome
from tril.demonstrators import kind_named
from tril.errors import Invalid
from tril.games.base import Cell
from tril.recipes import RECIPES, changed_values, recipe_from_dict
from tril.store import behaviours, recordings
from tril.store.database import Database
from tril.store.models import RecordingRow, RunRow, RunStatus
from tril.store.recordings import cells_of
from tril.store.training import evaluations, runs


def read_entry(database: Database, run_id: str) -> Entry:
    """Read a finished run.

    Raises:
        NotFound: No such run, or its behaviour was deleted.
        Invalid: The run is not done, or its recipe is one of another version.
    """
    with database.reading() as session:
        run = runs.get(session, run_id)
        if run.status != RunStatus.DONE:
            raise Invalid(f"Run {run_id} is {run.status}; only a finished one is a result.")
        return entry_of(session, run)


def entry_of(session: Session, run: RunRow) -> Entry:
    """Return the ledger entry of a run, ``finished_at`` empty while it is not over.

    Raises:
        NotFound: The run's behaviour was deleted.
        Invalid: The run's recipe belongs to another version.
    """
    recipe = recipe_from_dict(run.recipe)
    changes = changed_values(recipe, RECIPES[recipe.name]) if recipe.name in RECIPES else {}
    check, imitator = run.outcome.check, run.outcome.imitator or ImitatorOutcome()
    learned_on = {PRECISION: imitator.precision, DEVICE: imitator.device}
    returns = check.predicted_returns if check else {}
    levels = check.final_levels if check else {}
    tiers = run.snapshot.tiers if run.snapshot else []
    rows = recordings.by_ids(session, list(returns))
    games = defaultdict(list)
    for row in evaluations.listing(session, run.id):
        figures = evaluations.figures_of(row)
        games[f"{row.policy} {row.action_selection}"].append(
            LedgerGame(
                row.start_number,
                row.held_out,
                cells(row.recording),
                figures.steps,
                figures.died,
                figures.predicted_return,
            )
        )
    slug = behaviours.get(session, run.behaviour_id).slug
    return Entry(
        cell=LedgerCell.of(slug, recipe, run.steps, run.training_seed, run.example_kind),
        finished_at=run.finished_at.isoformat(timespec="seconds") if run.finished_at else "",
        seconds=run.finished_stages,
        check=check.figures if check else {},
        versions=run.versions | {name: value for name, value in learned_on.items() if value},
        demonstrations=tuple(
            LedgerDemonstration(rank, cells(rows[number]), returns[number], levels.get(number))
            for rank, tier in enumerate(tiers, start=1)
            for number in tier
            if number in returns
        ),
        games={key: tuple(played) for key, played in games.items()},
        # As JSON gives them back.
        changes={k: list(v) if isinstance(v, tuple) else v for k, v in changes.items()},
    )


def describe_example(outcome: RunOutcome) -> str:
    """Describe the kind of a run's demonstrations and the mistakes in their ranking.

    Args:
        outcome: The run's.

    Returns:
        A sentence or two; nothing for the ordinary example and for a person's demonstrations.
    """
    example = outcome.example
    if example is None:
        return ""
    kind, n_wrong = kind_named(example.kind), len(example.mistakes)
    pairs = "pair of neighbours is" if n_wrong == 1 else "pairs of neighbours are"
    order = (
        f"{n_wrong} {pairs} ranked the wrong way round (tau {example.tau:.2f}"
        " with what the games show)."
    )
    if not n_wrong:
        order = "They are ranked without mistakes."
    return f"The demonstrations are of the kind \u201c{kind.name}\u201d: {kind.summary}. {order}"


def cells(row: RecordingRow) -> tuple[Cell, ...]:
    """Return the items taken in a recording, in order of time."""
    return cells_of(row)
