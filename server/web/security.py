"""Who may talk to the server: one token, a signed cookie, and requests from this page only."""

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
    """What only this installation knows; kept in a file that only its owner can read.

    Attributes:
        token: What the printed address carries.
        cookie_key: Key with which cookies are signed.
    """

    token: str
    cookie_key: bytes

    def __repr__(self) -> str:
        return "Secrets(…)"


def load_secrets(path: Path) -> Secrets:
    """Read the secrets, making them the first time; the same ones come back ever after.

    Raises:
        Unavailable: The file is there but can't be read.
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
        # Unlike a rename, a link fails when the name is taken: whoever came first has won.
        os.link(ready, path)
    except FileExistsError:
        pass
    finally:
        ready.unlink(missing_ok=True)


class Access:
    """Checks tokens and cookies.

    Args:
        settings: Say where the secrets are and which port names the cookie: cookies of one host
            are shared by all its ports, and two Trils may run side by side.
    """

    def __init__(self, settings: Settings) -> None:
        self._secrets = load_secrets(settings.token_file)
        self.cookie_name = cookie_name(settings)

    def is_token(self, token: str) -> bool:
        """Whether this is the installation's token; takes the same time for any wrong one."""
        return hmac.compare_digest(token.encode(), self._secrets.token.encode())

    def new_cookie(self) -> str:
        """Return a cookie for a browser that showed the token."""
        issued = str(int(time.time()))
        return f"{issued}.{self._signature(issued)}"

    def is_cookie(self, cookie: str) -> bool:
        """Whether a cookie was issued here and is still good."""
        issued, _, signature = cookie.partition(".")
        if not hmac.compare_digest(signature.encode(), self._signature(issued).encode()):
            return False
        age_s = time.time() - int(issued)
        return -_CLOCK_SLACK_S <= age_s <= COOKIE_LIFETIME_S

    def _signature(self, issued: str) -> str:
        message = f"tril cookie {_VERSION} {issued}".encode()
        return hmac.new(self._secrets.cookie_key, message, hashlib.sha256).hexdigest()


def cookie_name(settings: Settings) -> str:
    """Return the name of the cookie of a server."""
    return f"tril_{settings.port}"


def address_with_token(settings: Settings, url: str) -> str:
    """Return the address that lets a browser in: a server's URL with the token in it."""
    return f"{url.rstrip('/')}/?token={quote(load_secrets(settings.token_file).token)}"


_TOKEN = re.compile(r"(token=)[^&\s\"']+", re.IGNORECASE)


class MaskToken(logging.Filter):
    """Keeps the token out of a log, whatever logs an address that carries it."""

    def filter(self, record: logging.LogRecord) -> bool:
        """Mask the token in a record's message and its arguments."""
        record.msg = self._masked(record.msg)
        if isinstance(record.args, tuple):
            record.args = tuple(self._masked(value) for value in record.args)
        return True

    @staticmethod
    def _masked(value: Any) -> Any:
        return _TOKEN.sub(r"\1***", value) if isinstance(value, str) else value
