"""Formations: things that look alike, begin in rows or columns and move together.

What is gone of one is known by following where the rest is. A set of alike things that stays where
it is, as bricks or dots, is told by `pieces`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from tril.games.base import Screen
from tril.vocabulary.lasting import LASTING_STEPS, Mask, lasting

FORMATION = 254
"""Stands for the formation where things are named by the index of their kind."""

Shift = npt.NDArray[np.int64]
"""Pixels to the right and down from where a formation begins, int64 (2,)."""

MIN_ITEMS = 8
MOST_THINGS = 255
"""On a screen: more are a texture."""
MIN_SIZE_PX = 3
MOST_SIZE_PX = 24
"""Width and height of an item."""
SIZE_RATIO = 1.6
"""Widths, and heights, of items differ at most by this factor from those of one of them."""
MOST_COMPARED = 400
"""Pixels by which the shift is found."""
MOST_STEP_PX = 3
"""How far a formation usually moves within a step, in each direction."""
MOST_JUMP_PX = 14
"""How far it moves at most, as when it comes a row closer."""
SEEN_SHARE = 0.3
"""Of an item's pixels in its colour where it should be, for it to be there."""
FOUND_SHARE = 0.5
"""Of the pixels of all items that are left; a formation with fewer is looked for further away."""
MOST_AT_ONCE = 0.4
"""Of the items that are left: where more are missing in a step, the whole formation is hidden."""
MARGIN_PX = 4
"""Around an item as it is at the beginning: what has its colours there is a part of it."""
MIN_MOVED_PX = 8
"""From where it begins, for a formation to have moved."""
MOST_STAYING = 0.5
"""Share of the games in which a formation moves: what is not where it should be in more of them,
when it has moved, does not belong to it."""
MIN_GAMES_SHARE = 0.2
"""Of the games that are followed, those in which a formation moves, and in which some of it is
gone."""
NEW_WAVE_SHARE = 0.8
"""Of the pixels of all items where they begin, when most were gone: the next wave is there."""
OFFSET_PX = 2
"""To which the offset to the nearest item is rounded: items are a pixel off their lines."""
MIN_FOUND = 0.9
"""Of the steps of varied play in which a formation is found."""


@dataclass(frozen=True, eq=False)
class Formation:
    """A set of alike things as they are at the beginning.

    Attributes:
        items: Which item each pixel belongs to, counted from 1, uint8 (height, width); 0: none.
        colours: Colour of each pixel of an item, uint8 (height, width); 0 elsewhere.
    """

    items: npt.NDArray[np.uint8]
    colours: Screen

    @property
    def n_items(self) -> int:
        """Number of items."""
        return int(self.items.max())

    @cached_property
    def pixels(self) -> Pixels:
        """The pixels of all items."""
        rows, columns = np.nonzero(self.items)
        item = self.items[rows, columns].astype(np.int64) - 1
        return Pixels(rows, columns, self.colours[rows, columns], item)

    @cached_property
    def has_colour(self) -> Mask:
        """Which colours the items have, bool (256,)."""
        return np.bincount(self.pixels.colours, minlength=256) > 0

    @cached_property
    def areas(self) -> npt.NDArray[np.int64]:
        """Pixels of each item, int64 (n_items,)."""
        return np.bincount(self.pixels.item, minlength=self.n_items)

    @cached_property
    def centres(self) -> npt.NDArray[np.float64]:
        """Where each item is at the beginning, float64 (n_items, 2): x and y in pixels."""
        found = self.pixels
        sums = [
            np.bincount(found.item, at, minlength=self.n_items)
            for at in (found.columns, found.rows)
        ]
        centres: npt.NDArray[np.float64] = np.stack(sums, 1) / self.areas[:, None]
        return centres

    @cached_property
    def boxes(self) -> npt.NDArray[np.int64]:
        """Left, top, right and bottom of each item, int64 (n_items, 4); right, bottom beyond it."""
        found = self.pixels
        boxes = np.empty((self.n_items, 4), np.int64)
        for index in range(self.n_items):
            own = found.item == index
            rows, columns = found.rows[own], found.columns[own]
            boxes[index] = columns.min(), rows.min(), columns.max() + 1, rows.max() + 1
        return boxes

    @property
    def lines(
        self,
    ) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
        """Number of the column, and of the row, that each item stands in, from 0, int64."""
        sizes = np.median(self.boxes[:, 2:] - self.boxes[:, :2], axis=0)
        columns, rows = (
            _lines(self.centres[:, axis], float(size)) for axis, size in enumerate(sizes)
        )
        return columns, rows

    def without(self, dropped: Mask) -> Formation:
        """Return the formation without some items, bool (n_items,)."""
        number = np.zeros(self.n_items + 1, np.uint8)
        number[1:][~dropped] = np.arange(1, (~dropped).sum() + 1)
        items = number[self.items]
        return Formation(items, np.where(items > 0, self.colours, 0).astype(np.uint8))


