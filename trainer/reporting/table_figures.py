"""Pictures of several behaviours at once, for the page of all results."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from trainer.reporting.figures import COLOURS, calm, draw_aliens, grid_of_axes, rendered
from tril.behaviours import Behaviour, Cell

PANELS_A_ROW = 4


@dataclass(frozen=True)
class AliensRow:
    """A behaviour's games.

    Attributes:
        behaviour: What was taught.
        hits: Of each game the cells hit, in order of time; None where none was played.
    """

    behaviour: Behaviour
    hits: tuple[tuple[Cell, ...] | None, ...]


@dataclass(frozen=True)
class ReturnsPanel:
    """A behaviour's predicted returns by rank, and Kendall's tau between the two if known."""

    title: str
    ranks: Sequence[int]
    returns: Sequence[float]
    tau: float | None


def aliens_table(rows: Sequence[AliensRow], columns: Sequence[tuple[str, str]]) -> bytes:
    """Draw the aliens left after each game: one row a behaviour (thesis, table 6.1).

    Args:
        rows: The behaviours.
        columns: Of each the thing that gives the colour (a key of COLOURS), and the heading.
    """
    figure, axes = grid_of_axes(
        1.5 * len(columns) + 0.9, 1.5 * len(rows) + 0.6, len(rows), len(columns)
    )
    for index, row in enumerate(rows):
        for number, (thing, title) in enumerate(columns):
            axis = axes[index][number]
            draw_aliens(axis, row.behaviour, row.hits[number], COLOURS[thing])
            if index == 0:
                axis.set_title(title.capitalize(), fontsize=9, color=COLOURS[thing], pad=8)
            if number == 0:
                axis.set_ylabel(row.behaviour.name, fontsize=9, labelpad=8)
    return rendered(figure)


def returns_table(panels: Sequence[ReturnsPanel]) -> bytes:
    """Draw predicted return against rank, a panel a behaviour (thesis, appendix C)."""
    n_rows = -(-len(panels) // PANELS_A_ROW)
    n_columns = min(PANELS_A_ROW, len(panels))
    figure, axes = grid_of_axes(2.6 * n_columns, 2.2 * n_rows, n_rows, n_columns)
    flat = [axis for row in axes for axis in row]
    for axis, panel in zip(flat, panels, strict=False):
        axis.plot(panel.ranks, panel.returns, "o", color=COLOURS["imitator"], markersize=4)
        tau = "" if panel.tau is None else f", tau {panel.tau:.2f}"
        axis.set_title(f"{panel.title}{tau}", fontsize=9, loc="left")
        axis.set_xticks([1, 6, 12])
        calm(axis)
    for axis in flat[len(panels) :]:
        axis.set_visible(False)
    for row in axes:
        row[0].set_ylabel("predicted return", fontsize=8)
    for axis in axes[-1]:
        axis.set_xlabel("rank (1 is the best)", fontsize=8)
    return rendered(figure)
