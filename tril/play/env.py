"""The registered Gymnasium environment: `tril/SpaceInvaders-v0`.

import gymnasium
import tril.play.env  # registers it

env = gymnasium.make("tril/SpaceInvaders-v0", target=[(row, 4) for row in range(6)])
"""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Literal, get_args

import gymnasium
import numpy as np
import numpy.typing as npt

from tril.games.atari.console import Console
from tril.games.space_invaders import memory as game
from tril.games.space_invaders.memory import Cell
from tril.play.agent import AgentGame, StickyActions
from tril.play.episode import Ending, EndReason, Hit, Start, draw_start
from tril.play.observation import OBSERVATION_SHAPE, Observation

ENV_ID = "tril/SpaceInvaders-v0"

EnvReward = Literal["points", "shots", "none"]


def points_of(hits: Iterable[Hit]) -> int:
    """Return the points of the aliens shot, 5 to 30 by row."""
    return sum(game.POINTS[hit.row] for hit in hits)


class SpaceInvadersEnv(gymnasium.Env[Observation, np.int64]):
    """Space Invaders with the observations and episode ends of Tril's agents.

    A step executes one action for four frames. Observations are uint8 (4, 84, 84); there are six
    actions. An episode terminates when the player is hit, the aliens are cleared or they have
    landed, and is truncated after 300 steps.

    The reward is the points of the aliens shot (5 to 30 by row), 1 for each missile fired, or 0 for
    a learned reward added by a wrapper. The bonus ship, which observations do not show, gives none.

    `info` holds `hits` (list of (row from the bottom, column from the left), from 0, in order of
    time), `frame`, `end` (why the episode ended, None while it goes on), `start` (its idle frames),
    `executed_actions` (of the step's frames) and, if a target is given, `targets` and `strays`
    (the number of hits inside and outside of it).

    Args:
        target: the target cells of the taught behaviour, if any.
        start: how every episode begins; None draws one for each, never an evaluation start.
        ending: which rule for the player's death ends an episode: "hit" or "life_counter".
        reward: "points", "shots" or "none".
        sticky_action_probability: of repeating, at any frame, the previous frame's action.
        render_mode: None or "rgb_array".

    `reset(options=...)` takes `target`, `start` and `ending` for this and later episodes.
    """

    metadata = {  # noqa: RUF012 - as gymnasium declares it
        "render_modes": ["rgb_array"],
        "render_fps": game.FRAME_RATE_HZ // game.FRAMES_PER_STEP,
    }

    def __init__(
        self,
        target: Sequence[Cell] | None = None,
        start: Start | None = None,
        ending: Ending | str = Ending.HIT,
        reward: EnvReward = "points",
        sticky_action_probability: float = 0.0,
        render_mode: str | None = None,
    ) -> None:
        if reward not in get_args(EnvReward):
            raise ValueError(f'Expected reward "points", "shots" or "none", got {reward!r}.')
        if render_mode not in (None, *self.metadata["render_modes"]):
            raise ValueError(f'Expected render_mode None or "rgb_array", got {render_mode!r}.')
        self.observation_space = gymnasium.spaces.Box(0, 255, OBSERVATION_SHAPE, np.uint8)
        self.action_space = gymnasium.spaces.Discrete(game.ACTION_COUNT)
        self.render_mode = render_mode
        self._target = _cells(target)
        self._start = start
        self._reward = reward
        self._sticky_action_probability = sticky_action_probability
        self._game = AgentGame(Console(), Ending(ending))

    def reset(
        self, *, seed: int | None = None, options: Mapping[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin an episode; see gymnasium.Env.

        Raises:
            ValueError: an option is unknown.
        """
        super().reset(seed=seed)
        given = dict(options or {})
        if "target" in given:
            self._target = _cells(given.pop("target"))
        if "start" in given:
            self._start = given.pop("start")
        if "ending" in given:
            self._game.ending = Ending(given.pop("ending"))
        if given:
            raise ValueError(f"Expected the options target, start and ending, got {list(given)}.")
        self._game.sticky = StickyActions(self._sticky_action_probability, self.np_random)
        self._game.reset(self._start or draw_start(self.np_random))
        return self._game.observation, self._info(first_frame=0)

    def step(self, action: np.int64 | int) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Play one step; see gymnasium.Env."""
        episode = self._game.episode
        first_frame, before = episode.frame, self._earned()
        self._game.step(int(action))
        end = self._game.end
        return (
            self._game.observation,
            float(self._earned() - before),
            end is not None and end is not EndReason.STEPS,
            end is EndReason.STEPS,
            self._info(first_frame),
        )

    def _earned(self) -> int:
        """Return the episode's reward so far."""
        match self._reward:
            case "points":
                return points_of(self._game.hits)
            case "shots":
                return self._game.episode.shots
            case "none":
                return 0

    def _info(self, first_frame: int) -> dict[str, Any]:
        episode = self._game.episode
        hits = [(hit.row, hit.column) for hit in episode.hits]
        info: dict[str, Any] = {
            "hits": hits,
            "frame": episode.frame,
            "end": None if episode.end is None else str(episode.end),
            "start": episode.start.idle_frames,
            "executed_actions": tuple(episode.actions[first_frame:]),
        }
        if self._target is not None:
            info["targets"] = sum(hit in self._target for hit in hits)
            info["strays"] = len(hits) - info["targets"]
        return info

    def render(self) -> npt.NDArray[np.uint8] | None:
        """Return the screen, uint8 (210, 160, 3) RGB, in render_mode "rgb_array"."""
        return self._game.console.screen_rgb() if self.render_mode == "rgb_array" else None


def _cells(target: Sequence[Cell] | None) -> frozenset[Cell] | None:
    """Return target cells; raise ValueError for cells outside of the grid."""
    if target is None:
        return None
    cells = frozenset((int(row), int(column)) for row, column in target)
    for row, column in cells:
        if not (0 <= row < game.ROWS and 0 <= column < game.COLUMNS):
            raise ValueError(
                f"Expected target cells with rows and columns from 0 to 5, got ({row}, {column})."
            )
    return cells


if ENV_ID not in gymnasium.registry:
    gymnasium.register(id=ENV_ID, entry_point=f"{__name__}:{SpaceInvadersEnv.__name__}")
