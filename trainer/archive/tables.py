"""The tables of an archive, as CSV."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Sequence

from tril.store.models import EvaluationRow
from tril.store.training.evaluations import figures_of
from tril.store.training.metrics import Series

EVALUATION_COLUMNS = (
    "policy",
    "action_selection",
    "start_number",
    "held_out",
    "targets",
    "strays",
    "order_errors",
    "aliens",
    "steps",
    "died",
    "end",
    "predicted_return",
    "final_level",
    "recording",
)


def curves_table(series: Series) -> str:
    """Return the points of a run's curves, one a row."""
    return _table(
        ("stage", "step", "name", "value"),
        (
            (stage, step, name, value)
            for stage, curves in series.items()
            for name, curve in curves.items()
            for step, value in curve
        ),
    )


def evaluation_table(games: Sequence[EvaluationRow]) -> str:
    """Return the evaluation games, loaded with their recordings, one a row.

    ``recording`` is the line, from 1, of the game in recordings/evaluation.jsonl.
    """
    rows = []
    for line, game in enumerate(games, start=1):
        figures = figures_of(game)
        rows.append(
            (
                game.policy,
                game.action_selection,
                game.start_number,
                game.held_out,
                game.targets,
                game.strays,
                game.order_errors,
                len(game.recording.taken),
                figures.steps,
                figures.died,
                game.recording.end,
                game.predicted_return,
                game.final_level,
                line,
            )
        )
    return _table(EVALUATION_COLUMNS, rows)


def _table(columns: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows([_plain(cell) for cell in row] for row in rows)
    return text.getvalue()


def _plain(cell: object) -> object:
    """Return a cell that spreadsheets take for text if it is one, not for a formula (OWASP)."""
    is_formula = isinstance(cell, str) and cell.startswith(("=", "+", "-", "@", "\t", "\r", "\n"))
    return f"'{cell}" if is_formula else cell
