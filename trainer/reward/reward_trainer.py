"""Learning a reward model from ranked trajectories (T-REX, Brown et al. 2019, section 4).

The loss is the thesis's and T-REX's: of two fragments the better one is to have the higher sum of
R, by cross entropy on the two sums (Bradley-Terry). Two ways to draw and score the fragments are
described at _PaperLogits and _FastLogits.
"""

from __future__ import annotations

import json
import time
from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import numpy.typing as npt
import torch
from safetensors import safe_open
from safetensors.torch import save
from torch import Tensor
from torch.nn import functional as F

from trainer.nn.devices import CPU, device_of, forward_batch
from trainer.nn.optimizers import optimizer_tensors, restore_optimizer
from trainer.nn.screens import channels_last_screens
from trainer.nn.seeding import torch_generator_from
from trainer.progress import Progress, Section
from trainer.reward.fragments import FragmentRule, draw_fragments
from trainer.reward.model import RewardModel, RewardNetwork
from trainer.reward.preference_dataset import (
    NO_PERFECT_GAMES,
    PerfectGames,
    PreferenceDataset,
    compare,
)
from tril.errors import Invalid
from tril.files.artifact_store import write_whole
from tril.game.observation import Observations
from tril.recipes import RewardRecipe
from tril.recording import Trajectory

LEVEL_STEPS = 25
"""Observations at a game's beginning and end by which its first and its final level are measured.
"""

CHECKPOINT_EVERY_S = 30.0

_REPORTS = 200
"""Points of a curve that a training adds at most."""


Seed = tuple[int, ...]
"""What the draws of one network's training are made of; see _rng."""

_WEIGHTS, _SNIPPETS, _PASS = range(3)


def train_reward_model(
    trajectories: Sequence[Trajectory],
    tiers: Sequence[Sequence[int]],
    recipe: RewardRecipe,
    training_seed: int,
    progress: Progress,
    checkpoint_folder: Path | None = None,
    perfect: PerfectGames = NO_PERFECT_GAMES,
    device: torch.device = CPU,
) -> RewardModel:
    """Learn a reward model from ranked trajectories.

    Args:
        trajectories: The demonstrations.
        tiers: Indices into ``trajectories``, best tier first; tied ones get no strict label.
        recipe: How it is learned.
        training_seed: Feeds every random choice: the same one gives the same model, with the same
            number of threads, on the processor. A GPU may round otherwise.
        progress: Told of loss and accuracy, as updates of all members of the ensemble.
        checkpoint_folder: An existing folder of this training alone; what a training that was
            killed left there is gone on from. None keeps nothing.
        perfect: The perfect demonstrations, for recipes that learn from them too.
        device: Where it is learned; the model returned is on the processor.

    Raises:
        Invalid: There are fewer than two tiers.
        RunCancelled: Raised by ``progress``.
    """
    comparisons = compare(trajectories, tiers, recipe, perfect)
    networks = []
    for member in range(recipe.ensemble):
        job = RewardTrainer(
            comparisons,
            recipe.updates,
            (training_seed, member),
            checkpoint_folder and checkpoint_folder / f"member-{member}.safetensors",
            device,
        )
        section = Section(progress, member * recipe.updates, recipe.ensemble * recipe.updates)
        networks.append(job.train(section))
    return calibrate(networks, comparisons, standardise=recipe.method == "fast").on(CPU)


