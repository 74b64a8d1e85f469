"""Sign-in, origins, sizes of bodies and paths of files."""

from __future__ import annotations

import json
import logging
import re
import stat
import threading
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from datetime import timedelta
from pathlib import Path

import pytest
from sqlalchemy import select
from starlette.testclient import TestClient

from server.main import bind
from server.web.middleware import MAX_BODY_BYTES, MAX_RANKING_BYTES, MAX_UPLOAD_BYTES
from server.web.security import MaskToken, address_with_token, load_secrets
from tests.server.clients import build_frontend, signed_in
from testsupport.live import LiveServer
from testsupport.visitors import cookie_of
from testsupport.workplace import Workplace, make_workplace
from tril.errors import Unavailable
from tril.settings import Settings
from tril.store.models import CredentialRow, now


@pytest.fixture(scope="module")
def workplace(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Workplace]:
    made = make_workplace(tmp_path_factory.mktemp("security") / "data")
    yield made
    made.database.close()


@pytest.fixture(scope="module")
def client(workplace: Workplace) -> Iterator[TestClient]:
    with signed_in(workplace, build_frontend(workplace.settings.data.parent)) as client:
        yield client


@pytest.fixture
def stranger(client: TestClient) -> TestClient:
    """Return a client without cookie."""
    return TestClient(client.app, base_url=str(client.base_url))


def test_without_cookie_the_api_answers_401_except_for_health(stranger: TestClient) -> None:
    assert stranger.get("/api/health").json() == {"status": "ok"}
    for path in ("/api/player", "/api/behaviours", "/api/events", "/api/nothing", "/api"):
        answer = stranger.get(path)
        assert answer.status_code == 401
        assert "printed" in answer.json()["detail"]
    assert stranger.post("/api/games", json={"behaviour_id": 1}).status_code == 401


def test_the_token_is_exchanged_for_a_cookie_that_lets_in(
    stranger: TestClient, workplace: Workplace
) -> None:
    address = address_with_token(workplace.settings, str(stranger.base_url))
    answer = stranger.get(address, follow_redirects=False)
    assert answer.status_code == 303
    assert answer.headers["location"] == "/"
    cookie = answer.headers["set-cookie"].lower()
    assert "httponly" in cookie
    assert "samesite=strict" in cookie
    token = load_secrets(workplace.settings.token_file).token
    assert token.lower() not in cookie
    assert stranger.get("/api/player").status_code == 200
    assert "Tril" in stranger.get("/").text


def test_the_key_may_be_typed_or_pasted_with_its_address(
    stranger: TestClient, workplace: Workplace
) -> None:
    asked = stranger.get("/runs/1").text
    assert '<input id="key" name="token"' in asked
    assert "tril address" in asked
    address = address_with_token(workplace.settings, str(stranger.base_url))
    for typed in (address, f" {load_secrets(workplace.settings.token_file).token} "):
        answer = stranger.get("/", params={"token": typed}, follow_redirects=False)
        assert answer.status_code == 303
    wrong = stranger.get("/", params={"token": "http://tril/?token=wrong"})
    assert wrong.status_code == 401
    assert "tril address" in wrong.text


@pytest.mark.parametrize("token", ["", "wrong", "é", "a" * 5000])
def test_a_wrong_token_gets_no_cookie(stranger: TestClient, token: str) -> None:
    answer = stranger.get("/", params={"token": token}, follow_redirects=False)
    assert answer.status_code == 401
    assert "set-cookie" not in answer.headers


def test_a_page_without_cookie_says_to_open_the_printed_address(stranger: TestClient) -> None:
    answer = stranger.get("/runs/1")
    assert answer.status_code == 401
    assert "Open the address that Tril printed" in answer.text
    assert "refresh" not in answer.text
    # Browsers keep the strict cookie back when another site's link leads here.
    from_link = stranger.get("/runs/1", headers={"Sec-Fetch-Site": "cross-site"})
    assert 'content="0; url=/runs/1"' in from_link.text


