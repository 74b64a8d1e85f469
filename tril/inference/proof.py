"""Mutual proof of a shared key, by challenge and response, before anything else is sent over TCP.

The process begins with a greeting and a nonce. The client answers with a nonce of its own and an
HMAC of both, the process with another HMAC of both, or zeros if it does not know the client's. The
key itself is never sent. Under TLS the HMACs also cover the hash of the process's certificate as
either end knows it (tls-server-end-point, RFC 5929), so that nobody who lacks the key can stand
between them, whoever signed the certificate.
"""

from __future__ import annotations

import hmac
import re
import secrets
import ssl
from hashlib import sha256
from pathlib import Path

GREETING = b"TRIL-INFERENCE-1"
NONCE_BYTES = 32
PROOF_BYTES = 32
GREETING_BYTES = len(GREETING) + NONCE_BYTES
RESPONSE_BYTES = NONCE_BYTES + PROOF_BYTES
REFUSAL = bytes(PROOF_BYTES)


class NotProven(Exception):
    """The other end is not what it should be; the text says what it lacks."""


class Challenge:
    """The inference process's side of a proof.

    Args:
        key: The shared key.
        certificate_hash: The hash of its certificate; empty without TLS.

    Attributes:
        greeting: Greeting that the process sends first.
    """

    def __init__(self, key: bytes, certificate_hash: bytes) -> None:
        self._key = key
        self._certificate_hash = certificate_hash
        self._nonce = secrets.token_bytes(NONCE_BYTES)
        self.greeting = GREETING + self._nonce

    def answer(self, response: bytes | bytearray) -> bytes:
        """Check a client's response of RESPONSE_BYTES and return the answer to it.

        Raises:
            NotProven: The client has another key.
        """
        message = self._nonce + response[:NONCE_BYTES] + self._certificate_hash
        if not hmac.compare_digest(response[NONCE_BYTES:], _proof(self._key, b"client", message)):
            raise NotProven("It has another key.")
        return _proof(self._key, b"process", message)


class Response:
    """The client's side of a proof.

    Args:
        key: The shared key.
        greeting: Greeting of the process, GREETING_BYTES.
        certificate_hash: The hash of the certificate that it showed; empty without TLS.

    Attributes:
        message: Message that the client sends.

    Raises:
        NotProven: The other end is no inference process.
    """

    def __init__(self, key: bytes, greeting: bytes | bytearray, certificate_hash: bytes) -> None:
        if not greeting.startswith(GREETING):
            raise NotProven("is no inference process of this version")
        nonce = secrets.token_bytes(NONCE_BYTES)
        signed = bytes(greeting[len(GREETING) :]) + nonce + certificate_hash
        self.message = nonce + _proof(key, b"client", signed)
        self._expected = _proof(key, b"process", signed)

    def check(self, answer: bytes | bytearray) -> None:
        """Raise NotProven unless the process's answer of PROOF_BYTES shows that it has the key."""
        if not hmac.compare_digest(answer, self._expected):
            raise NotProven("has another key")


def certificate_hash(certificate: Path) -> bytes:
    """Return the hash of the first certificate in a PEM file, which is the one that is shown."""
    text = certificate.read_text(encoding="utf-8", errors="replace")
    match = re.search(r"-----BEGIN CERTIFICATE-----.*?-----END CERTIFICATE-----", text, re.DOTALL)
    assert match is not None, "a file without certificates is refused before"
    return sha256(ssl.PEM_cert_to_DER_cert(match[0])).digest()


def shown_certificate_hash(connection: ssl.SSLSocket | ssl.SSLObject) -> bytes:
    """Return the hash of the certificate that the other end of a connection showed."""
    certificate = connection.getpeercert(binary_form=True)
    assert certificate is not None, "TLS servers show a certificate"
    return sha256(certificate).digest()


def _proof(key: bytes, side: bytes, message: bytes) -> bytes:
    return hmac.digest(key, b"tril inference " + side + b"\0" + message, "sha256")