class RewardTrainer:
    """The training of one network.

    Everything that is drawn for an update depends on the seed and the update's number alone, so
    that a training that was interrupted goes on as if it had not been.

    Args:
        comparisons: What it is learned from, and how.
        updates: Gradient updates.
        seed: What all draws are made of.
        checkpoint: File that is gone on from if it exists; None keeps nothing.
        device: Where it is learned.
    """

    def __init__(
        self,
        comparisons: PreferenceDataset,
        updates: int,
        seed: Seed,
        checkpoint: Path | None = None,
        device: torch.device = CPU,
    ) -> None:
        recipe = comparisons.recipe
        self._updates = updates
        self._checkpoint = checkpoint
        self.network = new_network(_rng(seed, _WEIGHTS)).to(device)
        self._parameters = list(self.network.parameters())
        self._optimizer = torch.optim.Adam(
            self._parameters, lr=recipe.learning_rate, weight_decay=recipe.weight_decay
        )
        kind = _PaperLogits if recipe.method == "paper" else _FastLogits
        self._logits = kind(self.network, comparisons, updates, seed)
        self._recent: list[tuple[float, float]] = []

    def train(self, progress: Progress) -> RewardNetwork:
        """Learn and return the network; progress is told of updates."""
        begun = self._load()
        saved_at = time.monotonic()
        if begun:
            progress.advance(begun, self._updates)
        every = max(1, self._updates // _REPORTS)
        for update in range(begun + 1, self._updates + 1):
            logits = self._logits(update - 1)
            # Cross entropy between two sums is softplus of their difference.
            loss = F.softplus(-logits).mean()
            self._optimizer.zero_grad()
            loss.backward()  # type: ignore[no-untyped-call]
            self._optimizer.step()
            self._recent.append((loss.item(), (logits > 0).float().mean().item()))
            values = None
            is_last = update == self._updates
            if update % every == 0 or is_last:
                means = np.mean(self._recent, axis=0)
                values = {"loss": float(means[0]), "accuracy": float(means[1])}
                self._recent.clear()
            progress.advance(update, self._updates, values)
            if is_last or time.monotonic() - saved_at >= CHECKPOINT_EVERY_S:
                self._save(update)
                saved_at = time.monotonic()
        return self.network

    def _save(self, update: int) -> None:
        if self._checkpoint is None:
            return
        tensors = {f"network/{name}": t for name, t in self.network.state_dict().items()}
        adam = optimizer_tensors(self._optimizer, self._parameters)
        tensors |= {f"optimizer/{name}": tensor for name, tensor in adam.items()}
        state = json.dumps({"update": update, "recent": self._recent})
        contiguous = {name: tensor.contiguous() for name, tensor in tensors.items()}
        write_whole(self._checkpoint, save(contiguous, {"state": state}))

    def _load(self) -> int:
        """Take the checkpoint up; return how many updates are done."""
        if self._checkpoint is None or not self._checkpoint.exists():
            return 0
        with safe_open(str(self._checkpoint), framework="pt") as file:
            state = json.loads(file.metadata()["state"])
            tensors = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118
        parts: dict[str, dict[str, Tensor]] = {"network": {}, "optimizer": {}}
        for name, tensor in tensors.items():
            part, _, rest = name.partition("/")
            parts[part][rest] = tensor
        self.network.load_state_dict(parts["network"])
        restore_optimizer(self._optimizer, self._parameters, parts["optimizer"])
        self._recent = [(loss, accuracy) for loss, accuracy in state["recent"]]
        return int(state["update"])


class _PaperLogits:
    """The logits of an update as T-REX has them: the sums of R of its own few fragment pairs.

    Fragment pairs are drawn once and gone through in several passes, every
    ``observation_stride``-th observation of a fragment counts, and the logit is the sum (not the
    mean) of R of the better fragment minus that of the worse.

    Differences from T-REX: fragments are cut at the shorter game of each pair instead of at the
    shortest of all, each pass takes the pairs in a new order, and games of equal rank form no
    pair, where T-REX gives them a strict label.
    """

    def __init__(
        self,
        network: RewardNetwork,
        comparisons: PreferenceDataset,
        updates: int,
        seed: Seed,
    ) -> None:
        self._network = network
        self._device = device_of(network)
        self._games = comparisons.games
        self._recipe = recipe = comparisons.recipe
        self._seed = seed
        sizes = [len(game.observations) for game in self._games]
        count = recipe.fragment_pairs or updates * recipe.pairs_per_update
        rule = FragmentRule.of(recipe)
        self._drawn = draw_fragments(comparisons.pairs, sizes, rule, count, _rng(seed, _SNIPPETS))
        self._order = cache(self._drawn_order)

    def __call__(self, update: int) -> Tensor:
        """Return the logits of an update, counted from 0: float32 (pairs_per_update,)."""
        first = update * self._recipe.pairs_per_update
        places = range(first, first + self._recipe.pairs_per_update)
        count = len(self._drawn)
        chosen = [int(self._order(place // count)[place % count]) for place in places]
        fragments = [self._observations(index) for index in chosen]
        screens = channels_last_screens(np.concatenate(fragments))
        values = self._network(screens.to(self._device))
        halves = [half for pair in fragments for half in [len(pair) // 2] * 2]
        sums = torch.stack([part.sum() for part in values.split_with_sizes(halves)])
        return sums[0::2] - sums[1::2]

    def _drawn_order(self, number: int) -> npt.NDArray[np.int64]:
        """Return the order of the fragment pairs in a pass."""
        return _rng(self._seed, _PASS, number).permutation(len(self._drawn))

    def _observations(self, index: int) -> npt.NDArray[np.uint8]:
        """Return the better fragment, then the worse one, uint8 (2 L, 4, 84, 84)."""
        drawn, parts = self._drawn, []
        for which, starts in (
            (drawn.better, drawn.better_start),
            (drawn.worse, drawn.worse_start),
        ):
            begin = int(starts[index])
            taken = slice(begin, begin + int(drawn.length[index]), self._recipe.observation_stride)
            parts.append(self._games[int(which[index])].observations[taken])
        return np.concatenate(parts)


class _FastLogits:
    """The logits of an update from one pass over the games.

    Every update scores each game once, at every ``observation_stride``-th step from an offset
    drawn anew, and takes the sums of many fragments from the prefix sums of those scores.
    Neighbouring observations share three of four screens, so that the stride costs little of what
    there is to learn and saves most of the time.
    """

    def __init__(
        self,
        network: RewardNetwork,
        comparisons: PreferenceDataset,
        updates: int,
        seed: Seed,
    ) -> None:
        self._network = network
        self._device = device_of(network)
        self._comparisons = comparisons
        self._recipe = comparisons.recipe
        self._seed = seed
        self._observations = [game.observations for game in comparisons.games]
        self._first_steps = [game.first_step for game in comparisons.games]

    def __call__(self, update: int) -> Tensor:
        """Return the logits of an update, counted from 0: float32 (pairs_per_update,)."""
        recipe, stride = self._recipe, self._recipe.observation_stride
        rng = _rng(self._seed, _SNIPPETS, update)
        offset = int(rng.integers(stride))
        groups = self._comparisons.groups(rng)
        used = sorted({index for group in groups for pair in group.pairs for index in pair})
        taken, first = zip(*(self._take(index, offset) for index in used), strict=True)
        table = self._prefix_sums(taken, first)
        ends = [begin + len(one) for begin, one in zip(first, taken, strict=True)]
        row = {index: number for number, index in enumerate(used)}
        counts = _shared_out(recipe.pairs_per_update, [group.share for group in groups])
        logits = []
        for group, count in zip(groups, counts, strict=True):
            pairs = [(row[better], row[worse]) for better, worse in group.pairs]
            rule = replace(FragmentRule.of(recipe), starts=group.starts).every(stride)
            drawn = draw_fragments(pairs, ends, rule, count, rng, first)
            better = _sums(table, drawn.better, drawn.better_start, drawn.length)
            logits.append(better - _sums(table, drawn.worse, drawn.worse_start, drawn.length))
        return torch.cat(logits)

    def _take(self, index: int, offset: int) -> tuple[Observations, int]:
        """Return a game's observations at the steps offset + k * stride, and the first such k."""
        stride, observations = self._recipe.observation_stride, self._observations[index]
        first = max(0, -(-(self._first_steps[index] - offset) // stride))
        begin = offset + first * stride - self._first_steps[index]
        # A game that ends before counts with its last observation.
        return observations[min(begin, len(observations) - 1) :: stride], first

    def _prefix_sums(self, taken: Sequence[Observations], first: Sequence[int]) -> Tensor:
        """Return the sums of R over each game's first k taken steps, float32 (games, most + 1)."""
        inputs = torch.cat([channels_last_screens(one) for one in taken]).to(self._device)
        parts = torch.split(inputs, forward_batch(self._device))
        values = torch.cat([self._network(part) for part in parts])
        sizes = [len(one) for one in taken]
        width = max(begin + size for begin, size in zip(first, sizes, strict=True))
        table = torch.zeros(len(taken), width + 1, device=self._device)
        for row, (begin, part) in enumerate(
            zip(first, values.split_with_sizes(sizes), strict=True)
        ):
            table[row, begin + 1 : begin + 1 + len(part)] = part.cumsum(0)
        return table


def _shared_out(count: int, shares: Sequence[float]) -> list[int]:
    """Return how many of count fall to each share; the shares' sum is 1."""
    edges = np.rint(np.cumsum([0.0, *shares]) * count)
    return [int(part) for part in np.diff(edges)]


def _sums(
    table: Tensor,
    which: npt.NDArray[np.int64],
    start: npt.NDArray[np.int64],
    length: npt.NDArray[np.int64],
) -> Tensor:
    rows = torch.from_numpy(which)
    return table[rows, torch.from_numpy(start + length)] - table[rows, torch.from_numpy(start)]


def _rng(seed: Seed, *place: int) -> np.random.Generator:
    return np.random.default_rng([*seed, *place])


def calibrate(
    networks: Sequence[RewardNetwork], comparisons: PreferenceDataset, *, standardise: bool
) -> RewardModel:
    """Make a reward model of trained networks.

    Args:
        networks: The members of the ensemble.
        comparisons: What they were trained on.
        standardise: Whether each network's output is scaled to a standard deviation of 1 over all
            states of the ranked demonstrations and shifted so that the tier of lowest mean R has a
            mean of 0. Preferences leave both open. With this choice a game that ends early is no
            better than the worst demonstration going on.
    """
    ranked, best = comparisons.ranked, comparisons.best
    members = tuple(networks)
    raw = RewardModel(members, (0.0,) * len(members), (1.0,) * len(members))
    if standardise:
        outputs = [
            _scores(RewardModel((one,), (0.0,), (1.0,)), comparisons, ranked) for one in members
        ]
        scales = [float(np.concatenate(list(out.values())).std()) for out in outputs]
        if min(scales) < 1e-6:
            raise Invalid(
                "The reward model gives all states the same value: nothing was learned from this"
                " ranking. Use a higher learning rate, or other demonstrations."
            )
        lowest = [
            min(float(np.mean([out[i].mean() for i in tier])) for tier in comparisons.tiers)
            for out in outputs
        ]
        raw = replace(raw, offsets=tuple(lowest), scales=tuple(scales))
    scores = _scores(raw, comparisons, dict.fromkeys((*ranked, *best)))
    zero = float(np.mean([values[:LEVEL_STEPS].mean() for values in scores.values()]))
    one = float(np.mean([scores[index][-LEVEL_STEPS:].mean() for index in best]))
    if not one > zero:
        # Nothing was learned; the check of the ranking says so. Any scale keeps R usable.
        one = zero + 1.0
    return replace(raw, zero=zero, one=one)


def new_network(rng: np.random.Generator) -> RewardNetwork:
    """Make a network with PyTorch's own initialisation, drawn from this generator alone."""
    return torch_generator_from(rng, RewardNetwork)


def _scores(
    model: RewardModel, comparisons: PreferenceDataset, games: Iterable[int]
) -> dict[int, npt.NDArray[np.float32]]:
    return {index: model.score(comparisons.games[index].observations) for index in games}
