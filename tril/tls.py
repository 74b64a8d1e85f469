"""The certificate with which a process serves TLS."""

from __future__ import annotations

import ssl

from tril.errors import Unavailable
from tril.settings import Settings


def tls_context(settings: Settings) -> ssl.SSLContext | None:
    """Return a context with the certificate and key that settings name; None if they name none.

    Raises:
        Unavailable: They can't be used.
    """
    if not settings.uses_tls:
        return None
    assert settings.tls_certificate is not None
    context = ssl.create_default_context(ssl.Purpose.CLIENT_AUTH)
    try:
        context.load_cert_chain(settings.tls_certificate, settings.tls_key, password="")
    except (OSError, ValueError) as error:
        raise Unavailable(
            f"The certificate {settings.tls_certificate} and its key {settings.tls_key} can't be "
            f"used: {error}. They have to be PEM files that belong together and that this user may "
            "read, the key without a password."
        ) from error
    return context
