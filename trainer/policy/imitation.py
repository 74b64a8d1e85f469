"""What imitators are trained from and judged by, however they are trained."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from copy import deepcopy
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from torch import Tensor

from trainer.nn.precision import Precision
from trainer.policy.evaluation import EvaluatedGame, play
from trainer.policy.networks import Policy, ScreenPolicy, pretrained_policy
from trainer.policy.reward_shaping import RewardShaping
from trainer.progress import CallbackProgress
from trainer.reward.model import RewardModel
from tril.games.base import Game, Opening, Start, Taken, spread_starts
from tril.games.behaviours import Behaviour, score
from tril.recipes import Recipe
from tril.recording import Recording

_SNAPSHOT_OPENINGS = 1_000_037
"""Seed of the openings of the games that judge snapshots and mixtures."""

MIXTURES = (0.0, 0.25, 0.5, 0.75, 1.0)
"""Shares of the start policy's weights in the mixtures that are tried."""

_MIXTURE_GAMES = 24
"""Games that judge each mixture, at most."""


@dataclass(frozen=True)
class ImitationTask:
    """What an imitator is trained from.

    Attributes:
        game: The game.
        model: The learned reward.
        recordings: The ranked demonstrations.
        tiers: Indices into them, best tier first.
        recipe: Recipe of the training.
        steps: Training steps, rounded up to whole rollouts.
        training_seed: Seeds all random numbers.
        behaviour: For the curves of hits; PPO never looks at it.
        perfect: The perfect demonstrations; episodes may begin in them as in the best ranked ones.
        start_policy: File of the policy that a warm start begins with: the run's clone, or an
            earlier run's imitator.
        mixes_start: Whether it may be mixed with the policy that ships, see
            PolicyRecipe.mixed_start; an earlier run's imitator is continued as it is.
    """

    game: Game
    model: RewardModel
    recordings: Sequence[Recording]
    tiers: Sequence[Sequence[int]]
    recipe: Recipe
    steps: int
    training_seed: int
    behaviour: Behaviour | None = None
    perfect: Sequence[Recording] = ()
    start_policy: Path | None = None
    mixes_start: bool = True


@dataclass(frozen=True)
class SnapshotScore:
    """How good the policy was at one point of its training.

    Attributes:
        steps: Training steps until then.
        predicted_return: Mean shaped return of games from training starts. The shape is the one
            that the policy is trained on: by the raw R, which is unbounded and has an arbitrary
            offset, dying early may look best. GAIL's is by its discriminator at that point.
    """

    steps: int
    predicted_return: float


@dataclass(frozen=True)
class Snapshot:
    """The policy at one point of its training, and the games that it was judged by.

    Attributes:
        policy: The policy, which learns on after this.
        steps: Training steps until then.
        games: Greedy games from training starts, see evaluate_snapshot.
    """

    policy: ScreenPolicy
    steps: int
    games: Sequence[EvaluatedGame]


@dataclass(frozen=True)
class ImitatorResult:
    """The outcome of a training.

    Attributes:
        snapshots: The policies that were compared, in the order of their steps.
        best_steps: Training steps of the best of them, which was saved.
        precision: The precision it learned in.
    """

    snapshots: tuple[SnapshotScore, ...]
    best_steps: int
    precision: Precision


def best_snapshot(snapshots: Sequence[SnapshotScore]) -> SnapshotScore:
    """Return the snapshot of the highest return; of equal ones the latest."""
    return max(snapshots, key=lambda snapshot: (snapshot.predicted_return, snapshot.steps))


