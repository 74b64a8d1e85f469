"""Pieces of the still picture that a game clears or paints: bricks, dots, shields, tiles.

They are where a game's screen begins alike every time, changes and does not change back. What is
alike in size belongs to them, too, also where varied play has not reached it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from tril.games.base import Screen
from tril.vocabulary.formations import Followed
from tril.vocabulary.groups import IN_ORDER, Group, binned
from tril.vocabulary.kinds import Array
from tril.vocabulary.lasting import Mask, lasting, missing_for_good
from tril.vocabulary.trace import Trace, sampled, strides_of

PIECES = 255
"""Stands for the pieces where things are named by the index of their kind."""

MIN_STEPS_LEFT = 15
"""Steps after a change that it takes to tell whether the place changes back."""
STAYING_SHARE = 0.9
"""A place is cleared if it looks changed in this share of the steps after its change."""
MOST_RETURNS = 0.05
"""A place is no piece if it changes back in a larger share of the games in which it changes."""
MIN_GAMES = 2
"""In which a place of a piece is cleared."""
REACHED_SHARE = 0.1
"""An area of one colour is a piece as a whole if this share of it is cleared in some games."""
UNCOUNTED_SHARE = 0.25
"""Share of each line, at its beginning, that does not count as cleared in order."""
MIN_CELLS = 8
"""Sampled pixels of all pieces together; fewer are noise."""
MIN_GAMES_SHARE = 0.2
"""A game has pieces if something is cleared in this share of the varied games."""
MOST_OF_SCREEN = 0.5
"""What covers more of the screen is a picture that moves."""
MOST_AREA = 0.05
"""Of the screen: a larger area of one colour is what is behind the pieces."""


def find_pieces(traces: Sequence[Trace], beginning: Screen) -> Mask | None:
    """Return which pixels are pieces, bool (height, width); None if the game has none.

    Args:
        traces: Varied games.
        beginning: Colours of the screen at the beginning, uint8 (height, width).
    """
    n_cells = sampled(beginning).size
    cleared, returned = np.zeros(n_cells, np.int64), np.zeros(n_cells, np.int64)
    n_clearing = 0
    n_steps = sum(played.n_steps for played in traces)
    # What is there at the beginning and stands somewhere else most of the time is a thing.
    is_still = sum(played.changed.sum(0, dtype=np.int64) for played in traces) < n_steps / 2
    for played in traces:
        changed = played.changed
        lasts = lasting(changed)[:-MIN_STEPS_LEFT]
        if not len(lasts):
            continue
        first = lasts.argmax(0)
        # (n_steps, n_cells): steps from each one on in which a place looks changed.
        n_changed = np.cumsum(changed[::-1], 0, dtype=np.int32)[::-1]
        share = n_changed[first, np.arange(n_cells)] / (len(changed) - first)
        # A place that looks changed from the first step on, as in a maze of its own, tells nothing.
        changes = first > 0
        is_cleared = changes & (share >= STAYING_SHARE) & is_still
        cleared += is_cleared
        returned += changes & ~is_cleared
        n_clearing += bool(is_cleared.any())
    is_piece = (cleared >= MIN_GAMES) & (returned <= MOST_RETURNS * (cleared + returned))
    mask = _with_alike(is_piece, beginning)
    n_found = int(sampled(mask).sum())
    if n_found < MIN_CELLS or n_found > MOST_OF_SCREEN * n_cells:
        return None
    return mask if n_clearing >= MIN_GAMES_SHARE * len(traces) else None


def _with_alike(cleared: Mask, beginning: Screen) -> Mask:
    """Return the pixels of areas of one colour that are cleared, and of those alike in size.

    Args:
        cleared: Which cells are cleared, bool (n_cells,).
        beginning: Colours of the screen at the beginning, uint8 (height, width).
    """
    reached = _spread_out(cleared.reshape(sampled(beginning).shape), beginning.shape)
    # Index of each pixel's area, int32 (height, width); width, height and area of each area.
    area_of = np.zeros(beginning.shape, np.int32)
    sizes = np.empty((0, 3), np.int32)
    for colour in np.unique(beginning):
        _, labels, stats, _ = cv2.connectedComponentsWithStats(
            (beginning == colour).view(np.uint8), connectivity=8
        )
        # Label 0 is what has another colour.
        own = labels > 0
        area_of[own] = labels[own] - 1 + len(sizes)
        size = stats[1:, [cv2.CC_STAT_WIDTH, cv2.CC_STAT_HEIGHT, cv2.CC_STAT_AREA]]
        sizes = np.concatenate([sizes, size])
    n_reached = np.bincount(area_of[reached], minlength=len(sizes))
    is_small = sizes[:, 2] <= MOST_AREA * beginning.size
    is_reached = is_small & (n_reached >= REACHED_SHARE * sizes[:, 2])
    size_of = np.unique(sizes, axis=0, return_inverse=True)[1].ravel()
    is_alike = np.isin(size_of, size_of[is_reached])
    mask: Mask = is_alike[area_of] | (reached & is_small[area_of])
    return mask


def _spread_out(grid: Mask, shape: tuple[int, ...]) -> Mask:
    """Return the pixels that the cells of a sampled screen stand for, bool (height, width)."""
    pixels: Mask = np.kron(grid, np.ones(strides_of(shape), np.bool_))[: shape[0], : shape[1]]
    return pixels


@dataclass(frozen=True, eq=False)
class Gone:
    """What of the pieces, or of the items of a formation, is gone in a game.

    Attributes:
        is_gone: Which cells, or items, are gone in each step, bool (n_steps, n_places).
        x: Where each cell is in pixels, or the column of each item from 0, int64 (n_places,).
        y: The same, downwards.
    """

    is_gone: Mask
    x: npt.NDArray[np.int64]
    y: npt.NDArray[np.int64]

    def facts(self, group: Group) -> Array:
        """Return the facts of a group about them, float32 (n_steps, n_facts), 0 to 1."""
        if group.aspect == "gone":
            share = self.is_gone.mean(1, dtype=np.float32)
            return np.stack([share, np.diff(share, prepend=share[:1]) > 0], 1)
        if group.aspect in IN_ORDER:
            line, along = (self.y, self.x) if group.aspect == "order x" else (self.x, self.y)
            return np.stack([self._in_order(line, along), self._in_order(line, -along)], 1)
        place = self.y if group.aspect == "gone y" else self.x
        in_bin = binned(place.astype(np.float32), group.edges)
        shares: Array = self.is_gone.astype(np.float32) @ (in_bin / in_bin.sum(0).clip(1))
        return shares

    def _in_order(self, line: npt.NDArray[np.int64], along: npt.NDArray[np.int64]) -> Array:
        """Return the share that is gone with all before it in its line, float32 (n_steps,).

        The first quarter of each line does not count: who clears no more has not shown an order.

        Args:
            line: In which line each place is, int64 (n_places,).
            along: Where in its line, int64 (n_places,).
        """
        n_in_order = np.zeros(len(self.is_gone), np.float32)
        order = np.lexsort((along, line))
        begins = np.flatnonzero(np.diff(line[order])) + 1
        for places in np.split(order, begins):
            in_order = np.logical_and.accumulate(self.is_gone[:, places], axis=1)
            n_in_order += in_order[:, math.ceil(UNCOUNTED_SHARE * len(places)) :].sum(1)
        share: Array = n_in_order / np.float32(max(len(order), 1))
        return share


def gone_pieces(played: Trace, pieces: Mask) -> Gone:
    """Return what of the pieces is gone in a game.

    Args:
        played: The game.
        pieces: Which pixels are pieces.
    """
    rows, columns = cells_of(pieces)
    own = np.flatnonzero(sampled(pieces))
    return Gone(lasting(played.changed[:, own]), columns, rows)


def gone_items(followed: Followed) -> Gone:
    """Return what of a formation is gone in a game, by column and row at the beginning."""
    columns, rows = followed.formation.lines
    return Gone(missing_for_good(followed.missing), columns, rows)


@dataclass(frozen=True, eq=False)
class Areas:
    """Connected areas of pieces: single dots, a wall of bricks.

    Attributes:
        boxes: Left, top, width and height of each in pixels, int64 (n_areas, 4).
        of_cell: The index of the area of each cell, int64 (n_cells,).
    """

    boxes: npt.NDArray[np.int64]
    of_cell: npt.NDArray[np.int64]

    @classmethod
    def of(cls, pieces: Mask) -> Areas:
        """Return the areas of some pieces, bool (height, width)."""
        _, labels, stats, _ = cv2.connectedComponentsWithStats(
            pieces.astype(np.uint8), connectivity=8
        )
        # Component 0 is what is not in the mask.
        boxes = stats[1:, : cv2.CC_STAT_AREA].astype(np.int64)
        return cls(boxes, sampled(labels)[sampled(pieces)].astype(np.int64) - 1)

    def are_there(self, is_gone: Mask) -> Mask:
        """Return of which areas something is there, bool (n_steps, n_areas).

        Args:
            is_gone: Which cells are gone, bool (n_steps, n_cells).
        """
        order = np.argsort(self.of_cell, kind="stable")
        areas, begins = np.unique(self.of_cell[order], return_index=True)
        are_there = np.zeros((len(is_gone), len(self.boxes)), np.bool_)
        are_there[:, areas] = np.logical_or.reduceat(~is_gone[:, order], begins, axis=1)
        return are_there


def cells_of(mask: Mask) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """Return row and column in pixels of each cell that a mask covers."""
    down, right = strides_of(mask.shape)
    rows, columns = np.nonzero(sampled(mask))
    return rows * down, columns * right
