import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest
import torch
from stable_baselines3.common.policies import ActorCriticCnnPolicy

from tests.trainer.samples import observations
from trainer.nn.checkpoints import save_tensors
from trainer.policy.networks import (
    OBSERVATION_SPACE,
    SIZES,
    Policy,
    ScreenPolicy,
    action_space,
    load_network,
    load_policy,
    new_policy,
    save_policy,
    save_weights,
)
from tril.errors import Invalid
from tril.games.space_invaders import SPACE_INVADERS

LOAD_WITHOUT_THE_PROJECT = """
import sys
import numpy as np
from stable_baselines3 import PPO
policy, observations, answer = sys.argv[1:]
model = PPO.load(policy, device="cpu")
np.save(answer, model.predict(np.load(observations), deterministic=True)[0])
foreign = [m for m in sys.modules if m.split(".")[0] in {"tril", "trainer", "server", "cli"}]
assert not foreign, foreign
for name in ("tril", "trainer"):
    try:
        __import__(name)
    except ModuleNotFoundError:
        continue
    raise AssertionError(name + " can be imported here, so that the test shows nothing")
"""


def opinionated_policy(network: str) -> ScreenPolicy:
    policy = new_policy(network, 6, 1e-3, np.random.default_rng(1))
    with torch.no_grad():
        for name, parameter in policy.named_parameters():
            if name == "action_net.weight":
                parameter.mul_(300)
            if name.endswith("bias"):
                parameter.uniform_(-0.1, 0.1, generator=torch.Generator().manual_seed(3))
    return policy


def test_the_nature_network_is_that_of_stable_baselines3() -> None:
    policy = opinionated_policy("nature")
    plain = ActorCriticCnnPolicy(OBSERVATION_SPACE, action_space(6), lambda _: 1e-3)
    plain.load_state_dict(policy.state_dict())
    inputs = torch.from_numpy(observations(5))
    with torch.no_grad():
        logits, values = policy.logits_and_values(inputs)
        expected = plain.get_distribution(inputs).distribution.probs  # type: ignore[union-attr]
        torch.testing.assert_close(logits.softmax(1), expected, rtol=1e-3, atol=1e-5)
        torch.testing.assert_close(values, plain.predict_values(inputs)[:, 0], rtol=1e-3, atol=1e-4)


@pytest.mark.parametrize("network", SIZES)
def test_a_saved_policy_does_the_same(tmp_path: Path, network: str) -> None:
    policy = opinionated_policy(network)
    save_policy(policy, tmp_path / "policy.zip")
    inputs = observations(7)
    loaded = load_policy(tmp_path / "policy.zip")
    np.testing.assert_allclose(
        loaded.probabilities(inputs), Policy(policy).probabilities(inputs), rtol=1e-4, atol=1e-6
    )


@pytest.mark.parametrize("network", SIZES)
def test_plain_stable_baselines3_loads_a_policy_without_this_project(
    tmp_path: Path, network: str
) -> None:
    policy = opinionated_policy(network)
    save_policy(policy, tmp_path / "policy.zip")
    np.save(tmp_path / "observations.npy", observations(9))
    # A folder of the packages alone on the path: this project is installed as editable.
    packages = Path(np.__file__).parents[1]
    program = f"import sys; sys.path.append({str(packages)!r})\n{LOAD_WITHOUT_THE_PROJECT}"
    names = ["policy.zip", "observations.npy", "answer.npy"]
    done = subprocess.run(
        [sys.executable, "-I", "-S", "-c", program, *(str(tmp_path / name) for name in names)],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    expected = Policy(policy).probabilities(observations(9)).argmax(1)
    assert len(set(expected.tolist())) > 1
    np.testing.assert_array_equal(np.load(tmp_path / "answer.npy"), expected)


def test_probabilities_add_up_and_bad_shapes_are_refused() -> None:
    policy = Policy(opinionated_policy("small"))
    np.testing.assert_allclose(policy.probabilities(observations(300)).sum(1), 1.0, rtol=1e-5)
    with pytest.raises(ValueError, match="uint8"):
        policy.probabilities(observations(2)[:, :3])


def test_files_that_are_no_policy_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "policy.zip"
    path.write_bytes(b"garbage")
    with pytest.raises(Invalid, match="cannot be read as a policy"):
        load_policy(path)
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("policy.pth", b"garbage")
    with pytest.raises(Invalid, match="cannot be read as a policy"):
        load_policy(path)


@pytest.mark.parametrize("network", SIZES)
def test_plain_weights_do_the_same_and_halved_ones_nearly(tmp_path: Path, network: str) -> None:
    policy = opinionated_policy(network)
    inputs = observations(7)
    expected = Policy(policy).probabilities(inputs)
    full, half = tmp_path / "full.safetensors", tmp_path / "half.safetensors"
    save_weights(policy, full, SPACE_INVADERS.controls.actions)
    save_weights(policy, half, SPACE_INVADERS.controls.actions, half=True)
    np.testing.assert_allclose(
        load_policy(full).probabilities(inputs), expected, rtol=1e-4, atol=1e-6
    )
    np.testing.assert_allclose(load_policy(half).probabilities(inputs), expected, atol=0.05)
    assert half.stat().st_size < 0.6 * full.stat().st_size


def test_a_policy_goes_from_plain_weights_to_stable_baselines3_and_back(tmp_path: Path) -> None:
    save_weights(
        opinionated_policy("small"),
        tmp_path / "policy.safetensors",
        SPACE_INVADERS.controls.actions,
    )
    network = load_network(tmp_path / "policy.safetensors")
    save_policy(network, tmp_path / "policy.zip")
    again = load_network(tmp_path / "policy.zip")
    for name, weights in network.state_dict().items():
        assert torch.equal(again.state_dict()[name], weights)


@pytest.mark.parametrize(
    ("metadata", "tensors", "message"),
    [
        ({"format": "other"}, {}, "no weights of a policy"),
        ({"format": "tril-policy", "version": "2"}, {}, "no weights of a policy"),
        ({"format": "tril-policy", "version": "1"}, {}, "cannot be read as a policy"),
        ({"format": "tril-policy", "version": "1", "config": "[]"}, {}, "cannot be read"),
        (
            {
                "format": "tril-policy",
                "version": "1",
                "config": '{"channels": [9999, 9999, 9999], "features": 9999}',
            },
            {},
            "unknown size",
        ),
        (
            {
                "format": "tril-policy",
                "version": "1",
                "config": '{"channels": [16, 32, 32], "features": 256}',
            },
            {"action_net.weight": torch.zeros(6, 256), "more": torch.zeros(1)},
            "unknown weights: more",
        ),
    ],
)
def test_plain_weights_of_something_else_are_refused(
    tmp_path: Path, metadata: dict[str, str], tensors: dict[str, torch.Tensor], message: str
) -> None:
    path = tmp_path / "policy.safetensors"
    save_tensors(path, tensors, metadata)
    with pytest.raises(Invalid, match=message):
        load_policy(path)
    path.write_bytes(b"garbage")
    with pytest.raises(Invalid, match="cannot be read as a policy"):
        load_policy(path)
