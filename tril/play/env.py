"""The registered Gymnasium environments: `tril/SpaceInvaders-v0`, and `tril/Game-v0` for any game.

import gymnasium
import tril.play.env  # registers them

env = gymnasium.make("tril/SpaceInvaders-v0", target=[(row, 4) for row in range(6)])
env = gymnasium.make("tril/Game-v0", game="breakout")
"""

from collections.abc import Mapping, Sequence
from typing import Any, Literal, get_args

import gymnasium
import numpy as np
import numpy.typing as npt

from tril.games import DEFAULT_GAME, game_named
from tril.games.base import Cell, Start, draw_start
from tril.play.agent import AgentGame, StickyActions
from tril.play.observation import OBSERVATION_SHAPE, Observation

ENV_ID = "tril/SpaceInvaders-v0"
GAME_ENV_ID = "tril/Game-v0"

SCORE = "score"
NONE = "none"
RenderMode = Literal["rgb_array"]


class TrilEnv(gymnasium.Env[Observation, np.int64]):
    """A game with the observations and episode ends of Tril's agents.

    A step executes one action for the frames of a step. Observations are uint8 (4, 84, 84). An
    episode terminates at an end of the game and is truncated at its time limit.

    The reward is what the game's own score rises by, the rise of one of its counters ("shots" in
    Space Invaders), or 0 for a learned reward added by a wrapper.

    `info` holds `taken` (the items taken, a list of (row from the bottom, column from the left),
    from 0, in order of time), `frame`, `end` (name of the end, None while it goes on), `start` (its
    values by name), `executed_actions` (of the step's frames) and, if a target is given, `targets`
    and `strays` (the number of items taken inside and outside of it).

    Args:
        game: name of the game.
        target: the target cells of the taught behaviour, if any.
        start: how every episode begins; None draws one for each, never an evaluation start.
        end_rule: name of the rule by which a loss ends an episode; None for the game's default.
        reward: "score", the name of a counter, or "none".
        sticky_action_probability: of repeating, at any frame, the previous frame's action.
        render_mode: None or "rgb_array".

    `reset(options=...)` takes `target`, `start` and `end_rule` for this and later episodes.
    """

    metadata = {"render_modes": list(get_args(RenderMode))}  # noqa: RUF012 - as gymnasium does

    def __init__(
        self,
        game: str = DEFAULT_GAME,
        target: Sequence[Cell] | None = None,
        start: Start | None = None,
        end_rule: str | None = None,
        reward: str = SCORE,
        sticky_action_probability: float = 0.0,
        render_mode: RenderMode | None = None,
    ) -> None:
        self._game = game_named(game)
        rewards = [SCORE, *self._game.counters, NONE]
        if reward not in rewards:
            raise ValueError(f"Expected a reward of {', '.join(rewards)}, got {reward!r}.")
        if render_mode not in (None, *get_args(RenderMode)):
            raise ValueError(f'Expected render_mode None or "rgb_array", got {render_mode!r}.')
        if end_rule is not None:
            self._game.check_end_rule(end_rule)
        clock = self._game.clock
        self.metadata = self.metadata | {
            "render_fps": max(1, clock.frame_rate_hz // clock.frames_per_step)
        }
        self.observation_space = gymnasium.spaces.Box(0, 255, OBSERVATION_SHAPE, np.uint8)
        self.action_space = gymnasium.spaces.Discrete(self._game.controls.n_actions)
        self.render_mode = render_mode
        self._target = self._cells(target)
        self._start = start
        self._reward = reward
        self._sticky_action_probability = sticky_action_probability
        self._agent = AgentGame(self._game.make_console(), end_rule)

    def reset(
        self, *, seed: int | None = None, options: Mapping[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin an episode; see gymnasium.Env.

        Raises:
            ValueError: an option is unknown.
        """
        super().reset(seed=seed)
        values = dict(options or {})
        if "target" in values:
            self._target = self._cells(values.pop("target"))
        if "start" in values:
            self._start = values.pop("start")
        if "end_rule" in values:
            self._agent.end_rule = self._game.check_end_rule(values.pop("end_rule"))
        if values:
            raise ValueError(
                f"Expected the options target, start and end_rule, got {list(values)}."
            )
        self._agent.sticky = StickyActions(self._sticky_action_probability, self.np_random)
        self._agent.reset(self._start or draw_start(self._game.starts, self.np_random))
        return self._agent.observation, self._info(first_frame=0)

    def step(self, action: np.int64 | int) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Play one step; see gymnasium.Env."""
        episode = self._agent.episode
        first_frame, before = episode.frame, self._earned()
        self._agent.step(int(action))
        end = self._agent.end
        truncated = end == self._game.time_end
        return (
            self._agent.observation,
            float(self._earned() - before),
            end is not None and not truncated,
            truncated,
            self._info(first_frame),
        )

    def _earned(self) -> float:
        """Return the episode's reward so far."""
        if self._reward == NONE:
            return 0.0
        episode = self._agent.episode
        return episode.score if self._reward == SCORE else episode.counters[self._reward]

    def _info(self, first_frame: int) -> dict[str, Any]:
        episode = self._agent.episode
        taken = [item.cell for item in episode.taken]
        info: dict[str, Any] = {
            "taken": taken,
            "frame": episode.frame,
            "end": episode.end,
            "start": episode.start.to_json(),
            "executed_actions": tuple(episode.actions[first_frame:]),
        }
        if self._target is not None:
            info["targets"] = sum(cell in self._target for cell in taken)
            info["strays"] = len(taken) - info["targets"]
        return info

    def render(self) -> npt.NDArray[np.uint8] | None:
        """Return the screen, uint8 (height, width, 3) RGB, in render_mode "rgb_array"."""
        if self.render_mode is None:
            return None
        screen, palette = self._agent.console.screen(), self._game.screen.palette
        return screen if palette is None else palette[screen]

    def close(self) -> None:
        """Free the console."""
        self._agent.console.close()

    def _cells(self, target: Sequence[Cell] | None) -> frozenset[Cell] | None:
        """Return target cells; raise ValueError for cells outside of the grid."""
        if target is None:
            return None
        cells = frozenset((int(row), int(column)) for row, column in target)
        items = self._game.items
        for cell in cells:
            if items is None or cell not in items:
                raise ValueError(f"{self._game.title} has no item {cell}.")
        return cells


for _id in (ENV_ID, GAME_ENV_ID):
    if _id not in gymnasium.registry:
        gymnasium.register(id=_id, entry_point=f"{__name__}:{TrilEnv.__name__}")
