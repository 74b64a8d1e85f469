"""Games as a vectorised environment of stable-baselines3, with the learned reward."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from stable_baselines3.common.vec_env import VecEnv
from stable_baselines3.common.vec_env.base_vec_env import VecEnvIndices, VecEnvObs, VecEnvStepReturn

from trainer.policy.networks import OBSERVATION_SPACE, action_space
from trainer.policy.reward_shaping import Rewards, RewardShaping
from tril.play.vector.vector_game import FinishedGame, VectorGame, VectorSnapshot


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
        return self.game.died


@dataclass(frozen=True)
class EpisodeEnd:
    """Where an episode ended in a rollout.

    Attributes:
        step: Number of the rollout's step.
        game: The finished game.
        last_observation: uint8 (4, 84, 84): the episode's last state, after which the game's next
            episode began.
    """

    step: int
    game: FinishedGame
    last_observation: npt.NDArray[np.uint8]

    @property
    def is_truncated(self) -> bool:
        """Whether the time was up."""
        return self.game.truncated


class TrilVecEnv(VecEnv):
    """A VectorGame as stable-baselines3's VecEnv, with the learned reward instead of a score.

    Whoever collects rollouts steps the games themselves, part by part, and asks for all rewards of
    a rollout at once: networks score many states faster than a few, and no game waits for a
    reward between two steps. The
    reward of a step is computed on the observation that the step led to. Where the step ended the
    episode that is the episode's last observation, not the first of the next episode as in T-REX's
    published code.

    Args:
        games: The games, which are closed with this.
        reward_shaping: The policy's reward.
    """

    def __init__(self, games: VectorGame, reward_shaping: RewardShaping) -> None:
        self.games = games
        self.reward_shaping = reward_shaping
        # Of the episodes that are under way.
        self._returns = np.zeros(games.n_games, np.float64)
        self._shaped_returns = np.zeros(games.n_games, np.float64)
        self._steps = np.zeros(games.n_games, np.int64)
        super().__init__(
            games.n_games, OBSERVATION_SPACE, action_space(games.game.controls.n_actions)
        )

    def reset(self) -> VecEnvObs:
        """Begin all games and return their observations, uint8 (N, 4, 84, 84)."""
        return self.games.reset()

    def step_async(self, actions: npt.NDArray[np.int64]) -> None:
        """Refuse: the rewards of single steps are not computed."""
        raise RuntimeError("Step the games of a TrilVecEnv and have the whole rollout judged.")

    def step_wait(self) -> VecEnvStepReturn:
        """Refuse: no step is ever begun."""
        raise RuntimeError("No step of a TrilVecEnv is under way.")

    def judge(
        self, observations: npt.NDArray[np.uint8], ends: Sequence[EpisodeEnd]
    ) -> tuple[Rewards, list[FinishedEpisode]]:
        """Return the rewards of a rollout, and the episodes that ended in it.

        Args:
            observations: uint8 ((T + 1) * N, 4, 84, 84): the states of all N games before each of T
                steps, and after the last.
            ends: Where episodes ended, in order of time.

        Returns:
            Rewards, float32 (T, N), and the episodes in the order of ``ends``.
        """
        model = self.reward_shaping.model
        scores = model.score(observations).reshape(-1, self.num_envs)
        previous, reached = scores[:-1], scores[1:].copy()
        died = np.zeros(reached.shape, np.bool_)
        if ends:
            last = model.score(np.stack([end.last_observation for end in ends]))
            for end, score in zip(ends, last.tolist(), strict=True):
                reached[end.step, end.game.game] = score
                died[end.step, end.game.game] = end.game.died
        rewards = self.reward_shaping.shape(previous, reached, died)
        return rewards, self._finish_episodes(reached, rewards, ends)

    def _finish_episodes(
        self, reached: Rewards, rewards: Rewards, ends: Sequence[EpisodeEnd]
    ) -> list[FinishedEpisode]:
        """Return the episodes that ended, and count what the others have reached."""
        episodes = []
        begin = np.zeros(self.num_envs, np.int64)
        for end in ends:
            index = end.game.game
            self._count(index, slice(int(begin[index]), end.step + 1), reached, rewards)
            begin[index] = end.step + 1
            episodes.append(
                FinishedEpisode(
                    end.game,
                    int(self._steps[index]),
                    float(self._returns[index]),
                    float(self._shaped_returns[index]),
                )
            )
            self._returns[index] = self._shaped_returns[index] = self._steps[index] = 0
        for index in range(self.num_envs):
            self._count(index, slice(int(begin[index]), len(rewards)), reached, rewards)
        return episodes

    def _count(self, index: int, steps: slice, reached: Rewards, rewards: Rewards) -> None:
        self._returns[index] += reached[steps, index].sum(dtype=np.float64)
        self._shaped_returns[index] += rewards[steps, index].sum(dtype=np.float64)
        self._steps[index] += steps.stop - steps.start

    def save(self) -> dict[str, npt.NDArray[Any]]:
        """Return the state of the environment for a checkpoint."""
        games = {f"games.{name}": a for name, a in self.games.snapshot().to_arrays().items()}
        return games | {
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
