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
        ("width", np.int16),
        ("height", np.int16),
        ("area", np.int32),
    ]
)
"""A blob: its step, its colour's number, its centre, size and area in pixels."""

Blobs = npt.NDArray[np.void]
"""Blobs, BLOB_DTYPE (n,)."""


def box_of(blobs: Blobs) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """Return the left column and the top row of each blob, int64 (n,) each."""
    left = np.rint(blobs["x"] - (blobs["width"] - 1) / 2).astype(np.int64)
    top = np.rint(blobs["y"] - (blobs["height"] - 1) / 2).astype(np.int64)
    return left, top


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
    parts: list[Blobs] = []
    for value in np.unique(colours[differs]):
        mask = (colours == value) & differs
        rows, columns = (np.flatnonzero(mask.any(axis)) for axis in (1, 0))
        top, left = int(rows[0]), int(columns[0])
        # Only the area around them: most things are small, and the time is that of the pixels.
        mask = np.ascontiguousarray(mask[top : rows[-1] + 1, left : columns[-1] + 1]).view(np.uint8)
        _, _, stats, centres = cv2.connectedComponentsWithStats(mask, connectivity=8)
        # Component 0 is what is not in the mask.
        stats, centres = stats[1:], centres[1:]
        kept = (
            (stats[:, cv2.CC_STAT_AREA] >= MIN_AREA_PX)
            & (stats[:, cv2.CC_STAT_HEIGHT] >= MIN_HEIGHT_PX)
            & (stats[:, cv2.CC_STAT_WIDTH] <= MAX_WIDTH * colours.shape[1])
        )
        part = np.zeros(int(kept.sum()), BLOB_DTYPE)
        part["colour"] = value
        part["x"], part["y"] = centres[kept, 0] + left, centres[kept, 1] + top
        part["width"] = stats[kept, cv2.CC_STAT_WIDTH]
        part["height"] = stats[kept, cv2.CC_STAT_HEIGHT]
        part["area"] = stats[kept, cv2.CC_STAT_AREA]
        parts.append(part)
    blobs = np.concatenate([np.empty(0, BLOB_DTYPE), *parts])
    if len(blobs) > MAX_BLOBS:
        blobs = blobs[np.sort(np.argsort(-blobs["area"], kind="stable")[:MAX_BLOBS])]
    return blobs