@pytest.mark.parametrize("path", ["//evil.example/", "/%5Cevil.example/", "/%22%3E%3Cscript%3E"])
def test_the_page_that_loads_itself_again_leads_nowhere_else(
    stranger: TestClient, path: str
) -> None:
    url = f"{stranger.base_url}".rstrip("/") + path
    answer = stranger.get(url, headers={"Sec-Fetch-Site": "cross-site"})
    (target,) = re.findall(r"url=([^\"]*)\"", answer.text)
    assert re.match(r"/[^/\\]", target)
    assert re.findall("<script[^>]*>", answer.text) == ['<script src="/theme.js">']


@pytest.mark.parametrize("forge", ["", "x", "1.2", "{secret}.{zeros}", "x{secret}.{signature}"])
def test_a_forged_cookie_is_refused(stranger: TestClient, workplace: Workplace, forge: str) -> None:
    name, cookie = cookie_of(workplace.settings)
    secret, _, signature = cookie.partition(".")
    forged = forge.format(secret=secret, signature=signature, zeros="0" * 32)
    stranger.cookies.set(name, forged)
    assert stranger.get("/api/player").status_code == 401


def test_a_cookie_grows_old(stranger: TestClient, workplace: Workplace) -> None:
    stranger.cookies.set(*cookie_of(workplace.settings))
    assert stranger.get("/api/player").status_code == 200
    name, cookie = cookie_of(workplace.settings)
    with workplace.database.writing() as session:
        newest = session.scalars(select(CredentialRow).order_by(CredentialRow.id.desc())).first()
        assert newest is not None
        newest.created_at = now() - timedelta(days=181)
    stranger.cookies.clear()
    stranger.cookies.set(name, cookie)
    assert stranger.get("/api/player").status_code == 401


def test_secrets_are_private_survive_a_restart_and_are_made_once(tmp_path: Path) -> None:
    path = tmp_path / "secrets.json"
    barrier = threading.Barrier(8)

    def load(_: int) -> str:
        barrier.wait()
        return load_secrets(path).token

    with ThreadPoolExecutor(8) as threads:
        tokens = set(threads.map(load, range(8)))
    assert len(tokens) == 1
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    assert load_secrets(path).token in tokens
    assert next(iter(tokens)) not in repr(load_secrets(path))
    assert [entry.name for entry in tmp_path.iterdir()] == ["secrets.json"]


def test_unreadable_secrets_say_what_to_do(tmp_path: Path) -> None:
    path = tmp_path / "secrets.json"
    path.write_text(json.dumps({"token": "abc"}))
    with pytest.raises(Unavailable, match="Delete the file"):
        load_secrets(path)


@pytest.mark.parametrize(
    ("host", "status"),
    [
        ("127.0.0.1:8000", 200),
        ("localhost:8000", 200),
        ("LOCALHOST", 200),
        ("[::1]:8000", 200),
        ("evil.example", 403),
        ("127.0.0.1.evil.example", 403),
        ("evil@127.0.0.1", 403),
        ("127.0.0.1:notaport", 403),
        ("", 403),
    ],
)
def test_only_our_own_host_names_are_answered(client: TestClient, host: str, status: int) -> None:
    answer = client.get("/api/health", headers={"Host": host})
    assert answer.status_code == status


def test_further_host_names_are_answered_where_they_are_allowed(workplace: Workplace) -> None:
    settings = workplace.settings.model_copy(update={"allowed_hosts": "Lab.Example, other"})
    assert {"lab.example", "other", "localhost"} <= settings.host_names


@pytest.mark.parametrize(
    "origin",
    ["http://evil.example", "http://localhost:9", "https://127.0.0.1", "null", "file://", "x"],
)
@pytest.mark.parametrize("method", ["GET", "POST"])
def test_requests_from_foreign_pages_are_refused(
    client: TestClient, origin: str, method: str
) -> None:
    answer = client.request(method, "/api/behaviours", headers={"Origin": origin})
    assert answer.status_code == 403
    assert "detail" in answer.json()


