"""Attention maps by larger patches, in all four screens at once.

A patch of 3x3 pixels rarely hides a whole thing of a game, 8 to 16 pixels wide on the console's
screen, and never one that the other three screens still show. Where a network reads several pixels
together, hiding them one by one changes little.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from trainer.explain.subject import Subject
from trainer.progress import NullProgress, Progress
from tril.play.observation import Observation

SIDE = 9
"""Side of the patches that the page offers, in pixels: a little larger than most things."""
STRIDE = 3

_BATCH = 128


def patch_map(
    subject: Subject,
    observation: Observation,
    side: int = SIDE,
    stride: int = STRIDE,
    progress: Progress | None = None,
    background: int = 0,
) -> npt.NDArray[np.float32]:
    """Return a map of the changes where a patch of all four screens becomes background.

    Args:
        subject: Subject to explain.
        observation: uint8 (4, 84, 84).
        side: Side of a patch, in pixels.
        stride: Pixels from one patch to the next.
        progress: Counts patches.
        background: Gray of the screen's background, 0 to 255.

    Returns:
        float32 (84, 84), non-negative: the mean absolute change over the patches that cover a
        pixel.
    """
    progress = progress or NullProgress()
    size = observation.shape[1]
    places = range(0, size - side + 1, stride)
    corners = [
        (row, column)
        for row in places
        for column in places
        if (observation[:, row : row + side, column : column + side] != background).any()
    ]
    plain = subject.score(observation[None])[0]
    total = np.zeros((size, size), np.float64)
    for begin in range(0, len(corners), _BATCH):
        part = corners[begin : begin + _BATCH]
        occluded = np.repeat(observation[None], len(part), axis=0)
        for target, (row, column) in zip(occluded, part, strict=True):
            target[:, row : row + side, column : column + side] = background
        changes = np.abs(subject.score(occluded) - plain)
        for change, (row, column) in zip(changes, part, strict=True):
            total[row : row + side, column : column + side] += change
        progress.advance(begin + len(part), len(corners))
    covering = np.zeros((size, size), np.int64)
    for row in places:
        for column in places:
            covering[row : row + side, column : column + side] += 1
    return (total / np.maximum(covering, 1)).astype(np.float32)
