"""Answers are compressed where that makes them smaller, and nowhere else."""

from __future__ import annotations

import gzip
from pathlib import Path

import pytest
from starlette.applications import Starlette
from starlette.middleware import Middleware
from starlette.requests import Request
from starlette.responses import JSONResponse, PlainTextResponse, Response, StreamingResponse
from starlette.routing import Route
from starlette.testclient import TestClient

from server.web.compression import MIN_BYTES, Compression
from tests.server.clients import signed_in
from testsupport.workplace import Workplace

LONG = "a" * MIN_BYTES


async def _json(_request: Request) -> Response:
    return JSONResponse({"text": LONG})


async def _short(_request: Request) -> Response:
    return JSONResponse({"text": "a"})


async def _events(_request: Request) -> Response:
    return StreamingResponse(iter([LONG, LONG]), media_type="text/event-stream")


async def _lines(_request: Request) -> Response:
    return StreamingResponse(iter([LONG, LONG]), media_type="application/x-ndjson")


async def _frames(_request: Request) -> Response:
    return Response(LONG, media_type="application/octet-stream")


async def _empty(_request: Request) -> Response:
    return PlainTextResponse("", 204)


ROUTES = [_json, _short, _events, _lines, _frames, _empty]


@pytest.fixture
def client() -> TestClient:
    routes = [Route(f"/{one.__name__.strip('_')}", one) for one in ROUTES]
    return TestClient(Starlette(routes=routes, middleware=[Middleware(Compression)]))


def test_long_text_is_compressed_for_those_who_take_it(client: TestClient) -> None:
    answer = client.get("/json", headers={"Accept-Encoding": "br, gzip"})
    assert answer.headers["content-encoding"] == "gzip"
    assert answer.headers["vary"] == "Accept-Encoding"
    assert int(answer.headers["content-length"]) < 200
    assert answer.json() == {"text": LONG}
    plain = client.get("/json", headers={"Accept-Encoding": "identity"})
    assert "content-encoding" not in plain.headers
    assert plain.json() == {"text": LONG}


@pytest.mark.parametrize("path", ["/short", "/events", "/lines", "/frames", "/empty"])
def test_streams_pictures_and_short_answers_are_left_alone(client: TestClient, path: str) -> None:
    with client.stream("GET", path, headers={"Accept-Encoding": "gzip"}) as answer:
        assert "content-encoding" not in answer.headers
        answer.read()


def test_files_of_the_page_are_compressed_and_new_after_a_build(
    workplace: Workplace, tmp_path: Path
) -> None:
    (tmp_path / "assets").mkdir()
    script = tmp_path / "assets" / "index-abc.js"
    script.write_text("//" + LONG)
    (tmp_path / "index.html").write_text("<!doctype html><title>Tril</title>")
    with signed_in(workplace, tmp_path) as client:
        with client.stream("GET", "/assets/index-abc.js") as answer:
            assert answer.headers["content-encoding"] == "gzip"
            assert answer.headers["cache-control"].endswith("immutable")
            assert gzip.decompress(b"".join(answer.iter_raw())).decode() == "//" + LONG
        whole = client.get("/assets/index-abc.js", headers={"Accept-Encoding": "identity"})
        assert "content-encoding" not in whole.headers
        assert client.get("/").headers["cache-control"] == "no-store"


@pytest.mark.parametrize(
    ("accepted", "coding"),
    [("gzip, deflate, br, zstd", "br"), ("gzip", "gzip"), ("br;q=0", None), ("identity", None)],
)
def test_scripts_that_the_build_compressed_are_sent_as_they_lie(
    workplace: Workplace, tmp_path: Path, accepted: str, coding: str | None
) -> None:
    (tmp_path / "assets").mkdir()
    script = tmp_path / "assets" / "index-abc.js"
    script.write_text("//" + LONG)
    script.with_name("index-abc.js.br").write_bytes(b"compressed")
    (tmp_path / "index.html").write_text("<!doctype html><title>Tril</title>")
    with signed_in(workplace, tmp_path) as client:
        headers = {"Accept-Encoding": accepted}
        with client.stream("GET", "/assets/index-abc.js", headers=headers) as answer:
            assert answer.headers.get("content-encoding") == coding
            assert answer.headers["vary"] == "Accept-Encoding"
            assert answer.headers["content-type"].startswith("text/javascript")
            assert answer.headers["cache-control"].endswith("immutable")
            body = b"".join(answer.iter_raw())
        assert (body == b"compressed") == (coding == "br")
        assert client.get("/assets/index-abc.js.br").status_code == 404
        with client.stream("GET", "/", headers=headers) as page:
            assert page.headers.get("content-encoding") != "br"
