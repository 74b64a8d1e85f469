"""The inference process over TCP: the same answers, and nobody gets any without the key."""

from __future__ import annotations

import asyncio
import signal
import socket
import threading
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from pydantic import SecretStr
from typer.testing import CliRunner

from cli.main import app
from server.play.watch.policy_client import PolicyClient
from testsupport.certificates import has_openssl, make_certificate
from testsupport.processes import tril_process
from testsupport.waiting import wait_until
from testsupport.watching import finished_run, running_inference
from testsupport.workplace import TINY, Workplace
from trainer.runtime import inference
from tril.errors import Invalid, Unavailable
from tril.inference import InferenceClient, TcpEndpoint, endpoint_of
from tril.inference.endpoint import _client_context, disconnect
from tril.inference.proof import GREETING, GREETING_BYTES, REFUSAL, RESPONSE_BYTES
from tril.settings import Settings

KEY = "a key of more than 32 characters".replace(" ", "-") + "-and-some"
OTHER_KEY = KEY[::-1]


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
        return port


@pytest.fixture(params=["tcp", "tls"])
def over_tcp(request: pytest.FixtureRequest, workplace: Workplace, tmp_path: Path) -> Settings:
    """Return the workplace's settings, with an address for the inference process."""
    more: dict[str, Any] = {"inference_address": f"{request.param}://127.0.0.1:{free_port()}"}
    if request.param == "tls":
        if not has_openssl():
            pytest.skip("needs the openssl program")
        made = make_certificate(tmp_path)
        more |= {"tls_certificate": made.path, "tls_key": made.key}
    return workplace.settings.model_copy(update={**more, "inference_key": SecretStr(KEY)})


@contextmanager
def serving(workplace: Workplace, settings: Settings) -> Iterator[None]:
    with running_inference(Workplace(settings, workplace.database, 1, workplace.ranked)):
        yield


def observations(n: int = 3) -> np.ndarray[tuple[int, ...], np.dtype[np.uint8]]:
    return np.random.default_rng(0).integers(0, 256, (n, 4, 84, 84), np.uint8)


def with_key(settings: Settings, key: str) -> Settings:
    return settings.model_copy(update={"inference_key": SecretStr(key)})


def test_answers_are_those_over_the_socket(workplace: Workplace, over_tcp: Settings) -> None:
    run_id = finished_run(workplace, TINY)
    clients = [InferenceClient(endpoint_of(one)) for one in (workplace.settings, over_tcp)]
    with serving(workplace, workplace.settings), serving(workplace, over_tcp):
        scales = [client.scale(run_id) for client in clients]
        assert scales[0] == scales[1]
        rewards = [client.judge(run_id, observations()).rewards for client in clients]
        np.testing.assert_array_equal(rewards[0], rewards[1])
        maps = [
            client.attention(run_id, observations()[0], "imitator", "gradient", lambda: False)
            for client in clients
        ]
        np.testing.assert_array_equal(maps[0].values, maps[1].values)
        assert maps[0].action == maps[1].action
        actions = [
            asyncio.run(_act(PolicyClient(endpoint_of(one), run_id)))
            for one in (workplace.settings, over_tcp)
        ]
        np.testing.assert_array_equal(actions[0], actions[1])


async def _act(client: PolicyClient) -> npt.NDArray[np.float32]:
    try:
        await client.act(["clone"] * 3, observations())
        return await client.act(["clone"] * 3, observations())
    finally:
        client.close()


def test_another_key_is_refused_by_both_clients(workplace: Workplace, over_tcp: Settings) -> None:
    stranger = endpoint_of(with_key(over_tcp, OTHER_KEY))
    with serving(workplace, over_tcp):
        with pytest.raises(Unavailable, match=r"another key.*TRIL_INFERENCE_KEY"):
            InferenceClient(stranger).ping()
        with pytest.raises(Unavailable, match=r"another key.*TRIL_INFERENCE_KEY"):
            asyncio.run(_act(PolicyClient(stranger, "x")))
        InferenceClient(endpoint_of(over_tcp)).ping()


