"""TLS, proxies, and addresses that are open to others."""

from __future__ import annotations

import socket
import ssl
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import httpx2
import pytest
from starlette.testclient import TestClient
from typer.testing import CliRunner
from websockets.sync.client import connect
from websockets.typing import Origin

from cli.commands.services import page_url, server_url
from cli.main import app
from server.app import create_app
from server.web.exposure import check_exposure, may_connect
from server.web.security import address_with_token
from tests.server.clients import ONE_GAME, build_frontend
from testsupport.certificates import Certificate, has_openssl, make_certificate
from testsupport.live import TIMEOUT_S, begin_game, cookie
from testsupport.processes import TrilProcess, server_process
from testsupport.workplace import Workplace, make_workplace
from tril.errors import Unavailable
from tril.settings import Settings

PROXY = "192.0.2.7"
STRANGER = "192.0.2.8"
NAME = "tril.example"

needs_openssl = pytest.mark.skipif(not has_openssl(), reason="needs the openssl program")


@pytest.fixture(scope="module")
def certificate(tmp_path_factory: pytest.TempPathFactory) -> Certificate:
    return make_certificate(tmp_path_factory.mktemp("certificate"))


@pytest.mark.parametrize("host", ["127.0.0.1", "127.0.0.9", "::1", "localhost"])
def test_this_machine_needs_no_encryption(host: str) -> None:
    check_exposure(Settings(host=host))


@pytest.mark.parametrize("host", ["0.0.0.0", "::", "192.0.2.1", "tril.example", "::ffff:192.0.2.1"])
def test_an_open_address_needs_encryption_or_a_word_that_it_needs_none(host: str) -> None:
    with pytest.raises(
        Unavailable, match=r"TRIL_TLS_CERTIFICATE.*TRIL_TRUSTED_PROXIES.*TRIL_PLAIN"
    ):
        check_exposure(Settings(host=host))
    check_exposure(Settings(host=host, plain_http=True))
    check_exposure(Settings(host=host, trusted_proxies=PROXY))


@pytest.mark.parametrize("command", ["up", "serve"])
def test_commands_refuse_an_open_address_before_anything_starts(
    command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("TRIL_HOST", "0.0.0.0")
    monkeypatch.setenv("TRIL_DATA", str(tmp_path / "data"))
    result = CliRunner().invoke(app, [command])
    assert result.exit_code == 1
    assert "TRIL_PLAIN_HTTP=1" in result.stderr
    assert not (tmp_path / "data").exists()


def test_settings_that_can_not_be_meant_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="set together"):
        Settings(tls_certificate=tmp_path / "a.pem")
    with pytest.raises(ValueError, match=r"proxy\.example"):
        Settings(trusted_proxies="10.0.0.1, proxy.example")
    assert Settings(tls_certificate="", tls_key="").uses_tls is False


def test_a_certificate_that_can_not_be_used_is_named(tmp_path: Path) -> None:
    missing = Settings(tls_certificate=tmp_path / "a.pem", tls_key=tmp_path / "b.pem")
    with pytest.raises(Unavailable, match=r"a\.pem"):
        check_exposure(missing)
    (tmp_path / "a.pem").write_text("nonsense")
    (tmp_path / "b.pem").write_text("nonsense")
    with pytest.raises(Unavailable, match="belong together"):
        check_exposure(missing)


def test_nobody_goes_past_a_proxy_that_encrypts() -> None:
    allowed = may_connect(Settings(host="0.0.0.0", trusted_proxies=f"{PROXY}, 10.1.0.0/16"))
    for address in (PROXY, "10.1.2.3", "::ffff:10.1.2.3", "127.0.0.1", "::1"):
        assert allowed(address), address
    for address in (STRANGER, "10.2.0.1", "2001:db8::1", ""):
        assert not allowed(address), address
    for settings in (
        Settings(trusted_proxies=PROXY),
        Settings(host="0.0.0.0", trusted_proxies=PROXY, plain_http=True),
    ):
        assert may_connect(settings)(STRANGER)


def test_the_printed_address_is_the_one_that_the_page_has() -> None:
    tls: dict[str, Any] = {"tls_certificate": "a.pem", "tls_key": "b.pem"}
    assert server_url(Settings(port=8000)) == "http://127.0.0.1:8000"
    assert server_url(Settings(port=8000, **tls)) == "https://127.0.0.1:8000"
    named: dict[str, Any] = {"allowed_hosts": f"{NAME}, other"}
    assert page_url(Settings(**named, **tls)) == f"https://{NAME}:8000"
    assert page_url(Settings(**named, trusted_proxies=PROXY)) == f"https://{NAME}"
    assert page_url(Settings(**named)) == "http://127.0.0.1:8000"
    opened: dict[str, Any] = {"host": "0.0.0.0", "plain_http": True}
    assert page_url(Settings(**named, **opened)) == f"http://{NAME}:8000"
    assert page_url(Settings(**opened)) == "http://127.0.0.1:8000"


@pytest.fixture(scope="module")
def encrypted(
    tmp_path_factory: pytest.TempPathFactory, certificate: Certificate
) -> Iterator[TrilProcess]:
    made = make_workplace(tmp_path_factory.mktemp("tls") / "data")
    made.database.close()
    with server_process(
        made.settings.data,
        n_processes=2,
        tls_certificate=certificate.path,
        tls_key=certificate.key,
    ) as running:
        yield running


