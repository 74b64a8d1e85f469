"""Which of an imitator's games a person had best rank: few, and unlike each other."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from tril.analysis.variety import N_PROPOSED, Traits, pick_evenly
from tril.games.base import Cell
from tril.games.behaviours import Behaviour, score
from tril.store.models import EvaluationRow
from tril.store.training import evaluations


def proposed_games(
    games: Sequence[EvaluationRow], kept_starts: Collection[int], n_targets: int | None
) -> list[EvaluationRow]:
    """Return the games of the imitator that a person had best rank: few, and unlike each other.

    They are greedy and sticky ones, which show what the imitator does at its best and where it
    doesn't recover, spread evenly over action selections, targets and strays, or over the number of
    items taken for a behaviour without target cells. Where all of them are perfect, which teaches
    nothing, sampled ones that are not are added. A later run that learns from a game takes its
    start for seen, so some starts are kept for its headline figures.

    Args:
        games: A run's evaluation games, loaded with their recordings.
        kept_starts: Starts to leave out, unless there are games from no others.
        n_targets: Target cells of the behaviour, None without any.

    Returns:
        At most N_PROPOSED, by start number; the same ones for the same games.
    """
    imitator_games = [g for g in games if g.policy == "imitator"]
    starts = {g.start_number for g in imitator_games if g.action_selection != "sampled"}
    unseen_games = [
        g for g in imitator_games if g.start_number in (starts - set(kept_starts) or starts)
    ]
    candidates = [g for g in unseen_games if g.action_selection != "sampled"]
    if all(evaluations.figures_of(g, n_targets).perfect for g in candidates):
        candidates = [
            g
            for g in unseen_games
            if g.action_selection != "sampled" or not evaluations.figures_of(g, n_targets).perfect
        ]
    traits = [
        (g.action_selection, len(g.recording.taken) if g.targets is None else g.targets, g.strays)
        for g in candidates
    ]
    picked = pick_evenly(traits, N_PROPOSED, np.random.default_rng(0))
    return [candidates[place] for place in sorted(picked)]


def pick_training_games(
    behaviour: Behaviour, games: Sequence[tuple[Sequence[Cell], bool]]
) -> Sequence[int]:
    """Pick the games to keep: few, and unlike each other.

    Args:
        behaviour: Behaviour to teach.
        games: Of each, the items taken, in order of time, and whether the player died.

    Returns:
        At most N_PROPOSED indices, in order; the same ones for the same games.
    """
    traits = [_traits(behaviour, cells, died) for cells, died in games]
    return sorted(pick_evenly(traits, N_PROPOSED, np.random.default_rng(0)))


def _traits(behaviour: Behaviour, cells: Sequence[Cell], died: bool) -> Traits:
    outcome = score(behaviour, tuple(cells))
    targets, strays = (len(cells), 0) if outcome is None else (outcome.targets, outcome.strays)
    return targets, strays, died
