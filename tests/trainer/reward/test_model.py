import json
from pathlib import Path

import numpy as np
import pytest
import torch
from safetensors.torch import save_file
from torch import nn

from trainer.archive.standalone import reward_wrapper
from trainer.nn.checkpoints import load_tensors, save_tensors
from trainer.reward.model import RewardModel, RewardNetwork, Spread, new_network, predicted_return
from tril.errors import Invalid


@pytest.fixture
def observations() -> np.ndarray:
    return np.random.default_rng(0).integers(0, 256, (11, 4, 84, 84), dtype=np.uint8)


def a_network() -> RewardNetwork:
    return new_network(np.random.default_rng(1))


def test_network_is_the_one_of_appendix_a(observations: np.ndarray) -> None:
    network = a_network()
    layers: list[nn.Module] = []
    for layer in [*network.layers, network.hidden, network.output]:
        if layer is network.hidden:
            layers.append(nn.Flatten())
        layers += [layer, nn.LeakyReLU()]
    published = nn.Sequential(*layers[:-1])
    shapes = [tuple(p.shape) for p in published.parameters() if p.dim() > 1]
    assert shapes == [
        (16, 4, 7, 7),
        (16, 16, 5, 5),
        (16, 16, 3, 3),
        (16, 16, 3, 3),
        (64, 784),
        (1, 64),
    ]
    inputs = torch.from_numpy(observations)
    with torch.no_grad():
        expected = published(inputs.float() / 255).squeeze(1)
        torch.testing.assert_close(network(inputs), expected, rtol=1e-4, atol=1e-5)


def test_r_is_the_standardised_output(observations: np.ndarray) -> None:
    network = a_network()
    with torch.no_grad():
        expected = (network(torch.from_numpy(observations)) - 0.5) / 2.0
    found = RewardModel(network, 0.5, 2.0).score(observations)
    np.testing.assert_allclose(found, expected.numpy(), rtol=1e-4, atol=1e-5)


def test_predicted_return_leaves_the_start_out(observations: np.ndarray) -> None:
    model = RewardModel(a_network())
    expected = float(model.score(observations)[1:].sum(dtype=np.float64))
    assert predicted_return(model, observations) == pytest.approx(expected, rel=1e-5)


def test_level_maps_zero_and_one() -> None:
    model = RewardModel(a_network(), zero=-1.0, one=3.0)
    levels = model.level(np.array([-1.0, 1.0, 3.0], np.float32))
    assert levels.tolist() == [0.0, 0.5, 1.0]


def test_saved_model_is_the_same_model(tmp_path: Path, observations: np.ndarray) -> None:
    model = RewardModel(a_network(), 0.5, 2.0, -1.0, 2.0)
    model.save(tmp_path / "reward.safetensors")
    loaded = RewardModel.load(tmp_path / "reward.safetensors")
    np.testing.assert_array_equal(loaded.score(observations), model.score(observations))
    assert (loaded.offset, loaded.scale) == (model.offset, model.scale)
    assert (loaded.zero, loaded.one) == (-1.0, 2.0)


def a_spread(n_features: int = 64) -> Spread:
    rng = torch.Generator().manual_seed(3)
    return Spread(torch.randn(4, n_features, generator=rng), torch.randn(4, generator=rng))


def test_deviation_is_the_norm_of_the_refits_deviations(observations: np.ndarray) -> None:
    network = a_network()
    spread = a_spread()
    model = RewardModel(network, 0.5, 2.0, spread=spread)
    judged = model.judge(observations)
    with torch.no_grad():
        features = network.read(torch.from_numpy(observations))
        each = features @ spread.weight.T + spread.bias
    assert judged.deviations is not None
    np.testing.assert_allclose(judged.deviations, each.square().sum(1).sqrt(), rtol=1e-4)
    np.testing.assert_array_equal(judged.rewards, model.score(observations))


def test_without_a_spread_there_is_no_deviation(observations: np.ndarray) -> None:
    assert RewardModel(a_network()).judge(observations).deviations is None


def test_a_spread_is_kept_with_its_model(tmp_path: Path, observations: np.ndarray) -> None:
    model = RewardModel(a_network(), spread=a_spread())
    model.save(tmp_path / "reward.safetensors")
    loaded = RewardModel.load(tmp_path / "reward.safetensors")
    expected, found = model.judge(observations), loaded.judge(observations)
    assert expected.deviations is not None
    assert found.deviations is not None
    np.testing.assert_array_equal(found.deviations, expected.deviations)


def test_an_ensemble_of_an_earlier_version_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "reward.safetensors"
    RewardModel(a_network()).save(path)
    tensors, metadata = load_tensors(path)
    header = json.loads(metadata["model"]) | {"offsets": [0.0, 0.0], "scales": [1.0, 1.0]}
    save_tensors(path, tensors, metadata | {"model": json.dumps(header)})
    with pytest.raises(Invalid, match="ensemble of 2 networks"):
        RewardModel.load(path)
    with pytest.raises(ValueError, match="has an ensemble"):
        reward_wrapper.RewardModel(path)


def test_a_spread_of_other_features_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="of the network's features"):
        RewardModel(a_network(), spread=a_spread(63))
    path = tmp_path / "reward.safetensors"
    RewardModel(a_network(), spread=a_spread()).save(path)
    tensors, metadata = load_tensors(path)
    save_tensors(path, {**tensors, "spread.weight": torch.zeros(4, 63)}, metadata)
    with pytest.raises(Invalid, match="cannot be read"):
        RewardModel.load(path)


def test_a_spread_that_is_not_finite_is_refused() -> None:
    for value in (float("nan"), float("inf")):
        with pytest.raises(ValueError, match="finite spread"):
            Spread(torch.full((2, 64), value), torch.zeros(2))
        with pytest.raises(ValueError, match="finite spread"):
            Spread(torch.zeros(2, 64), torch.full((2,), value))


@pytest.mark.parametrize("ends", [(1.0, 1.0), (2.0, 1.0), (float("nan"), 1.0), (0.0, float("inf"))])
def test_a_level_without_a_range_is_refused(ends: tuple[float, float]) -> None:
    with pytest.raises(ValueError, match="from low to high"):
        RewardModel(a_network(), zero=ends[0], one=ends[1])


@pytest.mark.parametrize(
    ("metadata", "message"),
    [
        (None, "not a reward model"),
        ({"format": "tril-reward-model", "version": "9"}, "format 9"),
        ({"format": "tril-reward-model", "version": "1", "model": "{"}, "cannot be read"),
        ({"format": "tril-reward-model", "version": "1", "model": "[]"}, "cannot be read"),
        (
            {"format": "tril-reward-model", "version": "1", "model": '{"offsets": 5}'},
            "cannot be read",
        ),
    ],
)
def test_other_files_are_refused(
    tmp_path: Path, metadata: dict[str, str] | None, message: str
) -> None:
    save_file({"a": torch.zeros(1)}, tmp_path / "model.safetensors", metadata)
    with pytest.raises(Invalid, match=message):
        RewardModel.load(tmp_path / "model.safetensors")


def test_a_file_of_garbage_is_refused(tmp_path: Path) -> None:
    (tmp_path / "model.safetensors").write_bytes(b"garbage")
    with pytest.raises(Invalid, match="cannot be read"):
        RewardModel.load(tmp_path / "model.safetensors")


def test_observations_of_another_shape_are_refused(observations: np.ndarray) -> None:
    model = RewardModel(a_network())
    with pytest.raises(ValueError, match="uint8"):
        model.score(observations.astype(np.float32))
