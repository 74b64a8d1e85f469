"""A few seconds of any game, to show what it looks like."""

from __future__ import annotations

import numpy as np

from tril.games.base import Game
from tril.recording import Recording

SAMPLE_S = 4
LONGEST_HOLD = 16


def sample(game: Game) -> Recording:
    """Return a game of random actions, each held for a while; the same one at every call."""
    rng = np.random.default_rng(0)
    n_frames = SAMPLE_S * game.clock.frame_rate_hz
    actions = bytearray()
    while len(actions) < n_frames:
        action = int(rng.integers(game.controls.n_actions))
        actions += bytes([action]) * int(rng.integers(1, LONGEST_HOLD))
    return Recording(game, game.starts.training[0], bytes(actions[:n_frames]))
