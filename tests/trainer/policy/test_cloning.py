from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from trainer.policy.cloning import Examples, best_demonstrations, clone, train_clone
from trainer.policy.networks import load_policy
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


def test_a_clone_does_what_was_shown(tmp_path: Path, demonstrations: list[Trajectory]) -> None:
    path = tmp_path / "clone.zip"
    result = train_clone(demonstrations, RECIPE, 3, path, NullProgress())
    unseen = shown(99)
    chosen = load_policy(path).probabilities(unseen.observations[:-1]).argmax(1)
    assert np.mean(chosen == unseen.actions) > 0.95
    assert set(chosen.tolist()) == {0, 1, 2}
    assert result.accuracy > 0.8
    assert result.left_out_accuracy is not None
    assert result.left_out_accuracy > 0.95


def test_the_same_training_seed_gives_the_same_clone(demonstrations: list[Trajectory]) -> None:
    recipe = replace(RECIPE, epochs=1)
    first, _ = clone(demonstrations, recipe, 3, NullProgress())
    again, _ = clone(demonstrations, recipe, 3, NullProgress())
    other, _ = clone(demonstrations, recipe, 4, NullProgress())
    for name, tensor in first.state_dict().items():
        assert torch.equal(tensor, again.state_dict()[name])
    name = "action_net.weight"
    assert not torch.equal(first.state_dict()[name], other.state_dict()[name])


def test_cloning_stops_when_left_out_demonstrations_get_worse() -> None:
    # Nothing to learn: only what was seen can be remembered.
    noise = [shown(seed, 40, random_actions=True) for seed in range(3)]
    recipe = replace(RECIPE, epochs=40, patience=2, validation_share=0.34)
    policy, result = clone(noise, recipe, 3, NullProgress())
    assert result.epochs < 30
    assert result.left_out_accuracy is not None
    del policy


class Watched:
    def __init__(self, stop_after: int) -> None:
        self.values: list[Mapping[str, float]] = []
        self.calls = 0
        self._stop_after = stop_after

    def advance(self, done: int, total: int, values: Mapping[str, float] | None = None) -> None:
        self.calls += 1
        if values:
            self.values.append(values)
        if self.calls == self._stop_after:
            raise RunCancelled


def test_a_cancelled_cloning_stops_within_an_update(demonstrations: list[Trajectory]) -> None:
    progress = Watched(stop_after=2)
    with pytest.raises(RunCancelled):
        clone(demonstrations, RECIPE, 3, progress)
    assert progress.calls == 2


def test_every_epoch_has_a_point_on_the_curves(demonstrations: list[Trajectory]) -> None:
    progress = Watched(stop_after=10_000)
    clone(demonstrations, replace(RECIPE, epochs=2), 3, progress)
    assert [set(values) for values in progress.values] == [
        {"loss", "accuracy", "left_out_accuracy"}
    ] * 2


def test_without_demonstrations_there_is_no_clone() -> None:
    with pytest.raises(Invalid, match="perfect demonstration"):
        clone([], RECIPE, 3, NullProgress())


def test_rare_actions_weigh_more_and_the_mean_weight_is_one(
    demonstrations: list[Trajectory],
) -> None:
    examples = Examples.of(demonstrations)
    weights = examples.weights()
    assert weights[1] > weights[2] > weights[0] > 0
    assert weights[3:].tolist() == [0.0, 0.0, 0.0]
    assert weights[examples.actions].mean().item() == pytest.approx(1.0, rel=1e-4)


def test_the_best_demonstrations_are_whole_tiers_from_the_top() -> None:
    tiers = [[3], [1, 2], [0], [4, 5, 6, 7]]
    assert best_demonstrations(tiers, 0.0) == [3]
    assert best_demonstrations(tiers, 0.3) == [3]
    assert best_demonstrations(tiers, 0.4) == [3, 1, 2]
    assert best_demonstrations(tiers, 1.0) == [3, 1, 2, 0, 4, 5, 6, 7]