@dataclass(frozen=True, eq=False)
class Pixels:
    """Pixels of a formation's items, (n_pixels,) each.

    Attributes:
        rows: int64.
        columns: int64.
        colours: uint8.
        item: Index of the item, int64.
    """

    rows: npt.NDArray[np.int64]
    columns: npt.NDArray[np.int64]
    colours: Screen
    item: npt.NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.rows)

    def some(self, of: npt.NDArray[Any]) -> Pixels:
        """Return some of them, by a mask or by indices."""
        return Pixels(self.rows[of], self.columns[of], self.colours[of], self.item[of])

    def seen(self, screen: Screen, shifts: npt.NDArray[np.int64]) -> Mask:
        """Return which are seen on a screen after each of some shifts.

        Args:
            screen: uint8 (height, width).
            shifts: Pixels to the right and down, int64 (n_shifts, 2).

        Returns:
            bool (n_shifts, n_pixels).
        """
        height, width = screen.shape
        columns, rows = self.columns + shifts[:, :1], self.rows + shifts[:, 1:]
        inside = (rows >= 0) & (rows < height) & (columns >= 0) & (columns < width)
        at = screen[rows.clip(0, height - 1), columns.clip(0, width - 1)]
        seen: Mask = (at == self.colours) & inside
        return seen


def alike_things(beginning: Screen) -> Formation | None:
    """Return the largest set of alike things on a screen; None if there is none.

    Parts that are at most two pixels apart are one thing.

    Args:
        beginning: Colours of the screen at the beginning, uint8 (height, width).
    """
    is_drawn = (beginning != np.bincount(beginning.ravel()).argmax()).view(np.uint8)
    # Joined: (height + 2, width + 2), 1 within a pixel of what is drawn.
    joined = cv2.dilate(np.pad(is_drawn, 1), np.ones((3, 3), np.uint8))
    _, padded, stats, _ = cv2.connectedComponentsWithStats(joined, connectivity=8)
    labels = padded[1:-1, 1:-1]
    # Component 0 is what is not drawn; the sizes are those of what is joined.
    sizes = (stats[:, [cv2.CC_STAT_WIDTH, cv2.CC_STAT_HEIGHT]] - 2).clip(1)
    fits = np.all((sizes >= MIN_SIZE_PX) & (sizes <= MOST_SIZE_PX), axis=1)
    fits[0] = False
    things = np.flatnonzero(fits)
    if not MIN_ITEMS <= len(things) <= MOST_THINGS:
        return None
    # (n_things, n_things): which are alike in size.
    ratio = sizes[things][:, None] / sizes[things]
    is_alike = np.all((ratio <= SIZE_RATIO) & (ratio * SIZE_RATIO >= 1), axis=2)
    alike = things[is_alike[is_alike.sum(1).argmax()]]
    if len(alike) < MIN_ITEMS:
        return None
    item_of = np.zeros(len(stats), np.uint8)
    item_of[alike] = np.arange(1, len(alike) + 1)
    items = (item_of[labels] * is_drawn).astype(np.uint8)
    return Formation(items, np.where(items > 0, beginning, 0).astype(np.uint8))


