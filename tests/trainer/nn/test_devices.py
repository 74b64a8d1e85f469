"""The device that networks learn on."""

from __future__ import annotations

import logging
import warnings

import numpy as np
import pytest
import torch

from tests.trainer.samples import ELSEWHERE, observations, random_model
from trainer.nn import devices
from trainer.nn.devices import CPU, compare_gradients, device_of, forward_batch, learning_device
from trainer.nn.precision import Precision
from trainer.policy.cloning import Transitions
from trainer.policy.networks import Policy, new_policy
from tril.errors import Invalid

GPU = torch.device("cuda", 0)


@pytest.fixture
def gpu(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let PyTorch say that there is a GPU."""
    monkeypatch.setattr(torch.cuda, "is_available", lambda: True)
    monkeypatch.setattr(torch.cuda, "current_device", lambda: 0)
    monkeypatch.setattr(torch.cuda, "get_device_name", lambda device: "A card")
    for name in ("allow_tf32", "deterministic"):
        monkeypatch.setattr(torch.backends.cudnn, name, getattr(torch.backends.cudnn, name))


def test_without_a_gpu_the_processor_learns(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(torch.cuda, "is_available", lambda: False)
    assert learning_device("auto") == learning_device("cpu") == CPU
    with pytest.raises(Invalid, match=r"finds none\. Set TRIL_LEARNING_DEVICE to auto or cpu"):
        learning_device("cuda")


def test_a_driver_that_is_too_old_is_told(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def not_available() -> bool:
        warnings.warn("The NVIDIA driver on your system is too old", stacklevel=1)
        return False

    monkeypatch.setattr(torch.cuda, "is_available", not_available)
    with caplog.at_level(logging.INFO):
        assert learning_device("auto") == CPU
    assert "driver on your system is too old" in caplog.text


@pytest.mark.usefixtures("gpu")
def test_a_gpu_that_computes_the_same_is_used_unless_it_is_not_wanted(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(devices, "compare_gradients", lambda device: compare_gradients(CPU))
    with caplog.at_level(logging.INFO):
        assert learning_device("auto") == learning_device("cuda") == GPU
    assert "A card" in caplog.text
    assert not torch.backends.cudnn.allow_tf32
    assert torch.backends.cudnn.deterministic
    assert learning_device("cpu") == CPU


@pytest.mark.usefixtures("gpu")
@pytest.mark.parametrize(
    "obstacle", ["its gradients differ", RuntimeError("no kernel image"), AssertionError("no CUDA")]
)
def test_a_gpu_that_is_of_no_use_is_left_alone(
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
    obstacle: str | Exception,
) -> None:
    def compare(device: torch.device) -> str:
        if isinstance(obstacle, Exception):
            raise obstacle
        return obstacle

    monkeypatch.setattr(devices, "compare_gradients", compare)
    with caplog.at_level(logging.INFO):
        assert learning_device("auto") == CPU
    assert str(obstacle) in caplog.text
    with pytest.raises(Invalid, match=str(obstacle)):
        learning_device("cuda")


def test_other_gradients_are_noticed_and_rounding_is_not(monkeypatch: pytest.MonkeyPatch) -> None:
    assert compare_gradients(CPU) is None
    loss = torch.nn.functional.softplus
    for wrong, expected in ((1.05, "by 5.0%"), (1.005, None), (float("nan"), "by nan%")):
        factors = iter((1.0, wrong))
        monkeypatch.setattr(
            torch.nn.functional,
            "softplus",
            lambda values, factors=factors: loss(values) * next(factors),
        )
        found = compare_gradients(CPU)
        assert found is None if expected is None else expected in str(found)


@pytest.mark.usefixtures("gpu")
@pytest.mark.skipif(torch.version.cuda is not None, reason="This build of PyTorch knows GPUs.")
def test_a_build_without_gpus_learns_on_the_processor() -> None:
    assert learning_device("auto") == CPU


@pytest.mark.parametrize(("has", "expected"), [(True, "bfloat16"), (False, "float32")])
def test_a_gpu_takes_the_shorter_numbers_if_it_multiplies_them(
    monkeypatch: pytest.MonkeyPatch, has: bool, expected: str
) -> None:
    monkeypatch.setattr(torch.cuda, "is_bf16_supported", lambda including_emulation: has)
    assert Precision.of("auto", GPU) == expected
    assert Precision.of("float32", GPU) == "float32"


def test_what_is_asked_goes_where_the_network_is() -> None:
    """The answers can't come back from there: there are none."""
    policy = new_policy("small", 6, 1e-3, np.random.default_rng(0), ELSEWHERE)
    assert device_of(policy) == ELSEWHERE
    with pytest.raises(NotImplementedError, match="no data"):
        Policy(policy).probabilities(observations(2))
    model = random_model().on(ELSEWHERE)
    with pytest.raises(NotImplementedError, match="no data"):
        model.score(observations(2))


def test_a_model_stays_what_it_is_and_is_copied_only_to_another_device() -> None:
    model = random_model()
    assert model.on(CPU) is model
    there = model.on(ELSEWHERE)
    assert device_of(there.network) == ELSEWHERE
    assert device_of(model.network) == CPU
    assert (there.offset, there.scale, there.zero) == (model.offset, model.scale, model.zero)


def test_a_clones_loss_is_computed_where_it_is() -> None:
    screens = torch.from_numpy(observations(6))
    transitions = Transitions(screens, torch.tensor([0, 1, 1, 2, 5, 1]), 6).on(ELSEWHERE)
    policy = new_policy("small", 6, 1e-3, np.random.default_rng(0), ELSEWHERE)
    logits, _ = policy.logits_and_values(transitions.observations)
    weights = transitions.class_weights()
    assert weights.device == ELSEWHERE
    torch.nn.functional.cross_entropy(logits, transitions.actions, weights).backward()  # type: ignore[no-untyped-call]


def test_a_gpu_is_given_more_at_once() -> None:
    assert forward_batch(GPU) > forward_batch(CPU)
