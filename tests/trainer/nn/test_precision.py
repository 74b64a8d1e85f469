"""Floating point precision of learning."""

from __future__ import annotations

import numpy as np
import pytest
import torch

from tests.trainer.samples import observations
from trainer.nn.precision import Precision, layer_dtype
from trainer.policy.networks import Policy, new_policy
from tril.settings import Settings


@pytest.mark.parametrize(
    ("has_instructions", "expected"), [(True, Precision.BFLOAT16), (False, Precision.FLOAT32)]
)
def test_the_shorter_numbers_are_taken_where_the_processor_multiplies_them(
    monkeypatch: pytest.MonkeyPatch, has_instructions: bool, expected: Precision
) -> None:
    monkeypatch.setattr(
        torch.cpu, "_is_avx512_bf16_supported", lambda: has_instructions, raising=False
    )
    assert Precision.of("auto") is expected
    assert [Precision.of(one) for one in Precision] == list(Precision)


def test_a_processor_of_which_nothing_is_known_takes_the_longer_ones(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.delattr(torch.cpu, "_is_avx512_bf16_supported", raising=False)
    assert Precision.of("auto") is Precision.FLOAT32


def test_every_setting_is_a_precision(monkeypatch: pytest.MonkeyPatch) -> None:
    for wanted in ("auto", *Precision):
        monkeypatch.setenv("TRIL_LEARNING_PRECISION", wanted)
        assert Precision.of(Settings().learning_precision) in Precision


def test_layers_are_fed_what_they_multiply() -> None:
    assert layer_dtype() == torch.float32
    with Precision.BFLOAT16.autocast():
        assert layer_dtype() == torch.bfloat16
        with Precision.FLOAT32.autocast():
            assert layer_dtype() == torch.float32


@pytest.mark.parametrize("network", ["small", "nature"])
def test_a_policy_answers_in_32_bits_nearly_the_same(network: str) -> None:
    policy = new_policy(network, 6, 1e-3, np.random.default_rng(3))
    # Decided, as a trained policy is.
    with torch.no_grad():
        for parameter in policy.action_net.parameters():
            parameter.mul_(100.0)
    screens = torch.from_numpy(observations(12))
    answers = []
    for precision in Precision:
        with torch.no_grad(), precision.autocast():
            answers.append(policy.logits_and_values(screens))
    for exact, half in zip(*answers, strict=True):
        assert exact.dtype == half.dtype == torch.float32
        torch.testing.assert_close(exact, half, rtol=0.03, atol=0.03)
    expected = answers[0][0].softmax(1).numpy()
    np.testing.assert_allclose(Policy(policy).probabilities(screens.numpy()), expected, rtol=1e-4)