@dataclass(frozen=True, eq=False)
class Followed:
    """Where a formation is in a game, and what is left of it.

    Attributes:
        formation: The formation.
        missing: Which items are not where they should be after each step, bool (n_steps, n_items).
        shifts: Pixels to the right and down from where it begins, int64 (n_steps, 2).
        is_found: Whether it is there, bool (n_steps,).
    """

    formation: Formation
    missing: Mask
    shifts: npt.NDArray[np.int64]
    is_found: Mask

    @property
    def are_there(self) -> Mask:
        """Which items are seen in each step, bool (n_steps, n_items)."""
        there: Mask = ~self.missing & self.is_found[:, None]
        return there

    def offset_to_nearest(
        self, x: npt.NDArray[np.float32], y: npt.NDArray[np.float32]
    ) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]:
        """Return dx and dy from a place to the nearest item, float32 (n_steps,) each.

        Args:
            x: The place in each step, float32 (n_steps,); NaN where there is none.
            y: The same, downwards.
        """
        # (n_steps, n_items, 2): from the place to each item.
        at = self.formation.centres[None] + self.shifts[:, None]
        offsets = at - np.stack([x, y], 1)[:, None]
        distance = np.hypot(offsets[..., 0], offsets[..., 1])
        distance = np.where(self.are_there & ~np.isnan(distance), distance, np.inf)
        nearest = distance.argmin(1)
        steps = np.arange(len(offsets))
        offset = OFFSET_PX * np.rint(offsets[steps, nearest] / OFFSET_PX)
        result = offset.astype(np.float32)
        result[~np.isfinite(distance[steps, nearest])] = np.nan
        return result[:, 0], result[:, 1]


