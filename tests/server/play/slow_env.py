"""An environment that takes 50 ms a step."""

from __future__ import annotations

import time
from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt

STEP_S = 0.05
NAME = "gym:Slow-v0"
"""Known in this process alone; others cannot replay its games."""


class SlowEnv(gymnasium.Env[Any, Any]):
    """A light that goes round and whose colour is the last action."""

    metadata = {"render_modes": ["rgb_array"], "render_fps": 15}  # noqa: RUF012

    def __init__(self, render_mode: str | None = None) -> None:
        self.render_mode = render_mode
        self.action_space = gymnasium.spaces.Discrete(3)
        self.observation_space = gymnasium.spaces.Discrete(16)

    def get_action_meanings(self) -> list[str]:
        return ["NOOP", "LEFT", "RIGHT"]

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        super().reset(seed=seed)
        self._at, self._action = int(self.np_random.integers(16)), 0
        return self._at, {}

    def step(self, action: int) -> tuple[int, float, bool, bool, dict[str, Any]]:
        time.sleep(STEP_S)
        self._at, self._action = (self._at + 1) % 16, action
        return self._at, 0.0, False, False, {}

    def render(self) -> npt.NDArray[np.uint8]:
        picture = np.zeros((64, 64, 3), np.uint8)
        picture[4 * self._at : 4 * self._at + 4, :, self._action] = 255
        return picture


gymnasium.register("Slow-v0", entry_point=f"{__name__}:SlowEnv")
