"""The codec and the messages, without sockets."""

from __future__ import annotations

import base64
import hashlib
import json
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from server.play.wire.codec import EncodedFrame, FrameEncoder
from server.play.wire.protocol import (
    AckMessage,
    BadMessage,
    Command,
    FrameMessage,
    InputMessage,
    SetSpeed,
    frame_bytes,
    parse_client,
)
from tests.server.play.protocol_vectors import PATH, vectors
from testsupport.protocol import (
    FrameDecoder,
    UnreadableFrame,
    client_bytes,
    parse_frame,
    parse_server,
    read_frames_file,
)
from tril.games.space_invaders.memory import SCREEN_SHAPE

VECTORS = json.loads(PATH.read_text())


@given(st.integers(0, 2**32 - 1), st.lists(st.booleans(), min_size=1, max_size=8))
def test_whatever_is_left_out_before_the_encoder_the_decoder_follows(
    seed: int, keys: list[bool]
) -> None:
    rng = np.random.default_rng(seed)
    encoder, decoder = FrameEncoder(SCREEN_SHAPE), FrameDecoder(SCREEN_SHAPE)
    screen = rng.integers(0, 256, SCREEN_SHAPE, np.uint8)
    for index, key in enumerate(keys):
        screen = screen.copy()
        screen[rng.integers(210), :] = rng.integers(256)
        encoded = encoder.encode(screen, key)
        assert encoded.is_key == (key or index == 0)
        np.testing.assert_array_equal(decoder.decode(encoded), screen)


def test_encoding_copies_the_screen() -> None:
    encoder, decoder = FrameEncoder(SCREEN_SHAPE), FrameDecoder(SCREEN_SHAPE)
    screen = np.zeros(SCREEN_SHAPE, np.uint8)
    decoder.decode(encoder.encode(screen))
    screen[5, 5] = 7
    assert decoder.decode(encoder.encode(screen))[5, 5] == 7


@pytest.mark.parametrize("payload", [b"", b"nonsense", b"x" * 50_000])
def test_bytes_that_are_no_frame_are_refused(payload: bytes) -> None:
    with pytest.raises(UnreadableFrame):
        FrameDecoder(SCREEN_SHAPE).decode(EncodedFrame(True, payload))


def test_a_frame_that_unpacks_to_too_much_is_refused() -> None:
    import zlib

    with pytest.raises(UnreadableFrame):
        FrameDecoder(SCREEN_SHAPE).decode(
            EncodedFrame(True, zlib.compress(bytes((SCREEN_SHAPE[0] * SCREEN_SHAPE[1]) + 1)))
        )


def test_a_stream_can_not_begin_with_a_delta() -> None:
    encoder = FrameEncoder(SCREEN_SHAPE)
    screen = np.zeros(SCREEN_SHAPE, np.uint8)
    encoder.encode(screen)
    with pytest.raises(UnreadableFrame, match="key frame"):
        FrameDecoder(SCREEN_SHAPE).decode(encoder.encode(screen))


@given(
    st.builds(
        FrameMessage,
        sequence=st.integers(1, 2**32 - 1),
        frame=st.integers(0, 1200),
        input_sequence=st.integers(0, 2**32 - 1),
        encoded=st.builds(EncodedFrame, st.booleans(), st.just(b"payload")),
        marks=st.binary(min_size=2, max_size=2),
        has_counted=st.booleans(),
    )
)
def test_frame_messages_survive_the_journey(message: FrameMessage) -> None:
    assert parse_frame(frame_bytes(message)) == message


@given(st.integers(0, 2**24 - 1), st.integers(0, 2**32 - 1))
def test_client_messages_survive_the_journey(keys: int, sequence: int) -> None:
    for message in (InputMessage(keys, sequence), AckMessage(sequence)):
        assert parse_client(client_bytes(message)) == message


@given(st.floats(0, 1e9))
def test_latencies_travel_in_tenths_of_a_millisecond(latency_ms: float) -> None:
    message = parse_client(client_bytes(AckMessage(7, latency_ms)))
    assert isinstance(message, AckMessage)
    assert message.latency_ms is not None
    assert message.latency_ms == pytest.approx(min(max(0.1, latency_ms), 6553.5), abs=0.0501)


@pytest.mark.parametrize("kind", ["ready", "stop", "pause", "go_on", "step", "rewind", "release"])
def test_commands_are_understood(kind: str) -> None:
    assert parse_client(json.dumps({"type": kind})) == Command(type=kind)  # type: ignore[arg-type]


@pytest.mark.parametrize("percent", [25, 60, 100])
def test_a_speed_is_understood(percent: int) -> None:
    assert parse_client(f'{{"type": "speed", "percent": {percent}}}') == SetSpeed(percent=percent)


@pytest.mark.parametrize("percent", ["24", "101", "50.5", "true", '"50"', "null", "1e400"])
def test_speeds_out_of_reach_are_refused(percent: str) -> None:
    with pytest.raises(BadMessage):
        parse_client(f'{{"type": "speed", "percent": {percent}}}')


@given(
    st.one_of(
        st.binary(max_size=400).filter(lambda data: len(data) != 8 or data[0] not in {1, 2}),
        st.text(max_size=400),
    )
)
def test_anything_else_is_refused_with_a_reason(data: bytes | str) -> None:
    with pytest.raises(BadMessage, match=r"."):
        parse_client(data)


def _without_payload(frame: dict[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in frame.items() if name != "base64"}


def test_the_vectors_are_what_the_code_says() -> None:
    # Payloads are compared by what they decode to: another zlib packs them differently.
    current = vectors()
    assert VECTORS["server"] == current["server"]
    assert VECTORS["client"] == current["client"]
    assert VECTORS["palette"] == current["palette"]
    for stored, built in zip(VECTORS["frames"], current["frames"], strict=True):
        assert _without_payload(stored) == _without_payload(built)


def test_the_vectors_decode_to_the_screens_they_name() -> None:
    decoder = FrameDecoder(SCREEN_SHAPE)
    for vector in VECTORS["frames"]:
        message = parse_frame(base64.b64decode(vector["base64"]))
        assert (message.sequence, message.frame) == (vector["sequence"], vector["frame"])
        left, top = message.marks
        assert {"left": left - 96, "top": top} == vector["formation"]
        assert message.has_counted == vector["shot"]
        screen = decoder.decode(message.encoded)
        assert hashlib.sha256(screen.tobytes()).hexdigest() == vector["screen_sha256"]
    decoder = FrameDecoder(SCREEN_SHAPE)
    file = VECTORS["frames_file"]
    for number, frame in enumerate(read_frames_file(base64.b64decode(file["base64"]))):
        digest = hashlib.sha256(decoder.decode(frame).tobytes()).hexdigest()
        assert file["screen_sha256"].get(str(number), digest) == digest
    assert number == file["n_frames"]


def test_the_servers_messages_are_understood_as_they_were_said() -> None:
    for message in VECTORS["server"]:
        assert json.loads(parse_server(json.dumps(message)).to_json()) == message
    with pytest.raises(BadMessage):
        parse_server('{"type": "hello"}')