def test_a_connection_is_closed_without_waiting_for_the_other_end(
    workplace: Workplace, over_tcp: Settings
) -> None:
    async def open_and_disconnect() -> None:
        _, writer = await endpoint_of(over_tcp).open()
        connection = writer.get_extra_info("socket")
        disconnect(writer)
        await asyncio.sleep(0)
        assert connection.fileno() == -1

    with serving(workplace, over_tcp):
        asyncio.run(open_and_disconnect())


@pytest.mark.parametrize("over_tcp", ["tls"], indirect=True)
def test_a_process_in_between_with_a_certificate_of_its_own_is_noticed(
    workplace: Workplace, over_tcp: Settings, tmp_path: Path
) -> None:
    (tmp_path / "other").mkdir()
    other = make_certificate(tmp_path / "other")
    endpoint = endpoint_of(over_tcp)
    assert isinstance(endpoint, TcpEndpoint)
    between = inference._server_context(
        over_tcp.model_copy(update={"tls_certificate": other.path, "tls_key": other.key})
    )
    asked: list[bytes] = []

    def pass_on(listener: socket.socket) -> None:
        plain, _ = listener.accept()
        with between.wrap_socket(plain, server_side=True) as client, ExitStack() as stack:
            raw = socket.create_connection(endpoint.address.destination)
            upstream = stack.enter_context(_client_context().wrap_socket(raw))
            client.sendall(upstream.recv(GREETING_BYTES))
            upstream.sendall(client.recv(RESPONSE_BYTES))
            client.sendall(upstream.recv(len(REFUSAL)))
            asked.append(client.recv(1))

    with serving(workplace, over_tcp), socket.create_server(("127.0.0.1", 0)) as listener:
        thread = threading.Thread(target=pass_on, args=(listener,))
        thread.start()
        port = listener.getsockname()[1]
        deceived = over_tcp.model_copy(update={"inference_address": f"tls://127.0.0.1:{port}"})
        with pytest.raises(Unavailable, match="another key"):
            InferenceClient(endpoint_of(deceived)).ping()
        thread.join()
    assert asked == [b""]


