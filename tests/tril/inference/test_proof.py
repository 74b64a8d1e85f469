"""The proof of a shared key: who has it is let in, who has not learns nothing of it."""

from __future__ import annotations

import pytest

from tril.inference.proof import (
    GREETING_BYTES,
    NONCE_BYTES,
    PROOF_BYTES,
    REFUSAL,
    RESPONSE_BYTES,
    Challenge,
    NotProven,
    Response,
)

KEY = b"k" * 32
CERTIFICATE = b"c" * 32


def test_both_ends_with_the_key_prove_it() -> None:
    challenge = Challenge(KEY, CERTIFICATE)
    assert len(challenge.greeting) == GREETING_BYTES
    response = Response(KEY, challenge.greeting, CERTIFICATE)
    assert len(response.message) == RESPONSE_BYTES
    answer = challenge.answer(response.message)
    assert len(answer) == PROOF_BYTES
    response.check(answer)


@pytest.mark.parametrize("other", [(b"x" * 32, CERTIFICATE), (KEY, b"d" * 32), (KEY, b"")])
def test_another_key_or_certificate_proves_nothing_to_either_end(
    other: tuple[bytes, bytes],
) -> None:
    challenge = Challenge(KEY, CERTIFICATE)
    response = Response(other[0], challenge.greeting, other[1])
    with pytest.raises(NotProven):
        challenge.answer(response.message)
    # One that pretends to be the process.
    mine = Response(KEY, Challenge(*other).greeting, CERTIFICATE)
    pretender = Challenge(*other)
    nonce = mine.message[:NONCE_BYTES]
    forged = Response(other[0], pretender.greeting, other[1]).message[NONCE_BYTES:]
    for answer in (REFUSAL, nonce, forged, mine.message[NONCE_BYTES:]):
        with pytest.raises(NotProven):
            mine.check(answer)


def test_a_response_is_good_for_one_challenge_alone() -> None:
    first, second = Challenge(KEY, b""), Challenge(KEY, b"")
    said = Response(KEY, first.greeting, b"").message
    first.answer(said)
    with pytest.raises(NotProven):
        second.answer(said)


def test_the_key_is_never_sent() -> None:
    challenge = Challenge(KEY, b"")
    response = Response(KEY, challenge.greeting, b"")
    sent = challenge.greeting + response.message + challenge.answer(response.message)
    assert KEY not in sent


def test_what_does_not_greet_is_no_inference_process() -> None:
    with pytest.raises(NotProven, match="no inference process"):
        Response(KEY, b"HTTP/1.1 400 Bad Request".ljust(GREETING_BYTES), b"")
