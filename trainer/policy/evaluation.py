"""Evaluation games of trained policies, as recordings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt

from trainer.progress import NullProgress, Progress
from trainer.reward.model import RewardModel
from tril.games.base import Game, Opening, Start, Taken, evaluation_beginning, start_of
from tril.play.agent import STICKY_ACTION_PROBABILITY, sample_actions
from tril.play.vector.vector_game import FinishedGame, FixedStarts, VectorGame
from tril.recipes import EvaluationRecipe
from tril.recording import Recording
from tril.store.training.evaluations import ActionSelection


class Actor(Protocol):
    """A policy."""

    def probabilities(self, observations: npt.NDArray[np.uint8]) -> npt.NDArray[np.float32]:
        """Return the probability of each action, float32 (N, n_actions).

        Args:
            observations: uint8 (N, 4, 84, 84).
        """


@dataclass(frozen=True)
class EvaluatedGame:
    """A game that a policy has played.

    Attributes:
        start: Start of the game.
        recording: The actions executed, without RAM hashes, which a verifying replay adds.
        taken: The items taken, in order of time.
        end: Name of the end.
        died: Whether the player died.
        rewards: R of the state that the policy played on from and of the state after each of its T
            steps, float32 (T + 1,); None without a reward model.
    """

    start: Start
    recording: Recording
    taken: tuple[Taken, ...]
    end: str
    died: bool
    rewards: npt.NDArray[np.float32] | None

    @property
    def predicted_return(self) -> float | None:
        """Sum of R over the states after each step; None without a reward model."""
        return None if self.rewards is None else float(self.rewards[1:].sum(dtype=np.float64))


def play(
    game: Game,
    actor: Actor,
    starts: Sequence[Start | Opening],
    action_selection: ActionSelection,
    *,
    model: RewardModel | None = None,
    end_rule: str | None = None,
    sampling_seed: int = 0,
    sticky_action_probability: float | None = None,
    n_processes: int | None = None,
    progress: Progress | None = None,
) -> list[EvaluatedGame]:
    """Let a policy play one game from each start, all in parallel.

    Args:
        game: The game.
        actor: The policy.
        starts: Where the games begin; the policy plays from the end of an opening on.
        action_selection: "greedy" takes the likeliest action, "sampled" samples actions by their
            probabilities, "sticky" takes the likeliest action while actions stick.
        model: Scores the states that the policy reaches.
        end_rule: Name of the rule by which a loss ends a game; the default where it has no such.
        sampling_seed: Seeds one generator per game, so that a game does not depend on which others
            are played beside it.
        sticky_action_probability: Probability of repeating the last frame's action; recordings
            hold the executed actions. By default that of the action selection.
        n_processes: See VectorGame.
        progress: Counts steps, up to the maximum of a game.

    Returns:
        The games in the order of the starts.
    """
    progress = progress or NullProgress()
    if sticky_action_probability is None:
        sticky_action_probability = stickiness(action_selection)
    generators = [
        np.random.default_rng((sampling_seed, *start.key)) for start in map(start_of, starts)
    ]
    rewards: list[list[float]] = [[] for _ in starts]
    finished: dict[int, FinishedGame] = {}
    end_rule = game.known_end_rule(end_rule or "")
    max_steps = game.clock.max_steps
    with VectorGame(
        game,
        len(starts),
        FixedStarts(tuple(starts)),
        n_processes=n_processes,
        end_rule=end_rule,
        sticky_action_probability=sticky_action_probability,
        training_seed=sampling_seed,
    ) as games:
        observations = games.reset()
        playing = np.arange(len(starts))
        _score(model, observations, playing, rewards)
        while len(playing):
            actions = np.zeros(len(starts), np.int64)
            probabilities = actor.probabilities(observations[playing])
            actions[playing] = _select_actions(
                probabilities, action_selection, [generators[i] for i in playing]
            )
            step = games.step(actions)
            ended = step.ended[:, None, None, None]
            reached = np.where(ended, step.terminal_observations, step.observations)
            _score(model, reached, playing, rewards)
            finished |= {game_end.game: game_end for game_end in step.finished}
            observations = step.observations
            playing = np.array([i for i in playing if i not in finished], np.int64)
            progress.advance(int(step.steps.max(initial=0)), max_steps)
    progress.advance(max_steps, max_steps)
    return [
        EvaluatedGame(
            start=finished_game.start,
            recording=Recording(
                game, finished_game.start, finished_game.actions, end_rule=end_rule
            ),
            taken=finished_game.taken,
            end=finished_game.end,
            died=finished_game.died,
            rewards=None if model is None else np.array(rewards[index], np.float32),
        )
        for index, finished_game in sorted(finished.items())
    ]


def beginnings(
    game: Game, recipe: EvaluationRecipe, numbers: Sequence[int]
) -> list[Start | Opening]:
    """Return the beginnings of evaluation starts' games, by the recipe with openings or without."""
    return [evaluation_beginning(game.starts, number, recipe.openings) for number in numbers]


def opening_steps(recording: Recording, beginning: Start | Opening) -> int:
    """Return for how many steps a game's opening was played; 0 without one.

    An opening that is not survived was left out (`tril.play.agent.AgentGame.begin`). A policy that
    plays the same actions ends where the opening did, so that a longer game that begins so has it.
    """
    if not isinstance(beginning, Opening):
        return 0
    actions = np.repeat(np.array(beginning.actions, np.uint8), recording.game.clock.frames_per_step)
    is_played = recording.n_frames > len(actions) and recording.actions.startswith(
        actions.tobytes()
    )
    return len(beginning.actions) if is_played else 0


def stickiness(action_selection: ActionSelection) -> float:
    """Return the probability with which games repeat the last frame's action."""
    return STICKY_ACTION_PROBABILITY if action_selection == "sticky" else 0.0


def _select_actions(
    probabilities: npt.NDArray[np.float32],
    action_selection: ActionSelection,
    generators: Sequence[np.random.Generator],
) -> npt.NDArray[np.int64]:
    if action_selection != "sampled":
        best: npt.NDArray[np.int64] = probabilities.argmax(1)
        return best
    return sample_actions(probabilities, np.array([rng.random() for rng in generators]))


def _score(
    model: RewardModel | None,
    states: npt.NDArray[np.uint8],
    playing: npt.NDArray[np.int64],
    rewards: list[list[float]],
) -> None:
    """Append R of the states of the games in play to their rewards."""
    if model is not None:
        for index, reward in zip(playing.tolist(), model.score(states[playing]), strict=True):
            rewards[index].append(float(reward))
