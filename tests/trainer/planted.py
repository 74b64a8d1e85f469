"""Made-up trajectories of which is known which states are better."""

import numpy as np

from tril.recording import Trajectory


def planted_trajectory(rng: np.random.Generator, quality: int, n_steps: int) -> Trajectory:
    """Return a noisy trajectory whose lower half grows brighter, the faster the better it is.

    Args:
        rng: where the noise comes from.
        quality: 0 stays dark; 5 brightens most.
        n_steps: its length.
    """
    observations = rng.integers(0, 60, (n_steps + 1, 4, 84, 84), dtype=np.uint8)
    brightness = (np.linspace(0, 30 * quality, n_steps + 1)).astype(np.uint8)
    observations[:, :, 42:, :] += brightness[:, None, None, None]
    return Trajectory(observations, rng.integers(0, 6, n_steps))


def planted_trajectories(n_steps: int = 40) -> list[Trajectory]:
    """Return six trajectories, the best first; one of them is half as long as the others."""
    rng = np.random.default_rng(3)
    return [
        planted_trajectory(rng, quality, n_steps // 2 if quality == 2 else n_steps)
        for quality in (5, 4, 3, 2, 1, 0)
    ]
