"""Learning a reward model from ranked trajectories (T-REX, Brown et al. 2019, section 4).

The loss is the thesis's and T-REX's: of two snippets the better one is to have the higher sum of
R, by cross entropy on the two sums (Bradley-Terry). Two ways to draw and score the snippets are
described at `paper_losses` and `fast_losses`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor
from torch.nn import functional as F

from trainer.chance import drawn_from
from trainer.progress import Part, Progress
from trainer.reward.model import SCORING_BATCH, RewardModel, RewardNetwork
from trainer.reward.snippets import SnippetPairs, SnippetRule, draw_snippets, preference_pairs
from tril.errors import Invalid
from tril.ranking import Pair
from tril.recipes import RewardRecipe
from tril.recording import Trajectory

END_STEPS = 25
"""Steps at a game's end by which its final level is measured."""

_REPORTS = 200
"""Points of a curve that a training adds at most."""


def train_reward(
    trajectories: Sequence[Trajectory],
    tiers: Sequence[Sequence[int]],
    recipe: RewardRecipe,
    training_seed: int,
    progress: Progress,
) -> RewardModel:
    """Learn a reward model from ranked trajectories.

    Args:
        trajectories: The demonstrations.
        tiers: Indices into ``trajectories``, best tier first; tied ones get no strict label.
        recipe: How it is learned.
        training_seed: Feeds every random choice: the same one gives the same model, with the same
            number of threads.
        progress: Told of loss and accuracy, as updates of all members of the ensemble.

    Raises:
        Invalid: There are fewer than two tiers.
        RunCancelled: Raised by ``progress``.
    """
    networks = []
    for member in range(recipe.ensemble):
        part = Part(
            progress,
            member / recipe.ensemble,
            (member + 1) / recipe.ensemble,
            units=recipe.ensemble * recipe.updates,
        )
        rng = np.random.default_rng([training_seed, member])
        networks.append(train_network(trajectories, tiers, recipe, recipe.updates, rng, part))
    return calibrate(networks, trajectories, tiers, standardise=recipe.method == "fast")


