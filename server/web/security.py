"""The secrets of an installation: the owner's key, and what signs cookies and keys."""

from __future__ import annotations

import hashlib
import hmac
import json
import logging
import os
import re
import secrets
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import quote

from tril.errors import Unavailable
from tril.files.artifact_store import write_whole
from tril.settings import Settings
from tril.store.access import invitations

_VERSION = 1


@dataclass(frozen=True)
class Secrets:
    """The secrets of this installation, kept in a file that only its owner can read.

    Attributes:
        token: The access token in the printed address.
        cookie_key: What signs the secrets in cookies, keys and links, so that made-up ones are
            refused without asking the database.
    """

    token: str
    cookie_key: bytes

    def signed(self, secret: str) -> str:
        """Return a secret as it is handed out."""
        message = f"tril {_VERSION} {secret}".encode()
        signature = hmac.new(self.cookie_key, message, hashlib.sha256).hexdigest()
        return f"{secret}.{signature[:32]}"

    def secret_in(self, handed_out: str) -> str | None:
        """Return the secret in something that was handed out here; None if it was made up."""
        secret, _, _ = handed_out.partition(".")
        expected = self.signed(secret)
        return secret if hmac.compare_digest(handed_out.encode(), expected.encode()) else None

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
        data = json.loads(path.read_text(encoding="utf-8"))
        secrets_of_file = Secrets(data["token"], bytes.fromhex(data["cookie_key"]))
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise Unavailable(
            f"The access token in {path} can't be read ({type(error).__name__}). Delete the file "
            "to get a new token; addresses printed earlier then stop working."
        ) from error
    if path.stat().st_mode & 0o077:
        path.chmod(0o600)
    return secrets_of_file


def is_token(path: Path, text: str) -> bool:
    """Whether this is the installation's token at this moment, compared in constant time."""
    # Read anew, since `tril address --new` replaces it while servers run.
    return hmac.compare_digest(text.encode(), load_secrets(path).token.encode())


def renew_token(path: Path) -> None:
    """Replace the access token, so that addresses printed earlier stop working."""
    cookie_key = load_secrets(path).cookie_key
    content = {"version": _VERSION, "token": _new_token(), "cookie_key": cookie_key.hex()}
    write_whole(path, json.dumps(content).encode(), mode=0o600)


def _new_token() -> str:
    return secrets.token_urlsafe(24)


def _make_secrets(path: Path) -> None:
    """Write new secrets unless another process does so first."""
    content = {
        "version": _VERSION,
        "token": _new_token(),
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


def cookie_name(settings: Settings) -> str:
    """Return the name of a server's cookie.

    The port is part of it, because the ports of a host share its cookies and two Trils may run
    side by side.
    """
    return f"tril_{settings.port}"


def address_with_token(settings: Settings, url: str) -> str:
    """Return a server's address with the access token, which signs a browser in."""
    return f"{url.rstrip('/')}/?token={quote(load_secrets(settings.token_file).token)}"


def invitation_link(settings: Settings, url: str, secret: str) -> str:
    """Return the link of an invitation."""
    signed = load_secrets(settings.token_file).signed(secret)
    return f"{url.rstrip('/')}{invitations.PATH}?invitation={signed}"


_TOKEN = re.compile(r"((?:token|invitation)=)[^&\s\"']+", re.IGNORECASE)


class MaskToken(logging.Filter):
    """Logging filter that masks the secrets in addresses."""

    def filter(self, record: logging.LogRecord) -> bool:
        """Mask the token in a record's message and its arguments."""
        record.msg = self._masked(record.msg)
        if isinstance(record.args, tuple):
            record.args = tuple(self._masked(value) for value in record.args)
        return True

    @staticmethod
    def _masked(value: Any) -> Any:
        return _TOKEN.sub(r"\1***", value) if isinstance(value, str) else value