class Follower:
    """Follows a formation through a game.

    Args:
        formation: The formation.
    """

    def __init__(self, formation: Formation) -> None:
        self._formation = formation
        self._shift: Shift = np.zeros(2, np.int64)
        self._missing_for = np.zeros(formation.n_items, np.int64)
        self._missing: list[Mask] = []
        self._shifts: list[Shift] = []
        self._is_found: list[bool] = []

    def look(self, screen: Screen) -> None:
        """Look at the screen after a step, uint8 (height, width)."""
        left = self._missing_for < LASTING_STEPS
        pixels, areas = self._formation.pixels, self._formation.areas
        if 2 * left.sum() < len(left):
            begin = np.zeros((1, 2), np.int64)
            if pixels.seen(screen, begin).mean() >= NEW_WAVE_SHARE or not left.any():
                # The next wave begins where the first did.
                left[:] = True
                self._shift = begin[0]
        shift = self._best_shift(screen, pixels.some(left[pixels.item]))
        n_seen = np.bincount(pixels.item, pixels.seen(screen, shift[None])[0], minlength=len(left))
        missing: Mask = n_seen < SEEN_SHARE * areas
        n_lost = int((missing & left).sum())
        is_found = n_lost <= max(MOST_AT_ONCE * left.sum(), 1)
        if is_found:
            self._shift = shift
            if self._missing:
                # What walks off the screen is not hit.
                missing = np.where(self._is_outside(screen), self._missing[-1], missing)
            self._missing_for = np.where(missing, self._missing_for + 1, 0)
        elif self._missing:
            missing = self._missing[-1]
        self._missing.append(missing)
        self._shifts.append(self._shift)
        self._is_found.append(is_found)

    def without_items(self, screen: Screen, background: Screen) -> Screen:
        """Return a screen on which the formation's items are as the background is.

        Args:
            screen: Of the step that was looked at last.
            background: Of the same shape.
        """
        if not self._is_found[-1]:
            return screen
        shown: Screen = screen.copy()
        x, y = self._shift.tolist()
        is_own = self._formation.has_colour[screen]
        for left, top, right, bottom in self._formation.boxes[~self._missing[-1]].tolist():
            rows = slice(max(top + y - MARGIN_PX, 0), max(bottom + y + MARGIN_PX, 0))
            columns = slice(max(left + x - MARGIN_PX, 0), max(right + x + MARGIN_PX, 0))
            own = is_own[rows, columns]
            shown[rows, columns][own] = background[rows, columns][own]
        return shown

    @property
    def followed(self) -> Followed:
        """What was seen so far."""
        n_steps = len(self._missing)
        return Followed(
            self._formation,
            np.array(self._missing, np.bool_).reshape(n_steps, self._formation.n_items),
            np.array(self._shifts, np.int64).reshape(n_steps, 2),
            np.array(self._is_found, np.bool_),
        )

    def _is_outside(self, screen: Screen) -> Mask:
        """Return which items are not wholly on the screen, bool (n_items,)."""
        left, top, right, bottom = self._formation.boxes.T
        x, y = self._shift.tolist()
        height, width = screen.shape
        outside: Mask = (left + x < 0) | (top + y < 0) | (right + x > width) | (bottom + y > height)
        return outside

    def _best_shift(self, screen: Screen, pixels: Pixels) -> Shift:
        """Return where the formation is: where most of some pixels are seen."""
        pixels = pixels.some(np.arange(0, len(pixels), -(-len(pixels) // MOST_COMPARED)))
        for most_down in (MOST_STEP_PX, MOST_JUMP_PX):
            across = np.arange(-MOST_STEP_PX, MOST_STEP_PX + 1)
            down = np.arange(-most_down, most_down + 1)
            steps = np.stack(np.meshgrid(across, down), -1).reshape(-1, 2)
            # Of equals the nearest, so that what stands still is not moved.
            steps = steps[np.argsort(np.abs(steps).sum(1), kind="stable")]
            n_seen = pixels.seen(screen, self._shift + steps).sum(1)
            if n_seen.max() >= FOUND_SHARE * len(pixels):
                break
        best: Shift = self._shift + steps[n_seen.argmax()]
        return best


def moving_formation(candidate: Formation, games: Sequence[Followed]) -> Formation | None:
    """Return the items of a set of alike things that move together; None if they do not.

    Args:
        candidate: The set.
        games: Where it is in varied games.
    """
    apart = [np.abs(game.shifts).max(1, initial=0) >= MIN_MOVED_PX for game in games]
    moved = [(game, int(far.argmax())) for game, far in zip(games, apart, strict=True) if far.any()]
    if len(moved) < MIN_GAMES_SHARE * len(games):
        return None
    if np.concatenate([game.is_found for game in games]).mean() < MIN_FOUND:
        return None
    # What stays behind when the others move, as a picture beside them or what is steered.
    stays = np.mean([game.missing[step] for game, step in moved], 0) > MOST_STAYING
    formation = candidate.without(stays)
    if formation.n_items < MIN_ITEMS:
        return None
    n_clearing = sum(bool(lasting(game.missing[:, ~stays]).any()) for game in games)
    return formation if n_clearing >= MIN_GAMES_SHARE * len(games) else None


def without_formation(
    background: Screen, beginning: Screen, formation: Formation, games: Sequence[Followed]
) -> Screen:
    """Return a background without the things of a formation that rarely moves away.

    Args:
        background: Most frequent colour of each pixel, uint8 (height, width).
        beginning: The same of the first steps of a game.
        formation: The formation.
        games: Where it is in varied games.
    """
    shifts = np.concatenate([game.shifts for game in games])
    (left, top), (right, bottom) = shifts.min(0), shifts.max(0)
    boxes = formation.boxes
    rows = slice(max(boxes[:, 1].min() + top - 2, 0), boxes[:, 3].max() + bottom + 2)
    columns = slice(max(boxes[:, 0].min() + left - 2, 0), boxes[:, 2].max() + right + 2)
    cleared: Screen = background.copy()
    # What stands still in the formation's colours stays.
    is_still = (background == beginning) & (formation.items == 0)
    part = cleared[rows, columns]
    own = formation.has_colour[part] & ~is_still[rows, columns]
    part[own] = np.bincount(part.ravel()).argmax()
    return cleared


def _lines(at: npt.NDArray[np.float64], length: float) -> npt.NDArray[np.int64]:
    """Return the number of the column or row that each item stands in, from 0, int64 (n_items,).

    Args:
        at: Where the items are.
        length: Size of an item: what is less than half of it apart is in one column.
    """
    order = np.argsort(at, kind="stable")
    begins = np.diff(at[order], prepend=at[order][:1]) > length / 2
    lines = np.empty(len(at), np.int64)
    lines[order] = np.cumsum(begins)
    return lines