def train_network(
    trajectories: Sequence[Trajectory],
    tiers: Sequence[Sequence[int]],
    recipe: RewardRecipe,
    updates: int,
    rng: np.random.Generator,
    progress: Progress,
) -> RewardNetwork:
    """Learn one network with this many updates; the arguments are those of train_reward."""
    pairs = preference_pairs(tiers)
    network = new_network(rng)
    optimizer = torch.optim.Adam(
        network.parameters(), lr=recipe.learning_rate, weight_decay=recipe.weight_decay
    )
    losses = paper_losses if recipe.method == "paper" else fast_losses
    every = max(1, updates // _REPORTS)
    recent: list[tuple[float, float]] = []
    for update, logits in enumerate(losses(network, trajectories, pairs, recipe, updates, rng), 1):
        # Cross entropy between two sums is softplus of their difference.
        loss = F.softplus(-logits).mean()
        optimizer.zero_grad()
        loss.backward()  # type: ignore[no-untyped-call]
        optimizer.step()
        recent.append((loss.item(), (logits > 0).float().mean().item()))
        values = None
        if update % every == 0 or update == updates:
            means = np.mean(recent, axis=0)
            values = {"loss": float(means[0]), "accuracy": float(means[1])}
            recent.clear()
        progress.advance(update, updates, values)
    return network


def paper_losses(
    network: RewardNetwork,
    trajectories: Sequence[Trajectory],
    pairs: Sequence[Pair],
    recipe: RewardRecipe,
    updates: int,
    rng: np.random.Generator,
) -> Iterator[Tensor]:
    """Yield, for every update, the sum of the better snippet minus that of the worse, float32 (P,).

    As in T-REX: snippet pairs are drawn once and gone through in several passes, each update
    scores its own few pairs, every ``observation_stride``-th observation of a snippet counts, and
    the logit is the sum (not the mean) of R.

    Differences from T-REX: snippets are cut at the shorter game of each pair instead of at the
    shortest of all, each pass takes the pairs in a new order, and games of equal rank form no
    pair, where T-REX gives them a strict label.
    """
    rule = SnippetRule(recipe.snippet_min_steps, recipe.snippet_max_steps, recipe.aligned)
    sizes = [len(trajectory.observations) for trajectory in trajectories]
    drawn = draw_snippets(pairs, sizes, rule, recipe.snippet_pairs or updates, rng)
    order = np.empty(0, np.int64)
    for _ in range(updates):
        while len(order) < recipe.pairs_per_update:
            order = np.concatenate([order, rng.permutation(len(drawn))])
        chosen, order = np.split(order, [recipe.pairs_per_update])
        snippets = [_pair_observations(trajectories, drawn, i, recipe) for i in chosen.tolist()]
        values = network(torch.from_numpy(np.concatenate(snippets)))
        halves = [half for pair in snippets for half in [len(pair) // 2] * 2]
        sums = torch.stack([part.sum() for part in values.split_with_sizes(halves)])
        yield sums[0::2] - sums[1::2]


def _pair_observations(
    trajectories: Sequence[Trajectory], drawn: SnippetPairs, index: int, recipe: RewardRecipe
) -> npt.NDArray[np.uint8]:
    """Return the better snippet, then the worse one, uint8 (2 L, 4, 84, 84)."""
    parts = []
    for which, starts in (
        (drawn.better, drawn.better_start),
        (drawn.worse, drawn.worse_start),
    ):
        begin = int(starts[index])
        taken = slice(begin, begin + int(drawn.length[index]), recipe.observation_stride)
        parts.append(trajectories[int(which[index])].observations[taken])
    return np.concatenate(parts)


def fast_losses(
    network: RewardNetwork,
    trajectories: Sequence[Trajectory],
    pairs: Sequence[Pair],
    recipe: RewardRecipe,
    updates: int,
    rng: np.random.Generator,
) -> Iterator[Tensor]:
    """Yield, for every update, the sum of the better snippet minus that of the worse, float32 (P,).

    Every update scores each demonstration once, at every ``observation_stride``-th observation
    from an offset drawn anew, and takes the sums of many snippets from the prefix sums of those
    scores. Neighbouring observations share three of four screens, so that the stride costs little
    of what there is to learn and saves most of the time.
    """
    stride = recipe.observation_stride
    rule = SnippetRule(recipe.snippet_min_steps, recipe.snippet_max_steps, recipe.aligned)
    frames = [torch.from_numpy(trajectory.observations) for trajectory in trajectories]
    for _ in range(updates):
        offset = int(rng.integers(stride))
        # A game that is shorter than the stride counts with its last observation.
        taken = [one[min(offset, len(one) - 1) :: stride] for one in frames]
        sizes = [len(one) for one in taken]
        inputs = torch.cat(taken)
        chunks = range(0, len(inputs), SCORING_BATCH)
        values = torch.cat([network(inputs[at : at + SCORING_BATCH]) for at in chunks])
        table = torch.zeros(len(taken), max(sizes) + 1)
        for row, part in enumerate(values.split_with_sizes(sizes)):
            table[row, 1 : len(part) + 1] = part.cumsum(0)
        drawn = draw_snippets(pairs, sizes, rule.every(stride), recipe.pairs_per_update, rng)
        better = _sums(table, drawn.better, drawn.better_start, drawn.length)
        yield better - _sums(table, drawn.worse, drawn.worse_start, drawn.length)


def _sums(
    table: Tensor,
    which: npt.NDArray[np.int64],
    start: npt.NDArray[np.int64],
    length: npt.NDArray[np.int64],
) -> Tensor:
    rows = torch.from_numpy(which)
    return table[rows, torch.from_numpy(start + length)] - table[rows, torch.from_numpy(start)]


def calibrate(
    networks: Sequence[RewardNetwork],
    trajectories: Sequence[Trajectory],
    tiers: Sequence[Sequence[int]],
    *,
    standardise: bool,
) -> RewardModel:
    """Make a reward model of trained networks.

    Args:
        networks: The members of the ensemble.
        trajectories: The demonstrations they were trained on.
        tiers: Indices into ``trajectories``, best tier first.
        standardise: Whether each network's output is scaled to a standard deviation of 1 over all
            states of the demonstrations and shifted so that the tier of lowest mean R has a mean
            of 0. Preferences leave both open. With this choice a game that ends early is no
            better than the worst demonstration going on.
    """
    ranked = [index for tier in tiers for index in tier]
    members = tuple(networks)
    raw = RewardModel(members, (0.0,) * len(members), (1.0,) * len(members))
    if standardise:
        outputs = [_member_scores(member, trajectories, ranked) for member in members]
        scales = [float(np.concatenate(list(out.values())).std()) for out in outputs]
        if min(scales) < 1e-6:
            raise Invalid(
                "The reward model gives all states the same value: nothing was learned from this"
                " ranking. Use a higher learning rate, or other demonstrations."
            )
        lowest = [min(_mean(out, tier) for tier in tiers) for out in outputs]
        raw = replace(raw, offsets=tuple(lowest), scales=tuple(scales))
    scores = {index: raw.score(trajectories[index].observations) for index in ranked}
    zero = min(_mean(scores, tier) for tier in tiers)
    one = float(np.mean([scores[index][-END_STEPS:].mean() for index in tiers[0]]))
    if not one > zero:
        # Nothing was learned; the check of the ranking says so. Any scale keeps R usable.
        one = zero + 1.0
    return replace(raw, zero=zero, one=one)


def new_network(rng: np.random.Generator) -> RewardNetwork:
    """Make a network with PyTorch's own initialisation, drawn from this generator alone."""
    return drawn_from(rng, RewardNetwork)


def _member_scores(
    member: RewardNetwork, trajectories: Sequence[Trajectory], ranked: Sequence[int]
) -> dict[int, npt.NDArray[np.float32]]:
    one = RewardModel((member,), (0.0,), (1.0,))
    return {index: one.score(trajectories[index].observations) for index in ranked}


def _mean(scores: dict[int, npt.NDArray[np.float32]], tier: Sequence[int]) -> float:
    return float(np.mean([scores[index].mean() for index in tier]))
