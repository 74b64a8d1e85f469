"""Games as a vectorised environment of stable-baselines3, with the learned reward."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from stable_baselines3.common.vec_env import VecEnv
from stable_baselines3.common.vec_env.base_vec_env import VecEnvIndices, VecEnvObs, VecEnvStepReturn

from trainer.nn.screens import channels_last_screens
from trainer.policy.networks import ACTION_SPACE, OBSERVATION_SPACE
from trainer.policy.reward_shaping import Rewards, RewardShaping
from tril.game.episode import DEATHS, EndReason
from tril.game.observation import SIZE, STACK
from tril.game.vector.vector_game import FinishedGame, VectorGame, VectorSnapshot


@dataclass(frozen=True)
class FinishedEpisode:
    """A finished training episode.

    Attributes:
        game: The game, including the demonstration's part or the opening that it began after.
        n_steps: Steps that the policy played.
        predicted_return: Sum of R over the states that the policy reached.
        shaped_return: Sum of the policy's rewards.
    """

    game: FinishedGame
    n_steps: int
    predicted_return: float
    shaped_return: float

    @property
    def is_whole(self) -> bool:
        """Whether the policy played it from the start or from the end of an opening."""
        return not self.game.from_demonstration

    @property
    def died(self) -> bool:
        """Whether the player was hit."""
        return self.game.end in DEATHS


class TrilVecEnv(VecEnv):
    """A VectorGame as stable-baselines3's VecEnv, with the learned reward instead of a score.

    The reward of a step is computed on the observation that the step led to. Where the step ended
    the episode that is the episode's last observation, not the first of the next episode as in
    T-REX's published code.

    ``infos`` is filled only for games whose episode ended: "terminal_observation",
    "TimeLimit.truncated" (true after 300 steps), "episode" as of stable-baselines3's Monitor, and
    "finished", a FinishedEpisode.

    Observations are in channels-last order; those of the last two steps stay valid, older ones are
    overwritten.

    Args:
        games: The games, which are closed with this.
        reward_shaping: The policy's reward.
    """

    def __init__(self, games: VectorGame, reward_shaping: RewardShaping) -> None:
        self.games = games
        self.reward_shaping = reward_shaping
        self._before: Rewards = np.zeros(games.n_games, np.float32)
        self._returns = np.zeros(games.n_games, np.float64)
        self._shaped_returns = np.zeros(games.n_games, np.float64)
        self._steps = np.zeros(games.n_games, np.int64)
        self._screens = np.empty((2, games.n_games, SIZE, SIZE, STACK), np.uint8)
        self._half = 0
        super().__init__(games.n_games, OBSERVATION_SPACE, ACTION_SPACE)

    def reset(self) -> VecEnvObs:
        """Begin all games and return their observations, uint8 (N, 4, 84, 84)."""
        observations = self.games.reset()
        if self.reward_shaping.needs_before:
            self._before[:] = self.reward_shaping.model.score(observations)
        return observations

    def step_async(self, actions: npt.NDArray[np.int64]) -> None:
        """Begin a step of all games with actions, int64 (N,)."""
        self.games.step_async(actions)

    def step_wait(self) -> VecEnvStepReturn:
        """Finish the step; see VecEnv."""
        step = self.games.step_wait()
        self._half = 1 - self._half
        observations = channels_last_screens(step.observations, self._screens[self._half]).numpy()
        ended = np.flatnonzero(step.ended)
        reached_states = observations
        if len(ended):
            reached_states = observations.copy(order="K")
            reached_states[ended] = step.terminal_observations[ended]
        reached = self.reward_shaping.model.score(reached_states)
        died = np.array([reason in DEATHS for reason in step.reasons])
        rewards = self.reward_shaping.shape(self._before, reached, died)
        self._returns += reached
        self._shaped_returns += rewards
        self._steps += 1
        infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        for one in step.finished:
            infos[one.game] = self._finish(one, reached_states[one.game])
        if self.reward_shaping.needs_before:
            self._before = reached
            if len(ended):
                self._before[ended] = self.reward_shaping.model.score(observations[ended])
        return observations, rewards, step.ended, infos

    def _finish(self, one: FinishedGame, last_observation: npt.NDArray[np.uint8]) -> dict[str, Any]:
        index = one.game
        episode = FinishedEpisode(
            one,
            int(self._steps[index]),
            float(self._returns[index]),
            float(self._shaped_returns[index]),
        )
        self._returns[index] = self._shaped_returns[index] = self._steps[index] = 0
        return {
            "terminal_observation": last_observation,
            "TimeLimit.truncated": one.end is EndReason.STEPS,
            "episode": {"r": episode.shaped_return, "l": episode.n_steps},
            "finished": episode,
        }

    def save(self) -> dict[str, npt.NDArray[Any]]:
        """Return the state of the environment for a checkpoint."""
        games = {f"games.{name}": a for name, a in self.games.snapshot().to_arrays().items()}
        return games | {
            "before": self._before,
            "returns": self._returns,
            "paid": self._shaped_returns,  # its name in the format
            "steps": self._steps,
        }

    def restore(self, arrays: dict[str, npt.NDArray[Any]]) -> npt.NDArray[np.uint8]:
        """Restore what ``save`` returned, and return the observations of that moment."""
        prefix = "games."
        games = {
            name[len(prefix) :]: array for name, array in arrays.items() if name.startswith(prefix)
        }
        self._before = arrays["before"].copy()
        self._returns = arrays["returns"].copy()
        self._shaped_returns = arrays["paid"].copy()
        self._steps = arrays["steps"].copy()
        return self.games.restore(VectorSnapshot.from_arrays(games))

    def close(self) -> None:
        """End the games."""
        self.games.close()

    def get_attr(self, attr_name: str, indices: VecEnvIndices = None) -> list[Any]:
        """Return an attribute of this environment, once per game."""
        return [getattr(self, attr_name, None) for _ in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: VecEnvIndices = None) -> None:
        """Refuse: the games share their attributes."""
        raise AttributeError(f"The games of a TrilVecEnv have no attribute {attr_name!r} to set.")

    def env_method(
        self, method_name: str, *args: Any, indices: VecEnvIndices = None, **kwargs: Any
    ) -> list[Any]:
        """Refuse: the games have no methods that could be called one by one."""
        raise AttributeError(f"The games of a TrilVecEnv have no method {method_name!r}.")

    def env_is_wrapped(self, wrapper_class: Any, indices: VecEnvIndices = None) -> list[bool]:
        """Tell whether games are wrapped: they never are."""
        return [False for _ in self._get_indices(indices)]