def test_requests_from_our_own_page_are_answered(client: TestClient) -> None:
    ours = {"Origin": str(client.base_url).rstrip("/"), "Sec-Fetch-Site": "same-origin"}
    assert client.get("/api/behaviours", headers=ours).status_code == 200
    for site in ("cross-site", "same-site"):
        assert client.get("/api/behaviours", headers={"Sec-Fetch-Site": site}).status_code == 403


def test_every_answer_carries_security_headers(client: TestClient) -> None:
    for path in ("/", "/api/player", "/api/nothing", "/assets/index-abc123.js"):
        headers = client.get(path).headers
        assert headers["x-content-type-options"] == "nosniff"
        assert "frame-ancestors 'none'" in headers["content-security-policy"]
        assert "script-src 'self';" in headers["content-security-policy"]
    assert client.get("/api/player").headers["cache-control"] == "no-store"


def test_an_unexpected_error_is_a_problem_with_security_headers(
    client: TestClient, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_arguments: object) -> None:
        raise RuntimeError("as it happens")

    monkeypatch.setattr("server.api.health.Health", fail)
    careless = TestClient(client.app, base_url=str(client.base_url), raise_server_exceptions=False)
    answer = careless.get("/api/health")
    assert answer.status_code == 500
    assert "unexpected error" in answer.json()["detail"]
    assert "frame-ancestors 'none'" in answer.headers["content-security-policy"]
    assert answer.headers["cache-control"] == "no-store"


@pytest.mark.parametrize(
    ("path", "limit"),
    [
        ("/api/behaviours", MAX_BODY_BYTES),
        ("/api/behaviours/1/ranking", MAX_RANKING_BYTES),
        ("/api/behaviours/1/recordings/import", MAX_UPLOAD_BYTES),
    ],
)
def test_bodies_are_bounded(live: LiveServer, path: str, limit: int) -> None:
    json_type = {"Content-Type": "application/json"}
    answer = live.http.post(path, content=b" " * (limit + 1), headers=json_type)
    assert answer.status_code == 413
    assert "too large" in answer.json()["detail"]
    assert live.http.post(path, content=b" " * limit, headers=json_type).status_code != 413


@pytest.mark.parametrize(
    "path",
    [
        "/../secret.txt",
        "/..%2fsecret.txt",
        "/%2e%2e/secret.txt",
        "/assets/../../secret.txt",
        "/assets/..%2f..%2fsecret.txt",
        "/assets/%2e%2e%2f%2e%2e%2fsecret.txt",
        "/....//secret.txt",
        "//etc/passwd",
        "/%2fetc%2fpasswd",
        "/assets/%5c..%5csecret.txt",
        "/api/artifacts/..%2f..%2fsecrets.json",
        "/api/artifacts/../../secrets.json",
        "/api/recordings/1/..%2f..%2f..%2fsecrets.json",
        "/secrets.json",
        "/index.html%00.png",
    ],
)
def test_no_path_reaches_the_file_system(
    client: TestClient, path: str, workplace: Workplace
) -> None:
    secret = json.loads(workplace.settings.token_file.read_text())["token"]
    answer = client.get(path, follow_redirects=True)
    assert secret not in answer.text
    assert "not yours" not in answer.text
    assert "root:" not in answer.text


def test_the_token_is_masked_in_logs(caplog: pytest.LogCaptureFixture) -> None:
    logger = logging.getLogger("uvicorn.access")
    mask = MaskToken()
    logger.addFilter(mask)
    try:
        with caplog.at_level(logging.INFO, "uvicorn.access"):
            logger.info('%s - "%s %s HTTP/%s" %d', "1", "GET", "/?token=abc-DEF_1&x=1", "1.1", 303)
            logger.info("plain /?token=abc-DEF_1")
    finally:
        logger.removeFilter(mask)
    assert "abc-DEF_1" not in caplog.text
    assert "token=***&x=1" in caplog.text


def test_a_taken_port_says_what_to_do(live: LiveServer) -> None:
    with pytest.raises(Unavailable, match="TRIL_PORT"):
        bind(Settings(data=live.settings.data, port=live.settings.port))
