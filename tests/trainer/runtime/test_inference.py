"""The inference process and its client, over a real socket."""

from __future__ import annotations

import json
import os
import signal
import socket
import stat
import struct
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
import torch

from testsupport.processes import tril_process
from testsupport.workplace import Workplace, make_workplace
from trainer.explain.attention import attention_map
from trainer.explain.gradient import gradient_map
from trainer.explain.patches import patch_map
from trainer.explain.subject import ActionOdds, Subject
from trainer.policy.networks import Policy, load_policy, new_policy, save_policy
from trainer.progress import Progress
from trainer.reward.model import RewardModel, Spread, new_network
from trainer.runtime import answers
from trainer.runtime.answers import Models
from trainer.runtime.inference import new_server
from tril.errors import Invalid, NotFound, Unavailable
from tril.files.artifact_store import ArtifactStore
from tril.inference import AttentionMethod, GivenUp, InferenceClient, LocalEndpoint, endpoint_of
from tril.inference.messages import (
    MAX_BODY_BYTES,
    MAX_HEADER_BYTES,
    MAX_OBSERVATIONS,
    OBSERVATION_BYTES,
    receive_message,
    send_message,
)
from tril.play.observation import Observation, Observations
from tril.store.training import artifacts
from tril.store.training.artifacts import path_of


@pytest.fixture
def store(workplace: Workplace) -> ArtifactStore:
    return ArtifactStore(workplace.settings.artifact_root)


@contextmanager
def serving(workplace: Workplace) -> Iterator[None]:
    store = ArtifactStore(workplace.settings.artifact_root)
    models = Models(workplace.database, store)
    with new_server(workplace.settings, models) as server:
        thread = threading.Thread(target=server.serve_forever, args=(0.01,))
        thread.start()
        try:
            yield
        finally:
            server.shutdown()
            thread.join()


@pytest.fixture
def client(workplace: Workplace) -> InferenceClient:
    return InferenceClient(endpoint_of(workplace.settings), timeout_s=20.0)


def some_observations(n: int, seed: int = 0) -> Observations:
    return np.random.default_rng(seed).integers(0, 256, (n, 4, 84, 84), np.uint8)


def sparse_observations(n: int) -> Observations:
    observations = np.full((n, 4, 84, 84), BACKGROUND, np.uint8)
    observations[:, :, 40:46, 30:36] = some_observations(n)[:, :, 40:46, 30:36]
    return observations


def a_reward_model(seed: int = 0) -> RewardModel:
    return RewardModel(new_network(np.random.default_rng(seed)), 0.5, 2.0)


def keep_model(
    workplace: Workplace, store: ArtifactStore, run_id: str, tmp_path: Path, model: RewardModel
) -> None:
    path = tmp_path / "reward-model.safetensors"
    model.save(path)
    store.put(path_of(run_id, path.name), path.read_bytes())
    with workplace.database.writing() as session:
        artifacts.save(session, run_id, "reward_model", path.name, "application/octet-stream", 1)


def keep_policy(
    workplace: Workplace, store: ArtifactStore, run_id: str, kind: str, tmp_path: Path, seed: int
) -> Policy:
    path = tmp_path / f"{kind}.zip"
    save_policy(new_policy("small", 6, 0.0, np.random.default_rng(seed)), path)
    store.put(path_of(run_id, path.name), path.read_bytes())
    with workplace.database.writing() as session:
        artifacts.save(session, run_id, kind, path.name, "application/octet-stream", 1)
    return load_policy(path)


def run_with_model(workplace: Workplace, store: ArtifactStore, tmp_path: Path) -> str:
    run_id = workplace.make_run()
    keep_model(workplace, store, run_id, tmp_path, a_reward_model())
    return run_id


def test_rewards_equal_the_models_own(
    workplace: Workplace, store: ArtifactStore, client: InferenceClient, tmp_path: Path
) -> None:
    run_id = run_with_model(workplace, store, tmp_path)
    observations = some_observations(5)
    with serving(workplace):
        client.ping()
        judged = client.judge(run_id, observations)
    np.testing.assert_allclose(judged.rewards, a_reward_model().score(observations), rtol=1e-5)
    assert judged.deviations is None


