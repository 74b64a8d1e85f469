"""Kinds of things: blobs of one colour and about one size, and where they are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tril.vocabulary.blobs import Blobs
from tril.vocabulary.trace import Trace

Array = npt.NDArray[np.float32]

MAX_KINDS = 20
MIN_SHARE = 0.03
"""Of the steps in which a kind of things is there; rarer ones are no kind."""
SIZES_PER_DOUBLING = 1.5
"""Sizes are of one kind within a factor of 2^(1/1.5), 1.6."""

MIN_EXPLAINED = 0.05
"""Share of a kind's motion that the buttons explain, from which on it is what the player steers."""
MOST_STEP_PX = 32
"""What moves further in one step is not the same thing, or began anew."""


@dataclass(frozen=True)
class Kind:
    """Things that look alike.

    Attributes:
        colour: Their colour's number.
        width: Bounds of the width in pixels.
        height: Bounds of the height.
    """

    colour: int
    width: tuple[int, int]
    height: tuple[int, int]

    def members(self, blobs: Blobs) -> npt.NDArray[np.bool_]:
        """Return which blobs are of this kind."""
        is_member: npt.NDArray[np.bool_] = (
            (blobs["colour"] == self.colour)
            & (blobs["width"] >= self.width[0])
            & (blobs["width"] <= self.width[1])
            & (blobs["height"] >= self.height[0])
            & (blobs["height"] <= self.height[1])
        )
        return is_member


@dataclass(frozen=True)
class Places:
    """Where the things of each kind are, float32 (n_steps, n_kinds); NaN where there are none.

    Attributes:
        count: How many there are.
        x: Mean of their centres.
        y: The same, downwards.
    """

    count: Array
    x: Array
    y: Array


def find_kinds(traces: Sequence[Trace]) -> tuple[Kind, ...]:
    """Find the kinds of things in varied play, the most frequent first."""
    n_steps = sum(played.n_steps for played in traces)
    first = np.cumsum([0, *(played.n_steps for played in traces)])
    blobs = np.concatenate([played.blobs for played in traces])
    # The step among those of all games.
    moment = np.concatenate(
        [played.blobs["step"] + begin for played, begin in zip(traces, first[:-1], strict=True)]
    )
    size = np.stack([blobs["width"], blobs["height"]], 1).astype(np.float64)
    size_class = np.round(np.log2(size) * SIZES_PER_DOUBLING)
    looks = np.column_stack([blobs["colour"], size_class])
    _, kind_of = np.unique(looks, axis=0, return_inverse=True)
    kind_of = kind_of.ravel()
    found: list[tuple[float, Kind]] = []
    for index in np.unique(kind_of):
        mine = kind_of == index
        share = len(np.unique(moment[mine])) / n_steps
        if share >= MIN_SHARE:
            part = blobs[mine]
            kind = Kind(
                int(part["colour"][0]),
                (int(part["width"].min()), int(part["width"].max())),
                (int(part["height"].min()), int(part["height"].max())),
            )
            found.append((share, kind))
    found.sort(key=lambda pair: -pair[0])
    return tuple(kind for _, kind in found[:MAX_KINDS])


def places(played: Trace, kinds: Sequence[Kind]) -> Places:
    """Return where the things of each kind are in each step."""
    n_steps, blobs = played.n_steps, played.blobs
    count, x, y = (np.zeros((n_steps, len(kinds)), np.float32) for _ in range(3))
    for index, kind in enumerate(kinds):
        mine = blobs[kind.members(blobs)]
        count[:, index] = np.bincount(mine["step"], minlength=n_steps)
        with np.errstate(invalid="ignore", divide="ignore"):
            x[:, index] = np.bincount(mine["step"], mine["x"], n_steps) / count[:, index]
            y[:, index] = np.bincount(mine["step"], mine["y"], n_steps) / count[:, index]
    return Places(count, x, y)


def offset_to_nearest(played: Trace, kind: Kind, x: Array, y: Array) -> tuple[Array, Array]:
    """Return dx and dy from a place to the nearest thing of a kind, float32 (n_steps,) each.

    Args:
        played: The game.
        kind: The kind of things.
        x: The place in each step, float32 (n_steps,); NaN where there is none.
        y: The same, downwards.
    """
    mine = played.blobs[kind.members(played.blobs)]
    step = mine["step"]
    dx, dy = mine["x"] - x[step], mine["y"] - y[step]
    distance = np.nan_to_num(np.hypot(dx, dy), nan=np.inf)
    order = np.lexsort((distance, step))
    steps, first = np.unique(step[order], return_index=True)
    result = np.full((2, played.n_steps), np.nan, np.float32)
    result[0, steps], result[1, steps] = dx[order][first], dy[order][first]
    return result[0], result[1]


def find_player(traces: Sequence[Trace], at: Sequence[Places]) -> int | None:
    """Return the index of the kind that answers the buttons; None if none does.

    Of each kind that is alone, it is asked how much of the variance of its motion from step to step
    is between the buttons held.
    """
    # Of the step in which it moved, and of the one before: some games answer late.
    answers = []
    for lag in (slice(1, None), slice(None, -1)):
        keys = np.concatenate([played.held[lag] for played in traces])
        answers.append(np.unique(keys, return_inverse=True)[1])
    best, player = MIN_EXPLAINED, None
    for kind in range(at[0].count.shape[1]):
        alone = np.concatenate([found.count[1:, kind] for found in at]) == 1
        for axis in ("x", "y"):
            moved = np.concatenate([np.diff(getattr(found, axis)[:, kind]) for found in at])
            usable = alone & ~np.isnan(moved) & (np.abs(moved) < MOST_STEP_PX)
            motion = moved[usable]
            if usable.sum() < 100 or motion.var() < 0.01:
                continue
            for held in answers:
                keys = held[usable]
                means = np.bincount(keys, motion) / np.maximum(np.bincount(keys), 1)
                explained = means[keys].var() / motion.var() * usable.mean()
                if explained > best:
                    best, player = float(explained), kind
    return player
