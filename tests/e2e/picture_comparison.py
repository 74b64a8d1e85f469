"""Compares pictures of pages by what a person would notice: panels that moved, came or went."""

from __future__ import annotations

import io
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt
from PIL import Image

BLOCK_PX = 12
"""Pictures are compared, and kept, as the mean luminance of squares of this side, so that a few
letters or antialiasing count for little."""

TOLERANCE = 14
"""Of 255: how much a block's luminance may differ."""

MAX_SHARE = 0.015
"""Share of the blocks that may differ by more: a name, a date or a figure."""

Blocks = npt.NDArray[np.uint8]


def blocks_of(png: bytes) -> Blocks:
    """Return the mean luminance of a picture's blocks, uint8 (rows, columns)."""
    picture = Image.open(io.BytesIO(png)).convert("L")
    width, height = (max(1, side // BLOCK_PX) for side in picture.size)
    whole = picture.crop((0, 0, width * BLOCK_PX, height * BLOCK_PX))
    return np.asarray(whole.reduce(BLOCK_PX))


def load(path: Path) -> Blocks:
    """Return kept blocks."""
    with Image.open(path) as picture:
        return np.asarray(picture.convert("L"))


def save(blocks: Blocks, path: Path) -> None:
    """Keep blocks as a small picture, in 64 shades."""
    path.parent.mkdir(parents=True, exist_ok=True)
    Image.fromarray(blocks // 4 * 4).save(path, optimize=True)


@dataclass(frozen=True)
class Difference:
    """How a picture differs from the one that is kept.

    Attributes:
        share: Of the blocks that differ, 0 to 1; those that only one picture has are among them.
        where: The blocks that differ, bool (rows, columns) of the larger picture.
    """

    share: float
    where: npt.NDArray[np.bool_]

    @property
    def is_noticeable(self) -> bool:
        """Whether more differs than words and figures."""
        return self.share > MAX_SHARE


def compare(kept: Blocks, found: Blocks) -> Difference:
    """Compare two pictures."""
    rows, columns = (max(a, b) for a, b in zip(kept.shape, found.shape, strict=True))
    where = np.ones((rows, columns), np.bool_)
    both = tuple(slice(min(a, b)) for a, b in zip(kept.shape, found.shape, strict=True))
    distance = np.abs(kept[both].astype(np.int16) - found[both].astype(np.int16))
    where[both] = distance > TOLERANCE
    return Difference(float(where.mean()), where)
