from dataclasses import replace

import numpy as np
import pytest
import torch

from tests.trainer.samples import RecordingProgress, same
from trainer.policy.cloning import Transitions, train_clone
from trainer.policy.networks import Policy
from trainer.progress import NullProgress, RunCancelled
from tril.errors import Invalid
from tril.recipes import CloningRecipe
from tril.recording import Trajectory

RECIPE = CloningRecipe(network="small", learning_rate=1e-3, epochs=6, batch_size=32, patience=6)


def shown(seed: int, n_steps: int = 60, random_actions: bool = False) -> Trajectory:
    """Return a demonstration in which the action is told by which third of the screen is bright."""
    rng = np.random.default_rng(seed)
    # Action 1 is rare: one step in ten.
    actions = rng.choice([0, 1, 2], size=n_steps, p=[0.6, 0.1, 0.3])
    observations = rng.integers(0, 50, (n_steps + 1, 4, 84, 84), dtype=np.uint8)
    for step, action in enumerate(actions):
        observations[step, :, :, 28 * action : 28 * action + 28] += 150
    if random_actions:
        actions = rng.integers(0, 6, n_steps)
    return Trajectory(observations, actions.astype(np.int64))


@pytest.fixture(scope="module")
def demonstrations() -> list[Trajectory]:
    return [shown(seed) for seed in range(4)]


def test_a_clone_does_what_was_shown(demonstrations: list[Trajectory]) -> None:
    policy, result = train_clone(demonstrations, 6, RECIPE, 3, NullProgress())
    unseen = shown(99)
    chosen = Policy(policy).probabilities(unseen.observations[:-1]).argmax(1)
    assert np.mean(chosen == unseen.actions) > 0.95
    assert set(chosen.tolist()) == {0, 1, 2}
    assert result.accuracy > 0.8
    assert result.held_out_accuracy is not None
    assert result.held_out_accuracy > 0.95


def test_the_same_training_seed_gives_the_same_clone(demonstrations: list[Trajectory]) -> None:
    recipe = replace(RECIPE, epochs=1)
    first, again, other = (
        train_clone(demonstrations, 6, recipe, seed, NullProgress())[0].state_dict()
        for seed in (3, 3, 4)
    )
    assert same(first, again)
    assert not torch.equal(first["action_net.weight"], other["action_net.weight"])


def test_cloning_stops_when_held_out_demonstrations_get_worse() -> None:
    # Nothing to learn: what was seen can only be remembered.
    noise = [shown(seed, 40, random_actions=True) for seed in range(3)]
    recipe = replace(RECIPE, epochs=40, patience=2, validation_share=0.34)
    _, result = train_clone(noise, 6, recipe, 3, NullProgress())
    assert result.epochs < 30
    assert result.held_out_accuracy is not None


def test_a_cancelled_cloning_stops_within_an_update(demonstrations: list[Trajectory]) -> None:
    progress = RecordingProgress(cancel_at=2)
    with pytest.raises(RunCancelled):
        train_clone(demonstrations, 6, RECIPE, 3, progress)
    assert progress.done == [0, 0]


def test_every_epoch_has_a_point_on_the_curves(demonstrations: list[Trajectory]) -> None:
    progress = RecordingProgress()
    train_clone(demonstrations, 6, replace(RECIPE, epochs=2), 3, progress)
    assert [done for done, _ in progress.points] == [1, 2]
    curves = {"loss", "accuracy", "held_out_accuracy"}
    assert all(set(values) == curves for _, values in progress.points)


def test_without_demonstrations_there_is_no_clone() -> None:
    with pytest.raises(Invalid, match="perfect demonstration"):
        train_clone([], 6, RECIPE, 3, NullProgress())


def test_rare_actions_weigh_more_and_the_mean_weight_is_one(
    demonstrations: list[Trajectory],
) -> None:
    transitions = Transitions.of(demonstrations, 6)
    weights = transitions.class_weights()
    assert weights[1] > weights[2] > weights[0] > 0
    assert weights[3:].tolist() == [0.0, 0.0, 0.0]
    assert weights[transitions.actions].mean().item() == pytest.approx(1.0, rel=1e-4)
