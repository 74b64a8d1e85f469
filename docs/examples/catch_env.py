"""Catch: fruit falls, and a basket at the bottom catches it. A Gymnasium environment."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt

COLUMNS, ROWS, FRUITS = 7, 12, 10
CELL_PX = 8
FRUIT, BASKET = (230, 80, 60), (90, 160, 240)


class CatchEnv(gymnasium.Env[npt.NDArray[np.int64], int]):
    """The reward is 1 for each fruit caught; the game is over when one is missed."""

    metadata = {"render_modes": ["rgb_array"], "render_fps": 12}  # noqa: RUF012

    def __init__(self, render_mode: str | None = None) -> None:
        self.render_mode = render_mode
        self.action_space = gymnasium.spaces.Discrete(3)
        self.observation_space = gymnasium.spaces.Box(0, max(COLUMNS, ROWS), (3,), np.int64)

    def get_action_meanings(self) -> list[str]:
        """Return the names by which Tril finds keys, and the action of no key."""
        return ["NOOP", "LEFT", "RIGHT"]

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[npt.NDArray[np.int64], dict[str, Any]]:
        """Begin a game; every draw comes from the seed."""
        super().reset(seed=seed)
        self._basket, self._caught = COLUMNS // 2, 0
        self._drop()
        return self._observation(), {}

    def step(self, action: int) -> tuple[npt.NDArray[np.int64], float, bool, bool, dict[str, Any]]:
        """Move the basket; the fruit falls by a cell."""
        self._basket = min(max(self._basket + (0, -1, 1)[action], 0), COLUMNS - 1)
        self._row += 1
        reward, is_over = 0.0, False
        if self._row == ROWS - 1:
            is_over = self._column != self._basket
            reward = float(not is_over)
            self._caught += not is_over
            is_over = is_over or self._caught == FRUITS
            self._drop()
        return self._observation(), reward, is_over, False, {}

    def render(self) -> npt.NDArray[np.uint8]:  # type: ignore[override]
        """Return the picture, uint8 (96, 56, 3) RGB, always of one size."""
        cells = np.zeros((ROWS, COLUMNS, 3), np.uint8)
        cells[self._row, self._column] = FRUIT
        cells[-1, self._basket] = BASKET
        return cells.repeat(CELL_PX, axis=0).repeat(CELL_PX, axis=1)

    def _drop(self) -> None:
        self._row, self._column = 0, int(self.np_random.integers(COLUMNS))

    def _observation(self) -> npt.NDArray[np.int64]:
        return np.array([self._row, self._column, self._basket])


gymnasium.register("Catch-v0", CatchEnv, max_episode_steps=200)
