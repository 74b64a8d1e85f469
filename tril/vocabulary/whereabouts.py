"""Differences between two games in where things are at the same time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from tril.vocabulary.facts import Vocabulary
from tril.vocabulary.moments import Seconds

Columns = Sequence[npt.NDArray[np.int64]]


def place_columns(words: Vocabulary) -> Columns:
    """Return the columns of facts that say where things are, one array for each thing and axis.

    Only of what the player steers; of all kinds of things where nothing answers the buttons, or it
    has neither x nor y.
    """
    placed = [
        (group.subject, columns)
        for group, columns in zip(words.groups, words.columns, strict=True)
        if group.source == "thing" and group.aspect in ("x", "y") and len(group.subject) == 1
    ]
    steered = [columns for subject, columns in placed if subject == (words.player,)]
    return steered or [columns for _, columns in placed]


def share_elsewhere(one: Seconds, other: Seconds, columns: Columns) -> float:
    """Return the share of the time for which two games have things in different places.

    In each second that both have it is the total variation distance of the shares of that second
    for which a thing is in each bin, or not there; then the mean over things, axes and seconds.

    Args:
        one: A game, float16 (n_seconds, n_facts).
        other: The other game.
        columns: What `place_columns` returned, at least one array.

    Returns:
        From 0, the same places at the same times, to 1; 0 if one has no second.
    """
    both = min(len(one), len(other))
    if not both:
        return 0.0
    apart = np.empty((both, len(columns)))
    for index, bins in enumerate(columns):
        shares = [game[:both, bins].astype(np.float64) for game in (one, other)]
        absent = [1.0 - of_game.sum(1) for of_game in shares]
        differences = np.abs(shares[0] - shares[1]).sum(1) + np.abs(absent[0] - absent[1])
        apart[:, index] = differences / 2
    return float(apart.mean())
