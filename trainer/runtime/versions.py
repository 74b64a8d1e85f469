"""The versions that a run was made with."""

from __future__ import annotations

import platform
from importlib.metadata import version

from trainer.reporting.digests import inference_digest
from tril import __version__
from tril.games.base import Game

PACKAGES = ("torch", "stable-baselines3", "gymnasium", "ale-py", "numpy")


def versions(game: Game) -> dict[str, str]:
    """Return the versions on which the result of a training of a game depends, by name."""
    return {
        "python": platform.python_version(),
        **{package: version(package) for package in PACKAGES},
        "tril": __version__,
        "reward_inference": inference_digest(),
        "game": game.name,
        "game_version": game.version,
        "platform": platform.platform(),
    }