def evaluate_snapshot(
    game: Game,
    policy: Policy,
    shaping: RewardShaping,
    recipe: Recipe,
    on_step: Callable[[], None],
) -> tuple[float, list[EvaluatedGame]]:
    """Return the mean shaped return of a policy's greedy games from training starts, and the games.

    Actions stick and openings come first as in training.

    Args:
        game: The game.
        policy: The policy.
        shaping: The reward.
        recipe: Recipe with the number of games and their end.
        on_step: Called after every step of the games; what it raises ends them.
    """
    games = play(
        game,
        policy,
        snapshot_starts(game, recipe),
        "greedy",
        sticky_action_probability=recipe.policy.sticky_action_probability,
        model=shaping.model,
        end_rule=recipe.ending,
        progress=CallbackProgress(on_step),
    )
    return mean_return(games, shaping), games


def best_mixture(
    task: ImitationTask,
    start: ScreenPolicy,
    shaping: RewardShaping,
    on_step: Callable[[], None],
) -> ScreenPolicy:
    """Return the best mixture of a start policy with the policy that ships with Tril.

    The clone has learned from that policy with the same convolutions, so that weights between
    theirs act between theirs: some do what the demonstrations do and have not forgotten to
    survive (Wortsman et al. 2022, Robust fine-tuning of zero-shot models, section 3). The best
    mixture has the highest mean shaped return over sampled games from training starts.

    Args:
        task: What the imitator is trained from.
        start: The policy that a warm start begins with; it stays as it is.
        shaping: The reward.
        on_step: Called after every step of the games; what it raises ends them.
    """
    shipped = pretrained_policy(0.0).state_dict()
    learned = {name: weight.cpu() for name, weight in start.state_dict().items()}
    mixed = deepcopy(start).cpu()
    starts = _spread_starts(task.game, task.recipe, _MIXTURE_GAMES)
    best: tuple[float, dict[str, Tensor]] | None = None
    for share in MIXTURES:
        weights = {
            name: (1 - share) * weight + share * learned[name] for name, weight in shipped.items()
        }
        mixed.load_state_dict(weights)
        games = play(
            task.game,
            Policy(mixed),
            starts,
            "sampled",
            sticky_action_probability=task.recipe.policy.sticky_action_probability,
            model=shaping.model,
            end_rule=task.recipe.ending,
            progress=CallbackProgress(on_step),
        )
        returned = mean_return(games, shaping)
        if best is None or returned > best[0]:
            best = returned, weights
    assert best is not None
    mixed.load_state_dict(best[1])
    return mixed


def mean_return(games: Sequence[EvaluatedGame], shaping: RewardShaping) -> float:
    """Return the mean shaped return of games whose rewards are known."""
    returns = [
        shaping.shaped_return(game.rewards, game.died) for game in games if game.rewards is not None
    ]
    return float(np.mean(returns))


def snapshot_starts(game: Game, recipe: Recipe) -> list[Start | Opening]:
    """Return the starts that snapshots are judged from, spread over all training starts."""
    return _spread_starts(game, recipe, recipe.policy.snapshot_episodes)


def _spread_starts(game: Game, recipe: Recipe, count: int) -> list[Start | Opening]:
    """Return at most so many training starts, a share of them with openings as in training."""
    starts = spread_starts(training_starts(game, recipe), count)
    n_openings = round(recipe.policy.opening_share * len(starts))
    rng = np.random.default_rng(_SNAPSHOT_OPENINGS)
    return [game.starts.draw_opening(start, rng) for start in starts[:n_openings]] + [
        *starts[n_openings:]
    ]


def training_starts(game: Game, recipe: Recipe) -> tuple[Start, ...]:
    """Return the starts that training games begin from."""
    starts = tuple(game.starts.evaluation(number) for number in recipe.policy.own_starts)
    return starts or tuple(game.starts.training)


def episode_metrics(
    behaviour: Behaviour | None, n_steps: int, taken: Sequence[Taken], died: bool
) -> dict[str, float]:
    """Return the points of the curves for an episode; targets if the behaviour has target cells."""
    values = {"episode_steps": float(n_steps), "death_rate": float(died)}
    cells = tuple(item.cell for item in taken)
    scored = score(behaviour, cells) if behaviour else None
    if scored is not None:
        values |= {"hits": float(scored.targets), "strays": float(scored.strays)}
    return values