@pytest.mark.parametrize("over_tcp", ["tcp"], indirect=True)
def test_nothing_is_answered_before_the_key_is_proven(
    workplace: Workplace, over_tcp: Settings, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(inference, "CONNECT_TIMEOUT_S", 0.3)
    endpoint = endpoint_of(over_tcp)
    assert isinstance(endpoint, TcpEndpoint)
    request = b'\x1f\x00\x00\x00{"op": "ping", "n_bytes": 0}   '.ljust(RESPONSE_BYTES)
    with serving(workplace, over_tcp):
        for said, answered in ((request, REFUSAL), (b"slow", b"")):
            with socket.create_connection(endpoint.address.destination, 20) as stranger:
                assert stranger.recv(GREETING_BYTES).startswith(GREETING)
                stranger.sendall(said)
                assert stranger.recv(64) == answered
                if answered:
                    assert stranger.recv(1) == b""
        InferenceClient(endpoint).ping()


def test_connections_beyond_the_limit_are_closed_and_places_come_back(
    workplace: Workplace, over_tcp: Settings, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(inference, "MAX_CONNECTIONS", 2)
    endpoint = endpoint_of(over_tcp)
    assert isinstance(endpoint, TcpEndpoint)
    client = InferenceClient(endpoint)

    def answers() -> bool:
        try:
            client.ping()
        except Unavailable:
            return False
        return True

    with serving(workplace, over_tcp):
        with ExitStack() as stack:
            for _ in range(2):
                stack.enter_context(socket.create_connection(endpoint.address.destination))
            wait_until(lambda: not answers())
        wait_until(answers)


def test_a_restart_is_survived_and_absence_is_explained(
    workplace: Workplace, over_tcp: Settings
) -> None:
    client = InferenceClient(endpoint_of(over_tcp))
    said = rf"can't be reached at {over_tcp.inference_address} .*`tril inference`"
    with pytest.raises(Unavailable, match=said):
        client.ping()
    watching = PolicyClient(endpoint_of(over_tcp), finished_run(workplace, TINY))

    async def watch() -> None:
        with serving(workplace, over_tcp):
            await watching.act(["clone"], observations(1))
        watching.close()
        with pytest.raises(Unavailable, match=said):
            await watching.act(["clone"], observations(1))
        with serving(workplace, over_tcp):
            await watching.act(["clone"], observations(1))
            watching.close()

    asyncio.run(watch())


def test_the_process_listens_at_an_address_and_its_health_is_asked_there(
    over_tcp: Settings, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    path = tmp_path / "inference-key"
    path.write_text(f"{KEY}\n")
    settings = over_tcp.model_copy(
        update={"inference_key": SecretStr(""), "inference_key_file": path}
    )
    for name in ("data", "inference_address", "inference_key_file", "tls_certificate", "tls_key"):
        value = getattr(settings, name)
        if value is not None:
            monkeypatch.setenv(f"TRIL_{name.upper()}", str(value))
    if settings.database_url:
        monkeypatch.setenv("TRIL_DATABASE_URL", settings.database_url)
    assert CliRunner().invoke(app, ["health", "inference"]).exit_code == 1
    with tril_process(settings, "inference") as process:
        process.wait_for(f"Inference answers on {settings.inference_address}")
        healthy = CliRunner().invoke(app, ["health", "inference"])
        assert healthy.exit_code == 0, healthy.output
        listed = CliRunner().invoke(app, ["status"]).stdout
        assert f"running, {socket.gethostname()}" in listed
        assert KEY not in "".join(process.output)
        assert not settings.inference_socket.exists()
        assert process.stop(signal.SIGTERM) == 0


def test_another_machines_address_can_not_be_listened_at(
    workplace: Workplace, over_tcp: Settings
) -> None:
    here, _, port = over_tcp.inference_address.rpartition(":")
    scheme = here.partition(":")[0]
    elsewhere = over_tcp.model_copy(
        update={"inference_address": f"{scheme}://192.0.2.1:{port}", "plain_http": True}
    )
    with pytest.raises(Unavailable, match="--no-inference"), serving(workplace, elsewhere):
        pass
    with (
        serving(workplace, over_tcp),
        pytest.raises(Unavailable, match="can't listen"),
        serving(workplace, over_tcp),
    ):
        pass


@pytest.mark.parametrize(
    ("address", "key", "more", "reason"),
    [
        ("tcp://127.0.0.1:7000", "", {}, "TRIL_INFERENCE_KEY_FILE"),
        ("tls://gpu.example:7000", "", {}, "missing"),
        ("tls://gpu.example:7000", "secret", {}, "too short"),
        ("tcp://0.0.0.0:7000", KEY, {}, "TRIL_PLAIN_HTTP=1"),
        ("gpu.example:7000", KEY, {}, "tls://"),
        ("tcp://0.0.0.0:7000", "", {"plain_http": True}, "missing"),
    ],
)
def test_an_address_that_is_open_to_anybody_is_refused(
    address: str, key: str, more: dict[str, Any], reason: str
) -> None:
    with pytest.raises(Invalid, match=reason):
        endpoint_of(Settings(inference_address=address, inference_key=SecretStr(key), **more))


@pytest.mark.parametrize("command", ["up", "serve", "inference"])
def test_commands_refuse_it_before_anything_starts(
    command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("TRIL_INFERENCE_ADDRESS", "tcp://0.0.0.0:7000")
    monkeypatch.setenv("TRIL_DATA", str(tmp_path / "data"))
    result = CliRunner().invoke(app, [command])
    assert result.exit_code == 1
    assert "TRIL_INFERENCE_KEY_FILE" in result.stderr
    assert not (tmp_path / "data").exists()


def test_an_encrypted_address_needs_a_certificate_where_it_is_listened_at(
    workplace: Workplace,
) -> None:
    settings = workplace.settings.model_copy(
        update={"inference_address": "tls://127.0.0.1:7000", "inference_key": SecretStr(KEY)}
    )
    with pytest.raises(Invalid, match="TRIL_TLS_CERTIFICATE"), serving(workplace, settings):
        pass