def test_deviations_are_answered_where_the_model_knows_them(
    workplace: Workplace, store: ArtifactStore, client: InferenceClient, tmp_path: Path
) -> None:
    run_id = workplace.make_run()
    rng = torch.Generator().manual_seed(3)
    spread = Spread(torch.randn(4, 64, generator=rng), torch.randn(4, generator=rng))
    model = replace(a_reward_model(), spread=spread)
    keep_model(workplace, store, run_id, tmp_path, model)
    observations = some_observations(3)
    with serving(workplace):
        judged = client.judge(run_id, observations)
    expected = model.judge(observations)
    assert judged.deviations is not None
    assert expected.deviations is not None
    np.testing.assert_allclose(judged.rewards, expected.rewards, rtol=1e-5)
    np.testing.assert_allclose(judged.deviations, expected.deviations, rtol=1e-4)
    assert judged.deviations.min() > 0


def test_the_scale_is_that_of_the_models_level(
    workplace: Workplace, store: ArtifactStore, client: InferenceClient, tmp_path: Path
) -> None:
    run_id = workplace.make_run()
    keep_model(workplace, store, run_id, tmp_path, replace(a_reward_model(), zero=-0.5, one=2.0))
    with serving(workplace):
        assert client.scale(run_id) == (-0.5, 2.0)
        with pytest.raises(NotFound, match="no reward model yet"):
            client.scale("unknown")


def test_more_observations_than_fit_one_message_are_sent_in_parts(
    workplace: Workplace, store: ArtifactStore, client: InferenceClient, tmp_path: Path
) -> None:
    run_id = run_with_model(workplace, store, tmp_path)
    observations = np.repeat(some_observations(2), [MAX_OBSERVATIONS, 3], axis=0)
    with serving(workplace):
        rewards = client.judge(run_id, observations).rewards
        assert client.judge(run_id, observations[:0]).rewards.shape == (0,)
    one, other = a_reward_model().score(some_observations(2))
    assert rewards.shape == (MAX_OBSERVATIONS + 3,)
    np.testing.assert_allclose(rewards[:MAX_OBSERVATIONS], one, rtol=1e-4)
    np.testing.assert_allclose(rewards[MAX_OBSERVATIONS:], other, rtol=1e-4)


def test_a_run_without_a_model_is_refused(workplace: Workplace, client: InferenceClient) -> None:
    with serving(workplace):
        with pytest.raises(NotFound, match="no reward model yet"):
            client.judge("unknown", some_observations(1))
        with pytest.raises(Invalid, match="Expected observations uint8"):
            client.judge("unknown", np.zeros((1, 84, 84), np.uint8))


def test_a_replaced_model_is_loaded_again(
    workplace: Workplace, store: ArtifactStore, client: InferenceClient, tmp_path: Path
) -> None:
    run_id = run_with_model(workplace, store, tmp_path)
    observations = some_observations(3)
    with serving(workplace):
        client.judge(run_id, observations)
        keep_model(workplace, store, run_id, tmp_path, a_reward_model(7))
        rewards = client.judge(run_id, observations).rewards
    np.testing.assert_allclose(rewards, a_reward_model(7).score(observations), rtol=1e-5)


def test_each_observation_is_judged_by_the_policy_named_for_it(
    workplace: Workplace, store: ArtifactStore, client: InferenceClient, tmp_path: Path
) -> None:
    run_id = workplace.make_run()
    imitator = keep_policy(workplace, store, run_id, "imitator", tmp_path, 1)
    clone = keep_policy(workplace, store, run_id, "clone", tmp_path, 2)
    observations = some_observations(3)
    request = {"op": "act", "run_id": run_id, "policies": ["clone", "imitator", "clone"]}
    with serving(workplace), opened(workplace) as connection:
        for _ in range(2):
            send_message(connection, request, observations.tobytes())
            header, values = receive_message(connection)
            assert header["ok"], header
            probabilities = np.frombuffer(values, np.float32).reshape(3, 6)
            own = imitator.probabilities(observations[1:2])
            np.testing.assert_allclose(probabilities[1:2], own, atol=1e-6)
            own = clone.probabilities(observations[::2])
            np.testing.assert_allclose(probabilities[::2], own, atol=1e-6)


