"""The versions that a run was made with."""

from __future__ import annotations

import platform
from functools import cache
from importlib.metadata import version

from trainer.reporting.digests import inference_digest
from tril import __version__
from tril.games.space_invaders.memory import rom_md5

PACKAGES = ("torch", "stable-baselines3", "gymnasium", "ale-py", "numpy")


@cache
def versions() -> dict[str, str]:
    """Return the versions on which the result of a training depends, by name."""
    return {
        "python": platform.python_version(),
        **{package: version(package) for package in PACKAGES},
        "tril": __version__,
        "reward_inference": inference_digest(),
        "rom_md5": rom_md5(),
        "platform": platform.platform(),
    }
