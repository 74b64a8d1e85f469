"""A certificate for 127.0.0.1 that nobody but its maker trusts."""

from __future__ import annotations

import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

DAYS = 2


@dataclass(frozen=True)
class Certificate:
    """A certificate and its key, as PEM files."""

    path: Path
    key: Path


def has_openssl() -> bool:
    """Return whether certificates can be made here."""
    return shutil.which("openssl") is not None


def make_certificate(folder: Path, *names: str) -> Certificate:
    """Make a certificate for 127.0.0.1 and further host names with the openssl program."""
    made = Certificate(folder / "certificate.pem", folder / "key.pem")
    alternatives = ",".join(["IP:127.0.0.1", *(f"DNS:{name}" for name in names)])
    subprocess.run(
        [
            *("openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256"),
            *("-nodes", "-days", str(DAYS), "-subj", "/CN=Tril's tests"),
            *("-addext", f"subjectAltName={alternatives}"),
            *("-keyout", str(made.key), "-out", str(made.path)),
        ],
        check=True,
        capture_output=True,
    )
    return made
