from dataclasses import replace

import numpy as np
import pytest
import torch

from tests.trainer.samples import TIERS, planted_trajectories, planted_trajectory
from trainer.progress import NullProgress
from trainer.reward.perturbation import PerturbedDemonstration
from trainer.reward.preference_dataset import PerfectDemonstrations, PreferenceDataset
from trainer.reward.reward_trainer import RewardTrainer, train_reward_model
from tril.recipes import FAST_0_2, PAPER
from tril.recording import Trajectory

TRAJECTORIES = planted_trajectories()
RECIPE = replace(
    FAST_0_2.reward, updates=25, observation_stride=5, fragment_min_steps=5, pairs_per_update=64
)


make = PreferenceDataset.from_demonstrations


@pytest.fixture(scope="module")
def perfect() -> PerfectDemonstrations:
    """Two perfect games, the second of them ranked second; of each a copy that stays dark."""
    rng = np.random.default_rng(8)
    dark = [planted_trajectory(rng, 0, 30).observations for _ in range(2)]
    copies = [
        PerturbedDemonstration(number, 7, observations) for number, observations in enumerate(dark)
    ]
    return PerfectDemonstrations(
        [planted_trajectory(rng, 5, 40), TRAJECTORIES[1]], [None, 1], copies
    )


def test_all_that_is_known_becomes_pairs(perfect: PerfectDemonstrations) -> None:
    dataset = make(TRAJECTORIES, TIERS, RECIPE, perfect)
    ranked, free, better, perturbed = dataset.groups(np.random.default_rng(0))
    assert set(ranked.pairs) == set(free.pairs) == set(dataset.pairs)
    # The unranked one is game 6 and better than all but the first tier; of the ranked one the
    # ranking has said all.
    assert set(better.pairs) == {(6, i) for i in range(1, 6)}
    assert set(perturbed.pairs) == {(6, 7), (1, 8)}
    groups = (ranked, free, better, perturbed)
    assert [group.starts for group in groups] == ["same", "any", "any", "same"]
    assert sum(group.share for group in groups) == pytest.approx(1.0)
    assert perturbed.share == RECIPE.perturbed_share


def test_without_perfect_games_the_ranking_is_all(perfect: PerfectDemonstrations) -> None:
    alone = make(TRAJECTORIES, TIERS, RECIPE).groups(np.random.default_rng(0))
    assert sum(group.share for group in alone) == pytest.approx(1.0)
    assert {pair for group in alone for pair in group.pairs} == set(
        make(TRAJECTORIES, TIERS, RECIPE).pairs
    )
    (paper,) = make(TRAJECTORIES, TIERS, PAPER.reward, perfect).groups(np.random.default_rng(0))
    assert paper.starts == "later"


def test_a_share_of_the_rankings_pairs_compares_how_games_end(
    perfect: PerfectDemonstrations,
) -> None:
    recipe = replace(RECIPE, free_share=0.25, end_share=0.5)
    groups = make(TRAJECTORIES, TIERS, recipe, perfect).groups(np.random.default_rng(0))
    own = 1.0 - recipe.perfect_share - recipe.perturbed_share
    aligned, ends, free = groups[:3]
    assert [group.starts for group in (aligned, ends, free)] == ["same", "end", "any"]
    assert set(ends.pairs) == set(aligned.pairs)
    assert ends.share == pytest.approx(0.5 * own)
    assert aligned.share == pytest.approx(0.25 * own)


def test_what_is_held_out_is_held_out_everywhere(perfect: PerfectDemonstrations) -> None:
    dataset = make(TRAJECTORIES, TIERS, RECIPE, perfect).without({1, 3})
    assert dataset.tiers == ((0,), (2,), (4,), (5,))
    pairs = {p for group in dataset.groups(np.random.default_rng(0)) for p in group.pairs}
    assert not {1, 3, 8} & {index for pair in pairs for index in pair}


def test_the_logits_are_sums_over_fragments_of_the_games(perfect: PerfectDemonstrations) -> None:
    """Against plain sums, with a network that reads a game's number and step off its screens."""
    games = [_marked(number, 40, 0) for number in range(6)]
    marked = PerfectDemonstrations(
        [Trajectory(_marked(6, 40, 0), np.zeros(40, np.int64))],
        [None],
        [PerturbedDemonstration(0, 7, _marked(7, 30, 7))],
    )
    trajectories = [Trajectory(one, np.zeros(40, np.int64)) for one in games]
    recipe = replace(RECIPE, free_share=0.0, perfect_share=0.0, perturbed_share=1.0)
    trainer = RewardTrainer(make(trajectories, TIERS, recipe, marked), 1, (0,))
    trainer._logits.network = lambda inputs: (  # type: ignore[assignment]
        100.0 * inputs[:, 0, 0, 0].float() + inputs[:, 0, 0, 1].float()
    )
    # Original and copy have the same steps, so that each sampled step differs by 100 x (6 - 7).
    logits = trainer._logits(0)
    assert torch.all(logits < 0)
    assert torch.all(logits % 100 == 0)
    assert -logits.max() / 100 >= 1
    assert -logits.min() / 100 <= 30 / RECIPE.observation_stride + 1


def _marked(
    number: int, n_steps: int, first_step: int
) -> np.ndarray[tuple[int, ...], np.dtype[np.uint8]]:
    observations = np.zeros((n_steps + 1, 4, 84, 84), np.uint8)
    observations[:, 0, 0, 0] = number
    observations[:, 0, 0, 1] = first_step + np.arange(n_steps + 1)
    return observations


def test_perturbed_copies_teach_what_the_ranking_leaves_open() -> None:
    """A bright spot that only copies show is bad, and stays so in another game."""
    rng = np.random.default_rng(4)
    originals = [planted_trajectory(rng, 5, 40) for _ in range(4)]
    spotted = [trajectory.observations.copy() for trajectory in originals]
    for observations in spotted:
        observations[:, :, :12, :12] = 250
    copies = [PerturbedDemonstration(number, 0, one) for number, one in enumerate(spotted[:3])]
    perfect = PerfectDemonstrations(originals[:3], [None] * 3, copies)
    recipe = replace(RECIPE, updates=90)
    gaps = []
    for known in (PerfectDemonstrations(originals[:3], [None] * 3), perfect):
        dataset = make(TRAJECTORIES, TIERS, recipe, known)
        model = train_reward_model(dataset, 7, NullProgress())
        clean = model.level(model.score(originals[3].observations))
        gaps.append(float((clean - model.level(model.score(spotted[3]))).mean()))
    untaught, taught = gaps
    assert taught > untaught + 0.05
