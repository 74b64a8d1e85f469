"""The versions that a run was made with."""

from __future__ import annotations

import hashlib
import platform
from functools import cache
from importlib.metadata import version
from pathlib import Path

from tril import __version__
from tril.analysis import wanted_aliens
from tril.game.space_invaders import rom_md5

PACKAGES = ("torch", "stable-baselines3", "gymnasium", "ale-py", "numpy")


@cache
def versions() -> dict[str, str]:
    """Return the versions on which the result of a training depends, by name."""
    return {
        "python": platform.python_version(),
        **{package: version(package) for package in PACKAGES},
        "tril": __version__,
        "inference": inference_digest(),
        "rom_md5": rom_md5(),
        "platform": platform.platform(),
    }


def inference_digest() -> str:
    """Return eight hexadecimal digits that change with how wanted aliens are inferred.

    No recipe has the prior among its values, so that releases and the states between them would be
    told apart by nothing else.
    """
    source = Path(wanted_aliens.__file__).read_bytes()
    return hashlib.blake2b(source, digest_size=4).hexdigest()
