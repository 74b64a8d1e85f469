"""How far apart two games are in where things are and when."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from tril.vocabulary.facts import Vocabulary
from tril.vocabulary.moments import Seconds

Columns = Sequence[npt.NDArray[np.int64]]


def place_columns(words: Vocabulary) -> Columns:
    """Return the columns of facts that say where things are, one array for each thing and axis.

    The thing is what the player steers. Where nothing answers the buttons, or it stays in place,
    all kinds of things count.
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

    In each second it is the total variation distance of the shares of that second for which a thing
    is in each bin, or not there; then the mean over things, axes and seconds. Seconds that only the
    longer game has count as different.

    Args:
        one: A game, float16 (n_seconds, n_facts).
        other: The other game.
        columns: What `place_columns` returned, at least one array.

    Returns:
        From 0, the same places at the same times, to 1.
    """
    longest = max(len(one), len(other))
    if not longest:
        return 0.0
    apart = np.ones((longest, len(columns)))
    both = min(len(one), len(other))
    for index, bins in enumerate(columns):
        shares = [game[:both, bins].astype(np.float64) for game in (one, other)]
        absent = [1.0 - of_game.sum(1) for of_game in shares]
        differences = np.abs(shares[0] - shares[1]).sum(1) + np.abs(absent[0] - absent[1])
        apart[:both, index] = differences / 2
    return float(apart.mean())
