"""A reward that is a statement: inferred from the order, then read off the screen by a network.

What a game was like is known from its replay, as facts of the game's vocabulary (tril.vocabulary).
A posterior over statements gives each fact a coefficient, and R of a state is the sum of the facts
that hold in it, so that the sum of R over a game is what the order says of it. What is exported,
watched and explained is a network that has learned to tell these facts from an observation alone.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np
import numpy.typing as npt
import torch
from torch.nn import functional as F

from trainer.nn.checkpoints import check_finite
from trainer.nn.devices import CPU, device_of
from trainer.nn.scaling import N_SCREENS, scale_layers
from trainer.nn.screens import channels_last_screens
from trainer.nn.seeding import torch_seeded
from trainer.progress import Progress
from trainer.reward.fragment_logits import Seed
from trainer.reward.model import RewardModel, RewardNetwork, Spread
from trainer.reward.preference_dataset import PreferenceDataset
from tril.vocabulary.answers import Answer
from tril.vocabulary.facts import Vocabulary
from tril.vocabulary.posterior import Tiers
from tril.vocabulary.understanding import (
    Summaries,
    Understanding,
    shuffles_as_good,
    understand,
)

Array = npt.NDArray[np.float64]

PROBABILITY_READ = 0.95
"""The network reads the facts of the most probable statements, until they have this together."""
MOST_FACTS_READ = 96
BATCH_SIZE = 128
LEARNING_RATE = 1e-3
_CURVE_INTERVAL = 50
_WEIGHTS, _BATCHES = 0, 1
"""Numbers of the random streams."""


def understanding_of(dataset: PreferenceDataset, held_out: Collection[int] = ()) -> Understanding:
    """Infer what the order of a dataset's games is about.

    Args:
        dataset: The games, with their facts.
        held_out: Indices of games to be left out.

    Raises:
        Invalid: There are fewer than two tiers.
    """
    return understand(*_ordered_games(dataset, held_out))


def shuffled_orders_as_good(dataset: PreferenceDataset) -> int:
    """Return how many shuffled orders are explained as well as that of a dataset's games.

    Raises:
        Invalid: There are fewer than two tiers.
    """
    return shuffles_as_good(*_ordered_games(dataset))


def _ordered_games(
    dataset: PreferenceDataset, held_out: Collection[int] = ()
) -> tuple[Vocabulary, Summaries, Tiers, Sequence[int], Sequence[Answer]]:
    """Return the arguments of ``tril.vocabulary.understanding.understand``."""
    kept = dataset.without(held_out)
    games = tuple(dict.fromkeys((*kept.ranked, *kept.perfect)))
    row_of = {index: row for row, index in enumerate(games)}
    return (
        dataset.words,
        np.stack([dataset.summary(index) for index in games]),
        [[row_of[index] for index in tier] for tier in kept.tiers],
        [row_of[index] for index in dict.fromkeys(kept.perfect)],
        dataset.answers,
    )


class StatementTrainer:
    """Infers the statement of an order, and trains a network to read it off the screen.

    Args:
        dataset: What it is inferred from.
        updates: Gradient updates of the network.
        seed: Seeds all random numbers.
        device: Device to learn on.
    """

    def __init__(
        self, dataset: PreferenceDataset, updates: int, seed: Seed, device: torch.device = CPU
    ) -> None:
        self._dataset = dataset
        self._updates = updates
        self._seed = seed
        self._device = device

    def train(self, progress: Progress) -> RewardNetwork:
        """Return the network; ``progress`` counts updates and receives the loss."""
        understanding = understanding_of(self._dataset)
        read = facts_read(understanding)
        observations, facts = self._reading_lessons(read)
        coefficients = understanding.mean_coefficients()[read]
        return reading_network(
            observations, facts, coefficients, self._updates, self._seed, progress, self._device
        )

    def _reading_lessons(
        self, read: npt.NDArray[np.int64]
    ) -> tuple[list[npt.NDArray[np.uint8]], npt.NDArray[np.float32]]:
        """Return the observations of all games and the facts that hold in them."""
        games = [*self._dataset.trajectories, *self._dataset.varied]
        observations, facts = [], []
        for game in games:
            assert game.facts is not None
            # The observation at the start has no step; a step cut short by the end has no facts.
            n_steps = min(len(game.observations) - 1, len(game.facts))
            observations.append(game.observations[1 : n_steps + 1])
            facts.append(game.facts[:n_steps, read])
        return observations, np.concatenate(facts).clip(0.0, 1.0)


def reading_network(
    observations: Sequence[npt.NDArray[np.uint8]],
    facts: npt.NDArray[np.float32],
    coefficients: Array,
    updates: int,
    seed: Seed,
    progress: Progress,
    device: torch.device = CPU,
) -> RewardNetwork:
    """Train a network to read facts off the screen; its output is their weighted sum.

    Args:
        observations: Of each game, uint8 (n_steps, 4, 84, 84).
        facts: What holds in them, float32 (n_steps of all games, n_facts), 0 to 1.
        coefficients: What each fact adds to R, float64 (n_facts,).
        updates: Gradient updates.
        seed: Seeds all random numbers.
        progress: Counts updates; receives the loss.
        device: Device to learn on.
    """
    with torch_seeded(np.random.default_rng([*seed, _WEIGHTS])):
        network = RewardNetwork(len(coefficients)).to(device)
    rng = np.random.default_rng([*seed, _BATCHES])
    place = np.concatenate(
        [
            np.stack([np.full(len(of_game), game), np.arange(len(of_game))], 1)
            for game, of_game in enumerate(observations)
        ]
    )
    # What matters for R is read most carefully.
    weights = np.abs(coefficients) * facts.std(0)
    weights = weights / max(weights.sum(), 1e-9) + 0.5 / len(weights)
    loss_weights = torch.from_numpy(weights.astype(np.float32)).to(device)
    optimizer = torch.optim.Adam(network.parameters(), LEARNING_RATE)
    schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimizer, updates)
    assert network.memory is not None
    order = rng.permutation(len(place))
    begin = 0
    sample = np.stack([observations[game][step] for game, step in place[order[:N_SCREENS]]])
    scale_layers((*network.layers, network.hidden), F.leaky_relu, sample)
    for update in range(1, updates + 1):
        if begin + BATCH_SIZE > len(order):
            order, begin = rng.permutation(len(place)), 0
        rows = order[begin : begin + BATCH_SIZE]
        begin += BATCH_SIZE
        batch = np.stack([observations[game][step] for game, step in place[rows]])
        inputs = channels_last_screens(batch).to(device)
        pixels = inputs.to(torch.float32, memory_format=torch.channels_last)
        second = network.layers[1](F.leaky_relu(network.first(pixels)))
        logits = network.memory(network.hidden_values(second))
        targets = torch.from_numpy(facts[rows]).to(device)
        losses = F.binary_cross_entropy_with_logits(logits, targets, reduction="none")
        loss = (losses.mean(0) * loss_weights).sum()
        optimizer.zero_grad()
        loss.backward()  # type: ignore[no-untyped-call]
        optimizer.step()
        schedule.step()
        check_finite("reward model", loss)
        values = None
        if update % _CURVE_INTERVAL == 0 or update == updates:
            values = {"loss": float(loss.item())}
        progress.advance(update, updates, values)
    with torch.no_grad():
        weight = torch.from_numpy(coefficients[None]).to(network.output.weight)
        network.output.weight.copy_(weight)
        network.output.bias.zero_()
    return network


def facts_read(understanding: Understanding) -> npt.NDArray[np.int64]:
    """Return the columns of the facts that a network has to read, in order."""
    columns: set[int] = set()
    total = 0.0
    for statement in understanding.posterior.statements:
        more = columns | set(statement.columns[statement.weights != 0].tolist())
        if columns and (total >= PROBABILITY_READ or len(more) > MOST_FACTS_READ):
            break
        columns = more
        total += statement.probability
    return np.array(sorted(columns), np.int64)


def levels_of_facts(
    model: RewardModel, understanding: Understanding, facts: npt.NDArray[np.float32]
) -> npt.NDArray[np.float32]:
    """Return the level of each step by the statements, which the network only reads off the screen.

    Args:
        model: The model of a network that `StatementTrainer.train` returned.
        understanding: What it was made of.
        facts: What holds in the steps, float32 (n_steps, n_facts).

    Returns:
        float32 (n_steps,), as `RewardModel.level` returns it.
    """
    read = facts_read(understanding)
    output = facts[:, read].clip(0.0, 1.0) @ understanding.mean_coefficients()[read]
    rewards = (output - model.offset) / model.scale
    return model.level(rewards.astype(np.float32))


def spread_of_statements(network: RewardNetwork, understanding: Understanding) -> Spread:
    """Return how sure R is: how much the statements' rewards differ, by their probability.

    Args:
        network: What `StatementTrainer.train` returned for the same understanding.
        understanding: What it was made of.
    """
    read = facts_read(understanding)
    rows = understanding.coefficients()[:, read]
    mean = understanding.mean_coefficients()[read]
    deviations = (rows - mean) * np.sqrt(understanding.probabilities)[:, None]
    weight = torch.from_numpy(deviations.astype(np.float32)).to(device_of(network))
    return Spread(weight, torch.zeros(len(weight), device=weight.device))
