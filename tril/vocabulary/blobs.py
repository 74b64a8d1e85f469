"""Things on a screen: connected areas of one colour in front of the background.

The background is each pixel's most frequent colour in varied play. Objects of a 2600 are drawn in
one colour a line, so that an area of one colour is an object or a part of one (OCAtari, Delfosse et
al. 2023, finds the same objects by their colours, with rules for each game).
"""

from __future__ import annotations

import cv2
import numpy as np
import numpy.typing as npt

from tril.games.base import Screen

MIN_AREA_PX = 3
MIN_HEIGHT_PX = 2
"""Smaller areas are flicker, waves and edges."""
MIN_STRIPES = 3
"""Lines of a thing that has another colour in each."""
MAX_WIDTH = 0.5
"""Of the screen: what is wider is a part of the background that moves."""
MAX_BLOBS = 200
"""Of a screen. More is noise, as of a texture; the largest are kept."""

BLOB_DTYPE = np.dtype(
    [
        ("step", np.int32),
        ("colour", np.uint8),
        ("x", np.float32),
        ("y", np.float32),
        ("left", np.int16),
        ("top", np.int16),
        ("width", np.int16),
        ("height", np.int16),
        ("area", np.int32),
    ]
)
"""A blob: its step, its colour's number, the mean place of its pixels, its box and its area."""

Blobs = npt.NDArray[np.void]
"""Blobs, BLOB_DTYPE (n,)."""


def box_of(blobs: Blobs) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """Return the left column and the top row of each blob, int64 (n,) each."""
    return blobs["left"].astype(np.int64), blobs["top"].astype(np.int64)


class Background:
    """Counts the colours of every pixel; the most frequent one is the background.

    Args:
        shape: Height and width of the screen.
    """

    def __init__(self, shape: tuple[int, int]) -> None:
        self._counts = np.zeros((256, *shape), np.uint32)
        self._rows, self._columns = np.indices(shape)

    def add(self, colours: Screen) -> None:
        """Count a screen, uint8 (height, width)."""
        self._counts[colours, self._rows, self._columns] += 1

    def mode(self) -> Screen:
        """Return the most frequent colour of each pixel."""
        colours: Screen = self._counts.argmax(0).astype(np.uint8)
        return colours


def find_blobs(colours: Screen, background: Screen) -> Blobs:
    """Find the blobs of a screen.

    Args:
        colours: uint8 (height, width).
        background: The same of the background.
    """
    differs = colours != background
    flat = np.zeros(colours.shape, np.uint8)
    parts: list[Blobs] = []
    for value in np.unique(colours[differs]):
        mask = (colours == value) & differs
        rows, columns = (np.flatnonzero(mask.any(axis)) for axis in (1, 0))
        top, left = int(rows[0]), int(columns[0])
        # Only the area around them: most things are small, and the time is that of the pixels.
        mask = np.ascontiguousarray(mask[top : rows[-1] + 1, left : columns[-1] + 1]).view(np.uint8)
        labels, found = _areas(mask, left, top)
        found["colour"] = value
        is_flat = found["height"] < MIN_HEIGHT_PX
        fits = found["width"] <= MAX_WIDTH * colours.shape[1]
        parts.append(found[(found["area"] >= MIN_AREA_PX) & ~is_flat & fits])
        if is_flat.any():
            # Component 0 is what is not in the mask.
            here = flat[top : rows[-1] + 1, left : columns[-1] + 1]
            here |= np.concatenate([[False], is_flat])[labels].view(np.uint8)
    parts.append(_striped(colours, flat))
    blobs = np.concatenate([np.empty(0, BLOB_DTYPE), *parts])
    if len(blobs) > MAX_BLOBS:
        blobs = blobs[np.sort(np.argsort(-blobs["area"], kind="stable")[:MAX_BLOBS])]
    return blobs


def _areas(mask: Screen, left: int, top: int) -> tuple[npt.NDArray[np.int32], Blobs]:
    """Return the label of each pixel of a mask, and its connected areas without their colour.

    Args:
        mask: uint8 (height, width), 0 or 1.
        left: Column of the screen at which it begins.
        top: Row at which it begins.
    """
    _, found_labels, stats, centres = cv2.connectedComponentsWithStats(mask, connectivity=8)
    # Component 0 is what is not in the mask.
    stats, centres = stats[1:], centres[1:]
    found = np.zeros(len(stats), BLOB_DTYPE)
    found["x"], found["y"] = centres[:, 0] + left, centres[:, 1] + top
    found["left"] = stats[:, cv2.CC_STAT_LEFT] + left
    found["top"] = stats[:, cv2.CC_STAT_TOP] + top
    found["width"] = stats[:, cv2.CC_STAT_WIDTH]
    found["height"] = stats[:, cv2.CC_STAT_HEIGHT]
    found["area"] = stats[:, cv2.CC_STAT_AREA]
    labels: npt.NDArray[np.int32] = np.asarray(found_labels, np.int32)
    return labels, found


def _striped(colours: Screen, flat: Screen) -> Blobs:
    """Return things that have another colour in each line, which is that of most of their pixels.

    Args:
        colours: uint8 (height, width).
        flat: Where areas of one colour are a pixel high, 0 or 1.
    """
    if not flat.any():
        return np.empty(0, BLOB_DTYPE)
    labels, found = _areas(flat, 0, 0)
    kept = (found["height"] >= MIN_STRIPES) & (found["width"] <= MAX_WIDTH * colours.shape[1])
    for index in np.flatnonzero(kept):
        of_area = colours[labels == index + 1]
        found["colour"][index] = np.bincount(of_area).argmax()
    striped: Blobs = found[kept]
    return striped