@needs_openssl
def test_the_page_is_served_over_tls_with_a_secure_cookie(
    encrypted: TrilProcess, certificate: Certificate
) -> None:
    trusting = ssl.create_default_context(cafile=certificate.path)
    url = server_url(encrypted.settings)
    address = address_with_token(encrypted.settings, url)
    with httpx2.Client(base_url=url, verify=trusting, timeout=TIMEOUT_S) as http:
        assert http.get("/api/health").json() == {"status": "ok"}
        cookie_header = http.get(address).headers["set-cookie"]
        assert "; secure" in cookie_header.lower()
        assert http.get("/api/player").status_code == 200
        insecure = {"Origin": url.replace("https", "http")}
        assert http.get("/api/player", headers=insecure).status_code == 403
    with pytest.raises(httpx2.HTTPError):
        httpx2.get(url.replace("https", "http"), timeout=TIMEOUT_S)


@needs_openssl
def test_games_are_played_over_tls(encrypted: TrilProcess, certificate: Certificate) -> None:
    trusting = ssl.create_default_context(cafile=certificate.path)
    url = server_url(encrypted.settings)
    signed_in = {"Cookie": cookie(encrypted.settings)}
    with httpx2.Client(base_url=url, verify=trusting, headers=signed_in, timeout=TIMEOUT_S) as http:
        game = begin_game(http)
    with connect(
        url.replace("https", "wss") + game["stream_path"],
        ssl=trusting,
        additional_headers=signed_in,
        origin=Origin(url),
        compression=None,
    ) as stream:
        assert '"hello"' in str(stream.recv(TIMEOUT_S))


@needs_openssl
def test_the_health_check_asks_over_tls(
    encrypted: TrilProcess, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name, value in encrypted.settings.model_dump(exclude_defaults=True).items():
        monkeypatch.setenv(f"TRIL_{name.upper()}", str(value))
    assert CliRunner().invoke(app, ["health", "server"]).exit_code == 0
    printed = CliRunner().invoke(app, ["address"]).stdout
    assert printed.startswith(f"https://127.0.0.1:{encrypted.settings.port}/?token=")


@needs_openssl
def test_old_versions_of_tls_are_refused(encrypted: TrilProcess) -> None:
    old = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    old.check_hostname, old.verify_mode = False, ssl.CERT_NONE
    with pytest.warns(DeprecationWarning, match="TLSv1_1"):
        old.maximum_version = ssl.TLSVersion.TLSv1_1
    with (
        socket.create_connection(("127.0.0.1", encrypted.settings.port), TIMEOUT_S) as plain,
        pytest.raises((ssl.SSLError, ConnectionError)),
    ):
        old.wrap_socket(plain)


@pytest.fixture(scope="module")
def workplace(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Workplace]:
    made = make_workplace(tmp_path_factory.mktemp("proxied") / "data")
    yield made
    made.database.close()


def behind(workplace: Workplace, tmp_path: Path, peer: str) -> TestClient:
    """Return a client whose connections come from an address."""
    settings = workplace.settings.model_copy(
        update={"trusted_proxies": f"{PROXY}/32", "allowed_hosts": NAME}
    )
    application = create_app(settings, build_frontend(tmp_path), ONE_GAME)
    return TestClient(application, base_url=f"http://127.0.0.1:{settings.port}", client=(peer, 5))


FORWARDED = {
    "X-Forwarded-Proto": "https",
    "X-Forwarded-For": "198.51.100.4",
    "X-Forwarded-Host": NAME,
    "Origin": f"https://{NAME}",
}


@pytest.mark.parametrize(
    ("peer", "is_believed"), [(PROXY, True), (f"::ffff:{PROXY}", True), (STRANGER, False)]
)
def test_only_trusted_proxies_say_who_asks_and_how(
    workplace: Workplace, tmp_path: Path, peer: str, is_believed: bool
) -> None:
    with behind(workplace, tmp_path, peer) as client:
        address = address_with_token(workplace.settings, "")
        answer = client.get(address, headers=FORWARDED, follow_redirects=False)
        if is_believed:
            assert answer.status_code == 303
            assert "; secure" in answer.headers["set-cookie"].lower()
            insecure = {**FORWARDED, "Origin": f"http://{NAME}"}
            assert client.get("/api/health", headers=insecure).status_code == 403
        else:
            assert answer.status_code == 403, "the page of another site"
            same = {**FORWARDED, "Origin": f"http://127.0.0.1:{workplace.settings.port}"}
            answer = client.get(address, headers=same, follow_redirects=False)
            assert "secure" not in answer.headers["set-cookie"].lower()


def test_several_forwarded_hosts_are_not_chosen_from(workplace: Workplace, tmp_path: Path) -> None:
    with behind(workplace, tmp_path, PROXY) as client:
        twice = {"X-Forwarded-Host": f"evil.example, {NAME}"}
        assert client.get("/api/health", headers=twice).status_code == 200
        assert (
            client.get("/api/health", headers={"X-Forwarded-Host": "evil.example"}).status_code
            == 403
        )
