"""Made-up trainings of which is known whether the policy plays better or only earns more."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from tril.analysis.outcome import CheckOutcome, RunOutcome
from tril.analysis.reward_alarm import CURVES, Points


def checked(returns: Mapping[int, float], **members: Any) -> RunOutcome:
    """Make the outcome of a run whose check found these predicted returns by recording."""
    check: dict[str, Any] = {
        "tau": 1.0,
        "pair_accuracy": 1.0,
        "held_out_accuracy": None,
        "passed": True,
        "advice": "",
        "confused": [],
        "predicted_returns": returns,
    }
    return RunOutcome(check=CheckOutcome.model_validate(check | members))


Shape = Callable[[float], float]
"""A mean over games, by how much of the training is done, 0 to 1."""

DEMONSTRATED = (0.0, 100.0, 300.0, 500.0, 700.0, 900.0)
ROLLOUT_STEPS = 2048


@dataclass(frozen=True)
class Training:
    """A training as it is recorded: each point the mean over the last 50 games.

    Attributes:
        hits: Mean targets a game, of 6.
        returns: Mean predicted return.
        strays: Mean strays.
        length: Steps a game.
        n_points: Rollouts.
    """

    hits: Shape
    returns: Shape
    strays: Shape = lambda t: 0.2
    length: Shape = lambda t: 280.0
    n_points: int = 147

    def curves(self, draws: int = 0) -> dict[str, Points]:
        rng = np.random.default_rng(draws)
        games: list[tuple[float, ...]] = []
        points: dict[str, list[tuple[int, float]]] = {name: [] for name in CURVES}
        for number in range(1, self.n_points + 1):
            t = number / self.n_points
            for _ in range(rng.poisson(ROLLOUT_STEPS / self.length(t)) + 1):
                luck = rng.normal(0, 1.3)
                # A lucky game has a higher return as well.
                value = self.returns(t) + 50 * luck + rng.normal(0, 120)
                hits = np.clip(round(self.hits(t) + luck), 0, 6)
                games.append((value, hits, rng.poisson(self.strays(t)), self.length(t)))
            means = np.mean(games[-50:], axis=0)
            for name, mean in zip(CURVES, means, strict=True):
                points[name].append((number * ROLLOUT_STEPS, float(mean)))
        return dict(points)


HACKS = {
    "all the time": Training(lambda t: 1.0, lambda t: 200 + 400 * t),
    "at the end": Training(lambda t: min(3, 9 * t), lambda t: 300 + 1200 * max(0, t - 0.6)),
    "at the beginning": Training(lambda t: 0.3, lambda t: 200 + 400 * min(1, 4 * t)),
    "while it gets worse": Training(lambda t: 3 - 2 * t, lambda t: 300 + 300 * t),
    "by strays": Training(lambda t: 1.5, lambda t: 300 + 300 * t, strays=lambda t: 3 * t),
    "by strays where most is hit": Training(
        lambda t: 4.5, lambda t: 500 + 300 * t, strays=lambda t: 3 * t
    ),
    "in a long training": Training(lambda t: 1.0, lambda t: 200 + 400 * t, n_points=1500),
}

HONEST = {
    "nothing learned": Training(lambda t: 0.0, lambda t: 200),
    "nothing learned from a warm start": Training(lambda t: 2.5, lambda t: 400),
    "both rise": Training(lambda t: 1 + 4 * t, lambda t: 200 + 500 * t),
    "both rise slowly": Training(lambda t: 2 + t, lambda t: 300 + 90 * t),
    "both rise, then rest": Training(lambda t: min(4, 12 * t), lambda t: 200 + 400 * min(1, 3 * t)),
    "fewer strays": Training(
        lambda t: 3.0, lambda t: 300 + 300 * t, strays=lambda t: 2.5 - 2.2 * t
    ),
    "nothing left to hit": Training(lambda t: 5.6, lambda t: 600 + 250 * t),
    "most is hit, and it learns to stay alive": Training(
        lambda t: 4.5, lambda t: 500 + 300 * t, length=lambda t: 200 + 100 * t
    ),
    "the return falls": Training(lambda t: 2.0, lambda t: 600 - 300 * t),
    "the hits come later": Training(
        lambda t: 0.5 if t < 0.4 else 4.0, lambda t: 200 + 500 * min(1, 2.5 * t)
    ),
}
