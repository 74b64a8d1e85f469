"""Pictures of what was learned, as PNG bytes. Pixels are enlarged by whole numbers only."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from io import BytesIO
from typing import Literal

import matplotlib
import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from PIL import Image

from tril.analysis.extrapolation import JudgedGames
from tril.behaviours import Behaviour, Cell, score
from tril.game.space_invaders import COLUMNS, ROWS

MAP_SCALE = 4
FRAME_SCALE = 2

COLOURS = {
    "imitator": "#0067b0",
    "clone": "#b65800",
    "person": "#007d5a",
    "demonstrator": "#a8457f",
}
"""One colour per thing, those of the pages (frontend/src/styles/tokens.css)."""

MARKS = {"imitator": "o", "clone": "D", "person": "^", "demonstrator": "s"}
"""One shape per thing, those of the pages (frontend/src/components/ThingMark.tsx)."""

_BAND = "#f2f0ea"
_INK, _FAINT, _STRAY = "#20242b", "#c9ced6", "#b3261e"

ColourMap = Literal["perceptual", "red-blue"]
_COLOUR_MAPS: dict[ColourMap, str] = {"perceptual": "inferno", "red-blue": "RdBu_r"}


def attention_picture(attention: npt.NDArray[np.float32], colour_map: ColourMap) -> bytes:
    """Draw an attention map: brightest or reddest where the attention is greatest.

    Args:
        attention: float32 (84, 84), non-negative; its own maximum is the end of the scale.
        colour_map: "perceptual" (equal steps look equal) or "red-blue" as in the thesis.
    """
    peak = float(attention.max())
    shares = attention / peak if peak > 0 else np.zeros_like(attention)
    colours = matplotlib.colormaps[_COLOUR_MAPS[colour_map]](shares)[..., :3]
    return _png((colours * 255).round().astype(np.uint8), MAP_SCALE)


def frame_picture(screen: npt.NDArray[np.uint8]) -> bytes:
    """Draw a screen of the game, uint8 (210, 160, 3)."""
    return _png(screen, FRAME_SCALE)


@dataclass(frozen=True)
class PlayedColumn:
    """One column of the comparison: who played, and the hits of each start's game.

    Attributes:
        thing: A key of COLOURS.
        title: Heading, e.g. "Imitator".
        hits: For each start the cells hit, in order of time; None where no game was played.
    """

    thing: str
    title: str
    hits: tuple[tuple[Cell, ...] | None, ...]


def comparison_figure(
    behaviour: Behaviour, starts: Sequence[str], columns: Sequence[PlayedColumn]
) -> bytes:
    """Draw the aliens left after each start's game, side by side (thesis, section 5.2).

    Filled squares are aliens left, rings are targets hit, crosses are strays.

    Args:
        behaviour: What was taught.
        starts: Name of each row.
        columns: Who played.
    """
    height, width = 1.5 * len(starts) + 0.7, 1.75 * len(columns) + 0.9
    figure, axes = grid_of_axes(width, height, len(starts), len(columns))
    for row, name in enumerate(starts):
        for number, column in enumerate(columns):
            axis = axes[row][number]
            draw_aliens(axis, behaviour, column.hits[row], COLOURS[column.thing])
            if row == 0:
                axis.set_title(column.title, fontsize=10, color=COLOURS[column.thing], pad=8)
            if number == 0:
                axis.set_ylabel(name, fontsize=9, color=_INK, labelpad=8)
    return rendered(figure)


def returns_figure(tiers: Sequence[int], returns: Sequence[float], tau: float) -> bytes:
    """Draw predicted return against rank (thesis, appendix C).

    Args:
        tiers: The tier of each demonstration, 1 the best.
        returns: Its predicted return.
        tau: Kendall's tau between the two.
    """
    figure, ((axis,),) = grid_of_axes(4.8, 3.2, 1, 1)
    axis.plot(tiers, returns, "o", color=COLOURS["imitator"], markersize=6)
    axis.set_xlabel("rank given (1 is the best)", color=_INK)
    axis.set_ylabel("predicted return", color=_INK)
    axis.set_xticks(sorted(set(tiers)))
    axis.set_title(f"Kendall's tau {tau:.2f}", fontsize=10, loc="left", color=_INK)
    calm(axis)
    return rendered(figure)


@dataclass(frozen=True)
class ReturnsGroup:
    """Games of one kind, by what they were worth and what the learned reward makes of them.

    Attributes:
        label: What the legend says.
        colour: Of the marks.
        mark: Their shape, as matplotlib names it.
        demonstrated: Whether the reward was learned from them.
        worths: The true quantity of each.
        returns: The predicted return of each.
    """

    label: str
    colour: str
    mark: str
    demonstrated: bool
    worths: Sequence[float]
    returns: Sequence[float]


def extrapolation_figure(groups: Sequence[JudgedGames], quantity: str) -> bytes:
    """Draw predicted return against true quantity for the games of a run, see returns_scatter."""
    return returns_scatter(
        [
            ReturnsGroup(
                f"{one.player}, {'demonstrations' if one.demonstrated else 'unseen games'}",
                COLOURS[one.player],
                MARKS[one.player],
                one.demonstrated,
                [game.true_quantity for game in one.games],
                [game.predicted_return for game in one.games],
            )
            for one in groups
        ],
        quantity,
    )


def returns_scatter(
    groups: Sequence[ReturnsGroup], quantity: str, *, set_apart: bool = True
) -> bytes:
    """Draw predicted return against true quantity (T-REX, Brown et al. 2019, figure 3).

    Filled marks are demonstrations, hollow ones games that the reward was not learned from. The
    band is the range of the demonstrations: what lies beyond it is extrapolated.

    Args:
        groups: The games, at least one in each group.
        quantity: What the true quantity counts.
        set_apart: Whether marks that share a quantity are set apart by their groups.
    """
    figure, ((axis,),) = grid_of_axes(6.0, 4.0, 1, 1)
    worths = [worth for group in groups if group.demonstrated for worth in group.worths]
    returns = [value for group in groups if group.demonstrated for value in group.returns]
    if worths:
        axis.axvspan(min(worths) - 0.5, max(worths) + 0.5, color=_BAND, linewidth=0)
        axis.axhline(max(returns), color=_FAINT, linewidth=1, linestyle="--")
        axis.axhline(min(returns), color=_FAINT, linewidth=1, linestyle="--")
    for place, group in enumerate(groups):
        apart = 0.5 * (place - (len(groups) - 1) / 2) / len(groups) if set_apart else 0.0
        axis.plot(
            [worth + apart for worth in group.worths],
            group.returns,
            group.mark,
            color=group.colour,
            markersize=6,
            markerfacecolor=None if group.demonstrated else "none",
            label=group.label,
        )
    axis.set_xlabel(quantity, color=_INK)
    axis.set_ylabel("predicted return", color=_INK)
    axis.xaxis.set_major_locator(MaxNLocator(integer=True))
    calm(axis)
    axis.legend(fontsize=8, frameon=False)
    return rendered(figure)


def curves_figure(
    curves: Sequence[tuple[str, str, Sequence[tuple[int, float]]]], x_label: str
) -> bytes:
    """Draw curves below each other, sharing their horizontal axis.

    Args:
        curves: Of each its label, a colour and its points (step, value).
        x_label: What the steps count.
    """
    figure, axes = grid_of_axes(6.4, 1.6 * len(curves) + 0.6, len(curves), 1, share_x=True)
    for (axis,), (label, colour, points) in zip(axes, curves, strict=True):
        if points:
            steps, values = zip(*points, strict=True)
            axis.plot(steps, values, color=colour, linewidth=1.6)
        axis.set_ylabel(label, fontsize=9, color=_INK)
        calm(axis)
    axes[-1][0].set_xlabel(x_label, color=_INK)
    return rendered(figure)


def draw_aliens(
    axis: Axes, behaviour: Behaviour, hits: tuple[Cell, ...] | None, colour: str
) -> None:
    """Draw the grid of aliens after a game.

    Args:
        axis: Where.
        behaviour: What was taught.
        hits: The cells hit, in order of time; None where no game was played.
        colour: Of the targets.
    """
    axis.set_xlim(-0.6, COLUMNS - 0.4)
    axis.set_ylim(-0.6, ROWS - 0.4)
    axis.set_aspect("equal")
    axis.set_xticks([])
    axis.set_yticks([])
    for spine in axis.spines.values():
        spine.set_visible(False)
    if hits is None:
        axis.text(2.5, 2.5, "not played", ha="center", va="center", fontsize=8, color=_FAINT)
        return
    targets = set(behaviour.target or ())
    for cell in ((r, c) for r in range(ROWS) for c in range(COLUMNS)):
        row, column = cell
        if cell not in hits:
            axis.plot(column, row, "s", markersize=7, color=colour if cell in targets else _FAINT)
        elif cell in targets or behaviour.target is None:
            axis.plot(column, row, "o", markersize=6, markerfacecolor="none", color=colour)
        else:
            axis.plot(column, row, "x", markersize=6, color=_STRAY, markeredgewidth=1.6)
    result = score(behaviour, hits)
    text = f"{len(hits)} hit" if result is None else f"{result.targets} + {result.strays} stray"
    axis.set_xlabel(text, fontsize=8, color=_INK, labelpad=3)


def grid_of_axes(
    width: float, height: float, n_rows: int, n_columns: int, share_x: bool = False
) -> tuple[Figure, list[list[Axes]]]:
    """A figure without the global state of pyplot, and its axes by row and column."""
    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(n_rows, n_columns, squeeze=False, sharex=share_x)
    return figure, [list(row) for row in axes]


def calm(axis: Axes) -> None:
    """Take away what draws the eye from the data."""
    for side in ("top", "right"):
        axis.spines[side].set_visible(False)
    axis.tick_params(labelsize=8, colors=_INK)
    axis.grid(visible=True, color=_FAINT, linewidth=0.5, alpha=0.6)


def rendered(figure: Figure) -> bytes:
    """Return the figure as PNG bytes."""
    target = BytesIO()
    figure.savefig(target, format="png", dpi=160, facecolor="white")
    return target.getvalue()


def _png(pixels: npt.NDArray[np.uint8], scale: int) -> bytes:
    enlarged = pixels.repeat(scale, axis=0).repeat(scale, axis=1)
    target = BytesIO()
    Image.fromarray(enlarged).save(target, format="png", optimize=True)
    return target.getvalue()