def test_a_connection_keeps_its_policy_although_the_file_is_replaced(
    workplace: Workplace, store: ArtifactStore, tmp_path: Path
) -> None:
    run_id = workplace.make_run()
    first = keep_policy(workplace, store, run_id, "clone", tmp_path, 1)
    observations = some_observations(1)
    request = {"op": "act", "run_id": run_id, "policies": ["clone"]}

    def ask(connection: socket.socket) -> np.ndarray[tuple[int], np.dtype[np.float32]]:
        send_message(connection, request, observations.tobytes())
        return np.frombuffer(receive_message(connection)[1], np.float32)

    with serving(workplace), opened(workplace) as connection:
        before = ask(connection)
        second = keep_policy(workplace, store, run_id, "clone", tmp_path, 2)
        np.testing.assert_array_equal(ask(connection), before)
        np.testing.assert_allclose(before, first.probabilities(observations)[0], atol=1e-6)
        with opened(workplace) as newer:
            own = second.probabilities(observations)[0]
            np.testing.assert_allclose(ask(newer), own, atol=1e-6)


def test_models_in_memory_are_bounded(
    workplace: Workplace, store: ArtifactStore, tmp_path: Path
) -> None:
    runs = [run_with_model(workplace, store, tmp_path) for _ in range(3)]
    models = Models(workplace.database, store, max_kept=2)
    first = models.reward_model(runs[0])
    second = models.reward_model(runs[1])
    assert models.reward_model(runs[0]) is first
    models.reward_model(runs[2])
    assert models.reward_model(runs[0]) is first
    assert models.reward_model(runs[1]) is not second


def test_the_socket_is_for_its_owner_alone_and_goes_with_the_process(
    workplace: Workplace, client: InferenceClient
) -> None:
    path = workplace.settings.inference_socket
    with serving(workplace):
        assert stat.S_IMODE(path.stat().st_mode) == 0o600
    assert not path.exists()
    with pytest.raises(Unavailable, match="inference process is not running"):
        client.ping()


def test_a_path_too_long_for_a_socket_address_works(tmp_path: Path) -> None:
    folder = tmp_path / ("deep" * 20) / ("deeper" * 20)
    workplace = make_workplace(folder)
    assert len(os.fsencode(workplace.settings.inference_socket)) > 108
    with serving(workplace):
        InferenceClient(endpoint_of(workplace.settings)).ping()
    workplace.database.close()


def test_a_connection_that_breaks_is_tried_once_more(workplace: Workplace) -> None:
    path = workplace.settings.inference_socket
    asked: list[str] = []

    def break_then_answer() -> None:
        for _ in range(2):
            connection, _ = listener.accept()
            with connection:
                asked.append(receive_message(connection)[0]["op"])
                if len(asked) == 2:
                    text = json.dumps({"ok": True, "n_bytes": 0}).encode()
                    connection.sendall(struct.pack("<I", len(text)) + text)

    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(str(path))
        listener.listen()
        thread = threading.Thread(target=break_then_answer)
        thread.start()
        InferenceClient(LocalEndpoint(path)).ping()
        thread.join()
    assert asked == ["ping", "ping"]


@contextmanager
def opened(workplace: Workplace) -> Iterator[socket.socket]:
    with socket.socket(socket.AF_UNIX) as connection:
        connection.settimeout(20)
        connection.connect(str(workplace.settings.inference_socket))
        yield connection


def ask_raw(workplace: Workplace, content: bytes) -> dict[str, object]:
    with opened(workplace) as connection:
        connection.sendall(content)
        return receive_message(connection)[0]


def framed(header: object) -> bytes:
    text = json.dumps(header).encode()
    return struct.pack("<I", len(text)) + text


BACKGROUND = 107
"""Of Pong's screen."""

MAPS: dict[AttentionMethod, Callable[[Subject, Observation], npt.NDArray[np.float32]]] = {
    "gradient": lambda subject, state: gradient_map(subject, state, BACKGROUND).sum(0),
    "occlusion": lambda subject, state: attention_map(subject, state, background=BACKGROUND).sum(0),
    "patches": lambda subject, state: patch_map(subject, state, background=BACKGROUND),
}


@pytest.mark.parametrize("method", list(MAPS))
def test_attention_is_that_of_the_model(
    workplace: Workplace,
    store: ArtifactStore,
    client: InferenceClient,
    tmp_path: Path,
    method: AttentionMethod,
) -> None:
    run_id = run_with_model(workplace, store, tmp_path)
    (observation,) = sparse_observations(1)
    with serving(workplace):
        found = client.attention(run_id, observation, "reward", method, lambda: False, BACKGROUND)
    np.testing.assert_allclose(
        found.values, MAPS[method](a_reward_model(), observation), rtol=1e-4, atol=1e-7
    )
    assert found.values.max() > 0
    assert found.action is None


