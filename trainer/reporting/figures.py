"""Pictures of what was learned. Pixels are enlarged by whole numbers only."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Literal, NamedTuple

import matplotlib
import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Text
from matplotlib.ticker import MaxNLocator
from PIL import Image, ImageDraw

from trainer.reporting.ledger import Entry
from tril.analysis.extrapolation import JudgedGames, Measure
from tril.games.base import Cell
from tril.games.behaviours import Behaviour, score
from tril.games.space_invaders.memory import COLUMNS, ROWS

# Not as a matplotlibrc of the current folder or of the home folder has it.
matplotlib.rcdefaults()

MAP_SCALE = 4
FRAME_SCALE = 2
PANELS_PER_ROW = 4

COLOURS = {
    "imitator": "#0067b0",
    "clone": "#b65800",
    "person": "#007d5a",
    "demonstrator": "#a8457f",
    "varied": "#6b675f",
}
"""One colour per thing, those of the pages (frontend/src/styles/tokens.css)."""

MARKS = {"imitator": "o", "clone": "D", "person": "^", "demonstrator": "s", "varied": "P"}
"""One shape per thing, those of the pages (frontend/src/components/ThingMark.tsx)."""

MEASURES: dict[Measure, str] = {
    "final_level": "final level of R",
    "predicted_return": "predicted return",
}
"""What of R a figure shows."""

_BAND = "#f2f0ea"
_INK, _FAINT, _STRAY = "#20242b", "#c9ced6", "#b3261e"


class PictureForm(NamedTuple):
    """The format of a figure, as matplotlib names it, and its dots per inch."""

    format: str
    dpi: int


SCREEN = PictureForm("png", 160)
PRINT = PictureForm("png", 300)
VECTOR = PictureForm("svg", 72)

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


def attention_figure(title: str, states: Sequence[tuple[str, Path, Path]]) -> bytes:
    """Put attention maps above the screens that they are of, pixel by pixel.

    Args:
        title: Title of the figure, the reward model's training data.
        states: Name, map picture and screen picture of each state.
    """
    margin, head = 8, 56
    pictures = [[Image.open(path).convert("RGB") for path in paths] for _, *paths in states]
    width = max(picture.width for column in pictures for picture in column)
    heights = [max(column[row].height for column in pictures) for row in (0, 1)]
    size = (len(states) * (width + margin) + margin, head + sum(heights) + 2 * margin)
    figure = Image.new("RGB", size, "white")
    draw = ImageDraw.Draw(figure)
    draw.text((margin, 6), title, _INK, font_size=18)
    for number, ((name, *_), column) in enumerate(zip(states, pictures, strict=True)):
        left = margin + number * (width + margin)
        draw.text((left, head - 24), name, _INK, font_size=15)
        figure.paste(column[0], (left, head))
        figure.paste(column[1], (left, head + heights[0] + margin))
    return _encoded(figure)


@dataclass(frozen=True)
class AliensRow:
    """A row of aliens_figure: its label, what was taught, and the hits of each column's game.

    Hits are None where no game was played.
    """

    name: str
    behaviour: Behaviour
    hits: tuple[tuple[Cell, ...] | None, ...]


def aliens_figure(
    rows: Sequence[AliensRow], columns: Sequence[tuple[str, str]], form: PictureForm = SCREEN
) -> bytes:
    """Draw the aliens left after each game (thesis, section 5.2 and table 6.1).

    Filled squares are aliens left, rings are targets hit, crosses are strays.

    Args:
        rows: The games.
        columns: Player (a key of COLOURS) and heading of each column.
        form: Format of the figure.
    """
    figure, axes = _grid_of_axes(
        1.5 * len(columns) + 0.9, 1.5 * len(rows) + 0.6, len(rows), len(columns)
    )
    for index, row in enumerate(rows):
        for number, (player, title) in enumerate(columns):
            axis = axes[index][number]
            _draw_aliens(axis, row.behaviour, row.hits[number], COLOURS[player])
            if index == 0:
                axis.set_title(title, fontsize=9, color=COLOURS[player], pad=8)
            if number == 0:
                axis.set_ylabel(row.name, fontsize=9, labelpad=8)
    return _rendered(figure, form)


def returns_figure(panels: Sequence[tuple[str, Entry]], form: PictureForm = SCREEN) -> bytes:
    """Draw what R makes of the demonstrations against rank (thesis, appendix C).

    The final levels, by which the ranking is checked; predicted returns where a panel has a result
    of an earlier version, which did not keep them.

    Args:
        panels: Title and result of each panel.
        form: Format of the figure.
    """
    measure: Measure = (
        "final_level" if all(entry.has_levels for _, entry in panels) else "predicted_return"
    )
    n_columns = min(PANELS_PER_ROW, len(panels))
    n_rows = -(-len(panels) // PANELS_PER_ROW)
    width, height = (4.8, 3.2) if len(panels) == 1 else (2.6 * n_columns, 2.2 * n_rows)
    figure, axes = _grid_of_axes(width, height, n_rows, n_columns)
    flat = [axis for row in axes for axis in row]
    for axis, (title, entry) in zip(flat, panels, strict=False):
        ranks = [demonstration.rank for demonstration in entry.demonstrations]
        predicted = [getattr(demonstration, measure) for demonstration in entry.demonstrations]
        axis.plot(ranks, predicted, "o", color=COLOURS["imitator"], markersize=4)
        tau = entry.check.get("tau")
        label = title if tau is None else f"{title}, tau {tau:.2f}"
        axis.set_title(label, fontsize=9, loc="left")
        last = max(ranks, default=1)
        axis.set_xticks(sorted({1, -(-last // 2), last}))
        _calm(axis)
    for axis in flat[len(panels) :]:
        axis.set_visible(False)
    for row in axes:
        row[0].set_ylabel(MEASURES[measure], fontsize=8)
    for axis in axes[-1]:
        axis.set_xlabel("rank (1 is the best)", fontsize=8)
    return _rendered(figure, form)


def extrapolation_figure(
    groups: Sequence[JudgedGames], quantity: str, form: PictureForm = SCREEN
) -> bytes:
    """Draw what R predicts against true quantity (T-REX, Brown et al. 2019, figure 3).

    Filled marks are demonstrations, hollow ones games that the reward was not learned from. The
    band is the range of the demonstrations: what lies beyond it is extrapolated.

    Args:
        groups: The games of a run, at least one in each group.
        quantity: Label of the true quantity.
        form: Format of the figure.
    """
    figure, ((axis,),) = _grid_of_axes(6.0, 4.0, 1, 1)
    demonstrated = [game for group in groups if group.demonstrated for game in group.games]
    if demonstrated:
        worths = [game.true_quantity for game in demonstrated]
        predicted = [game.predicted for game in demonstrated]
        axis.axvspan(min(worths) - 0.5, max(worths) + 0.5, color=_BAND, linewidth=0)
        axis.axhline(max(predicted), color=_FAINT, linewidth=1, linestyle="--")
        axis.axhline(min(predicted), color=_FAINT, linewidth=1, linestyle="--")
    for place, group in enumerate(groups):
        # Marks that share a quantity are set apart by their groups.
        apart = 0.5 * (place - (len(groups) - 1) / 2) / len(groups)
        kind = "demonstrations" if group.demonstrated else "unseen games"
        axis.plot(
            [game.true_quantity + apart for game in group.games],
            [game.predicted for game in group.games],
            MARKS[group.player],
            color=COLOURS[group.player],
            markersize=6,
            markerfacecolor=None if group.demonstrated else "none",
            label=f"{group.player}, {kind}",
        )
    axis.set_xlabel(quantity, color=_INK)
    axis.set_ylabel(MEASURES[groups[0].measure], color=_INK)
    axis.xaxis.set_major_locator(MaxNLocator(integer=True))
    _calm(axis)
    axis.legend(fontsize=8, frameon=False)
    return _rendered(figure, form)


def curves_figure(
    curves: Sequence[tuple[str, str, Sequence[tuple[int, float]]]],
    x_label: str,
    form: PictureForm = SCREEN,
) -> bytes:
    """Draw curves below each other, sharing their horizontal axis.

    Args:
        curves: Label, colour and points (step, value) of each curve.
        x_label: Label of the steps.
        form: Format of the figure.
    """
    figure, axes = _grid_of_axes(6.4, 1.6 * len(curves) + 0.6, len(curves), 1, share_x=True)
    for (axis,), (label, colour, points) in zip(axes, curves, strict=True):
        if points:
            steps, values = zip(*points, strict=True)
            axis.plot(steps, values, color=colour, linewidth=1.6)
        axis.set_ylabel(label, fontsize=9, color=_INK)
        _calm(axis)
    axes[-1][0].set_xlabel(x_label, color=_INK)
    return _rendered(figure, form)


def _draw_aliens(
    axis: Axes, behaviour: Behaviour, hits: tuple[Cell, ...] | None, colour: str
) -> None:
    """Draw the grid of aliens after a game, targets in a colour."""
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


def _grid_of_axes(
    width: float, height: float, n_rows: int, n_columns: int, share_x: bool = False
) -> tuple[Figure, list[list[Axes]]]:
    """A figure without the global state of pyplot, and its axes by row and column."""
    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(n_rows, n_columns, squeeze=False, sharex=share_x)
    return figure, [list(row) for row in axes]


def _calm(axis: Axes) -> None:
    """Take away what draws the eye from the data."""
    for side in ("top", "right"):
        axis.spines[side].set_visible(False)
    axis.tick_params(labelsize=8, colors=_INK)
    axis.grid(visible=True, color=_FAINT, linewidth=0.5, alpha=0.6)


def _rendered(figure: Figure, form: PictureForm) -> bytes:
    target = BytesIO()
    # Without the time at which it was drawn.
    metadata = {"Date": None} if form is VECTOR else None
    # The same figure gives the same file, whatever fonts its reader has.
    # Names are text, not mathematics: $\frac$ would be an error.
    for text in figure.findobj(Text):
        text.set_parse_math(False)
    with matplotlib.rc_context(
        {"svg.hashsalt": "tril", "svg.fonttype": "path", "text.parse_math": False}
    ):
        figure.savefig(
            target, format=form.format, dpi=form.dpi, facecolor="white", metadata=metadata
        )
    return target.getvalue()


def _png(pixels: npt.NDArray[np.uint8], scale: int) -> bytes:
    enlarged = pixels.repeat(scale, axis=0).repeat(scale, axis=1)
    return _encoded(Image.fromarray(enlarged))


def _encoded(picture: Image.Image) -> bytes:
    target = BytesIO()
    picture.save(target, format="png", optimize=True)
    return target.getvalue()
