"""Learning on every device there is: on a GPU, too, where there is one."""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np
import pytest
import torch

from tests.trainer.policy.made_up import observations, random_model, short_recording, tiny_recipe
from tests.trainer.policy.test_imitator import STEPS, Watched
from tests.trainer.reward.test_reward_trainer import RECIPES, TIERS, TRAJECTORIES
from trainer.nn.devices import CPU, compare_gradients, device_of, learning_device
from trainer.nn.precision import Precision
from trainer.policy import imitator
from trainer.policy.gail import train_by_gail
from trainer.policy.imitator import ImitationTask, train_imitator
from trainer.policy.networks import load_policy, new_policy, save_policy
from trainer.progress import NullProgress, RunCancelled
from trainer.reward.reward_trainer import train_reward_model
from tril.behaviours import BUILT_IN
from tril.recipes import GailRecipe

DEVICES = list(dict.fromkeys([CPU, learning_device("auto")]))


@pytest.fixture
def task(tmp_path: Path) -> ImitationTask:
    clone = tmp_path / "clone.zip"
    save_policy(new_policy("small", 1e-3, np.random.default_rng(8)), clone)
    return ImitationTask(
        model=random_model(),
        recordings=[short_recording(), short_recording(b"\x00" * 80)],
        tiers=[[0], [1]],
        recipe=tiny_recipe(),
        steps=STEPS,
        training_seed=11,
        behaviour=BUILT_IN[0],
        perfect=[short_recording()],
        clone=clone,
    )


@pytest.mark.parametrize("device", DEVICES)
def test_gradients_are_the_same(device: torch.device) -> None:
    assert compare_gradients(device) is None


@pytest.mark.parametrize("device", DEVICES)
def test_a_policy_answers_the_same(device: torch.device) -> None:
    seen = observations(12)
    network = new_policy("small", 1e-3, np.random.default_rng(8))
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
def test_a_training_goes_on_wherever_it_is_taken_up(
    task: ImitationTask,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    method: str,
    first: torch.device,
    second: torch.device,
) -> None:
    monkeypatch.setattr(imitator, "CHECKPOINT_EVERY_S", 0.0)
    if method == "gail":
        recipe = replace(task.recipe, method="gail", gail=GailRecipe(updates=2, batch_size=16))
        task = replace(task, recipe=recipe)
    train = train_by_gail if method == "gail" else train_imitator
    path = tmp_path / "imitator.zip"
    with pytest.raises(RunCancelled):
        train(task, path, tmp_path, Watched(45), precision=Precision.BFLOAT16, device=first)
    resumed = Watched()
    train(task, path, tmp_path, resumed, precision=Precision.BFLOAT16, device=second)
    assert 0 < resumed.done[0] < STEPS == resumed.done[-1]
    policy = load_policy(path)
    assert device_of(policy._network) == CPU
    np.testing.assert_allclose(policy.probabilities(observations(4)).sum(1), 1.0, rtol=1e-4)


@pytest.mark.parametrize("device", DEVICES)
@pytest.mark.parametrize("kind", RECIPES)
def test_a_reward_model_learned_anywhere_is_on_the_processor(
    kind: str, device: torch.device
) -> None:
    recipe = replace(RECIPES[kind], updates=2)
    model = train_reward_model(TRAJECTORIES, TIERS, recipe, 7, NullProgress(), device=device)
    assert device_of(model.members[0]) == CPU
    assert np.isfinite(model.score(observations(3))).all()