@pytest.mark.parametrize("method", list(MAPS))
def test_a_policys_attention_is_that_of_the_action_it_would_choose(
    workplace: Workplace,
    store: ArtifactStore,
    client: InferenceClient,
    tmp_path: Path,
    method: AttentionMethod,
) -> None:
    run_id = workplace.make_run()
    policy = keep_policy(workplace, store, run_id, "clone", tmp_path, seed=3)
    (observation,) = sparse_observations(1)
    with serving(workplace):
        found = client.attention(run_id, observation, "clone", method, lambda: False, BACKGROUND)
        with pytest.raises(NotFound):
            client.attention(run_id, observation, "imitator", method, lambda: False, BACKGROUND)
    assert found.action == policy.probabilities(observation[None])[0].argmax()
    expected = MAPS[method](ActionOdds.of_choice(policy, observation), observation)
    np.testing.assert_allclose(found.values, expected, rtol=1e-4, atol=1e-7)
    assert found.values.max() > 0


def test_attention_that_nobody_waits_for_is_dropped_by_both_ends(
    workplace: Workplace,
    store: ArtifactStore,
    client: InferenceClient,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    run_id = run_with_model(workplace, store, tmp_path)
    stopped = threading.Event()

    def endless(model: object, observation: object, progress: Progress, *_: object) -> None:
        try:
            while True:
                progress.advance(0, 1)
        except BaseException:
            stopped.set()
            raise

    monkeypatch.setattr(answers, "attention_map", endless)
    with serving(workplace):
        with pytest.raises(GivenUp):
            client.attention(run_id, some_observations(1)[0], "reward", "occlusion", lambda: True)
        assert stopped.wait(20.0)
        client.ping()


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        (struct.pack("<I", MAX_HEADER_BYTES + 1), "header of at most"),
        (struct.pack("<I", 4) + b"\xff\xfe{}", "not JSON"),
        (framed([1, 2]), "not a JSON object"),
        (framed({"op": "judge", "n_bytes": MAX_BODY_BYTES + 1}), "Expected at most"),
        (framed({"op": "judge", "n_bytes": -1}), "Expected at most"),
        (framed({"op": "ping"}), "Expected at most"),
        (framed({"op": "delete", "n_bytes": 0}), "no operation 'delete'"),
        (framed({"op": "judge", "n_bytes": 0}), "lacks 'run_id'"),
        (framed({"op": "judge", "run_id": "x", "n_bytes": 3}) + b"abc", "whole observations"),
        (framed({"op": "act", "run_id": "x", "policies": ["clone"], "n_bytes": 0}), "for each of"),
        (framed({"op": "act", "run_id": "x", "policies": 3, "n_bytes": 0}), "for each of"),
        (
            framed({"op": "act", "run_id": "x", "policies": ["king"], "n_bytes": OBSERVATION_BYTES})
            + bytes(OBSERVATION_BYTES),
            "no policy 'king'",
        ),
        (framed({"op": "attention", "run_id": "x", "n_bytes": 0}), "Expected one observation"),
    ],
)
def test_bad_requests_are_refused_with_a_reason_and_harm_nothing(
    workplace: Workplace, client: InferenceClient, content: bytes, reason: str
) -> None:
    with serving(workplace):
        answer = ask_raw(workplace, content)
        assert answer["ok"] is False
        assert answer["kind"] == "invalid"
        assert reason in str(answer["detail"])
        client.ping()


def test_a_client_that_disconnects_in_mid_message_harms_nothing(
    workplace: Workplace, client: InferenceClient
) -> None:
    with serving(workplace):
        for content in (b"", b"\x05", framed({"op": "judge", "n_bytes": 100}) + b"half"):
            with socket.socket(socket.AF_UNIX) as connection:
                connection.connect(str(workplace.settings.inference_socket))
                connection.sendall(content)
        client.ping()


def test_the_process_serves_one_data_folder_alone_and_survives_a_kill(
    workplace: Workplace, client: InferenceClient
) -> None:
    with tril_process(workplace.settings, "inference") as first:
        first.wait_for("Inference answers")
        client.ping()
        with pytest.raises(Unavailable, match="Another inference process"):
            new_server(
                workplace.settings,
                Models(workplace.database, ArtifactStore(workplace.settings.artifact_root)),
            )
        first.process.kill()
    assert workplace.settings.inference_socket.exists()
    with tril_process(workplace.settings, "inference") as second:
        second.wait_for("Inference answers")
        client.ping()
        assert second.stop(signal.SIGTERM) == 0
    assert not workplace.settings.inference_socket.exists()
