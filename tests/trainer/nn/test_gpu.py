"""Learning on every device there is: on a GPU, too, where there is one."""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np
import pytest
import torch

from tests.trainer.samples import (
    REWARD_RECIPE,
    STEPS,
    TIERS,
    RecordingProgress,
    imitation_task,
    observations,
    planted_trajectories,
    random_model,
)
from trainer.nn.devices import CPU, compare_gradients, device_of, learning_device
from trainer.nn.precision import Precision
from trainer.policy import imitator
from trainer.policy.imitator import train_imitator
from trainer.policy.networks import load_policy, new_policy
from trainer.progress import NullProgress, RunCancelled
from trainer.reward.preference_dataset import PreferenceDataset
from trainer.reward.reward_trainer import train_reward_model
from tril.recipes import GailRecipe, Method

DEVICES = list(dict.fromkeys([CPU, learning_device("auto")]))


@pytest.mark.parametrize("device", DEVICES)
def test_gradients_are_the_same(device: torch.device) -> None:
    assert compare_gradients(device) is None


@pytest.mark.parametrize("device", DEVICES)
def test_a_policy_answers_the_same(device: torch.device) -> None:
    seen = observations(12)
    network = new_policy("small", 6, 1e-3, np.random.default_rng(8))
    with torch.no_grad():
        expected = network.logits_and_values(torch.from_numpy(seen))
        found = network.to(device).logits_and_values(torch.from_numpy(seen).to(device))
    for one, other in zip(expected, found, strict=True):
        torch.testing.assert_close(other.cpu(), one, rtol=1e-3, atol=1e-4)
    model = random_model()
    scores = model.on(device).score(seen)
    np.testing.assert_allclose(scores, model.score(seen), rtol=1e-3, atol=1e-4)


@pytest.mark.parametrize(("first", "second"), list(product(DEVICES, DEVICES)))
@pytest.mark.parametrize("method", ["ppo", "gail"])
def test_a_training_continues_on_any_device(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    method: Method,
    first: torch.device,
    second: torch.device,
) -> None:
    monkeypatch.setattr(imitator, "CHECKPOINT_INTERVAL_S", 0.0)
    task, path = imitation_task(tmp_path), tmp_path / "imitator.zip"
    recipe = replace(task.recipe, method=method, gail=GailRecipe(updates=2, batch_size=16))
    task = replace(task, recipe=recipe)
    # In both while the first snapshot is judged; of PPO the start is judged before.
    interrupted = RecordingProgress({"ppo": 163, "gail": 45}[method])
    resumed = RecordingProgress()
    half = Precision.BFLOAT16
    with pytest.raises(RunCancelled):
        train_imitator(task, path, tmp_path, interrupted, precision=half, device=first)
    train_imitator(task, path, tmp_path, resumed, precision=half, device=second)
    assert 0 < resumed.done[0] < STEPS == resumed.done[-1]
    policy = load_policy(path)
    assert device_of(policy._network) == CPU
    np.testing.assert_allclose(policy.probabilities(observations(4)).sum(1), 1.0, rtol=1e-4)


@pytest.mark.parametrize("device", DEVICES)
def test_a_reward_model_learned_anywhere_is_on_the_cpu(device: torch.device) -> None:
    recipe = replace(REWARD_RECIPE, updates=2)
    dataset = PreferenceDataset.from_demonstrations(planted_trajectories(), TIERS, recipe)
    model = train_reward_model(dataset, 7, NullProgress(), device=device)
    assert device_of(model.network) == CPU
    assert np.isfinite(model.score(observations(3))).all()
