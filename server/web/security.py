"""Authentication: one access token, exchanged for a signed cookie."""

from __future__ import annotations

import hashlib
import hmac
import json
import logging
import os
import re
import secrets
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import quote

from tril.errors import Unavailable
from tril.files.artifact_store import write_whole
from tril.settings import Settings

COOKIE_LIFETIME_S = 180 * 24 * 3600
_VERSION = 1
_CLOCK_SLACK_S = 300


@dataclass(frozen=True)
class Secrets:
    """The secrets of this installation, kept in a file that only its owner can read.

    Attributes:
        token: The access token in the printed address.
        cookie_key: The key that signs cookies.
    """

    token: str
    cookie_key: bytes

    def __repr__(self) -> str:
        return "Secrets(…)"


def load_secrets(path: Path) -> Secrets:
    """Read the secrets, or make them the first time.

    Raises:
        Unavailable: The file exists but can't be read.
    """
    if not path.exists():
        _make_secrets(path)
    try:
        data = json.loads(path.read_text())
        found = Secrets(data["token"], bytes.fromhex(data["cookie_key"]))
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise Unavailable(
            f"The access token in {path} can't be read ({type(error).__name__}). Delete the file "
            "to get a new token; addresses printed earlier then stop working."
        ) from error
    if path.stat().st_mode & 0o077:
        path.chmod(0o600)
    return found


def _make_secrets(path: Path) -> None:
    """Write new secrets unless another process does so first."""
    content = {
        "version": _VERSION,
        "token": secrets.token_urlsafe(24),
        "cookie_key": secrets.token_hex(32),
    }
    ready = path.with_name(f".{path.name}.{secrets.token_hex(8)}")
    try:
        write_whole(ready, json.dumps(content).encode(), mode=0o600)
        # Unlike a rename, a link fails if the name is taken: the first process wins.
        os.link(ready, path)
    except FileExistsError:
        pass
    finally:
        ready.unlink(missing_ok=True)


class Access:
    """Checks tokens and cookies.

    Args:
        settings: The file of the secrets and the port. The port is part of the cookie's name,
            because the ports of a host share its cookies and two Trils may run side by side.
    """

    def __init__(self, settings: Settings) -> None:
        self._secrets = load_secrets(settings.token_file)
        self.cookie_name = cookie_name(settings)

    def is_token(self, token: str) -> bool:
        """Whether this is the installation's token, compared in constant time."""
        return hmac.compare_digest(token.encode(), self._secrets.token.encode())

    def new_cookie(self) -> str:
        """Return a cookie for a browser that has shown the token."""
        issued = str(int(time.time()))
        return f"{issued}.{self._signature(issued)}"

    def is_cookie(self, cookie: str) -> bool:
        """Whether a cookie was issued here and has not expired."""
        issued, _, signature = cookie.partition(".")
        if not hmac.compare_digest(signature.encode(), self._signature(issued).encode()):
            return False
        age_s = time.time() - int(issued)
        return -_CLOCK_SLACK_S <= age_s <= COOKIE_LIFETIME_S

    def _signature(self, issued: str) -> str:
        message = f"tril cookie {_VERSION} {issued}".encode()
        return hmac.new(self._secrets.cookie_key, message, hashlib.sha256).hexdigest()


def cookie_name(settings: Settings) -> str:
    """Return the name of a server's cookie."""
    return f"tril_{settings.port}"


def address_with_token(settings: Settings, url: str) -> str:
    """Return a server's address with the access token, which signs a browser in."""
    return f"{url.rstrip('/')}/?token={quote(load_secrets(settings.token_file).token)}"


_TOKEN = re.compile(r"(token=)[^&\s\"']+", re.IGNORECASE)


class MaskToken(logging.Filter):
    """Logging filter that masks the access token in addresses."""

    def filter(self, record: logging.LogRecord) -> bool:
        """Mask the token in a record's message and its arguments."""
        record.msg = self._masked(record.msg)
        if isinstance(record.args, tuple):
            record.args = tuple(self._masked(value) for value in record.args)
        return True

    @staticmethod
    def _masked(value: Any) -> Any:
        return _TOKEN.sub(r"\1***", value) if isinstance(value, str) else value
