"""Screens that stand for several."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from tril.games.base import Screen, ScreenSpec


def joined(frames: list[Screen], screen: ScreenSpec) -> Screen:
    """Return one screen for successive ones: the pixel-wise brightest, or the last where RGB.

    A console draws some objects in every other frame only; a single one shows or hides them by
    chance.
    """
    gray = screen.grayscale
    return frames[-1] if gray is None else brightest(np.array(frames), gray)


def brightest(frames: npt.NDArray[np.uint8], grayscale: npt.NDArray[np.uint8]) -> Screen:
    """Return the pixel-wise brightest of screens of palette values.

    Args:
        frames: The screens, uint8 (n, height, width).
        grayscale: Grays by palette value, uint8 (256,).
    """
    at = grayscale[frames].argmax(axis=0)[None]
    pixels: Screen = np.take_along_axis(frames, at, axis=0)[0]
    return pixels
