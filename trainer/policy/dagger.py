"""DAgger (Ross, Gordon, Bagnell 2011): a policy learned from an expert's corrections of its games.

The expert is the scripted demonstrator. It is privileged: it reads the emulator's memory and looks
ahead in the saved game. The result is an upper bound: what imitation could reach with a teacher
that answers in every state. Nothing else here learns from it.

Algorithm 3.1 with these choices:

- In iteration i each step is the expert's with probability beta_i = p^(i-1), else the policy's
  likeliest action. All states but the last one of each game are labelled.
- The policy is trained anew on everything collected, as clones are (trainer.policy.cloning).
- The policy kept is the one with the highest return of the learned reward in games from training
  starts, as with PPO, instead of the one with the lowest loss on a validation set.
"""

from __future__ import annotations

import base64
import hashlib
import json
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import torch

from trainer.nn.checkpoints import CheckpointDamaged
from trainer.nn.devices import CPU
from trainer.nn.precision import Precision
from trainer.policy.cloning import CloneResult, train_clone
from trainer.policy.imitation import (
    ImitationTask,
    ImitatorResult,
    SnapshotScore,
    best_snapshot,
    episode_metrics,
    evaluate_snapshot,
)
from trainer.policy.networks import Policy, load_policy, save_policy
from trainer.policy.reward_shaping import RewardShaping
from trainer.progress import CallbackProgress, Progress
from tril.demonstrators import Expert
from tril.errors import Invalid
from tril.files.artifact_store import write_whole
from tril.games.atari.starts import AtariStart
from tril.games.base import Console, Start, draw_start
from tril.games.space_invaders import SPACE_INVADERS
from tril.games.space_invaders.ends import DEATHS
from tril.play.agent import AgentGame
from tril.recording import Recording, Trajectory, trajectory

FORMAT = "tril-dagger-checkpoint"
FORMAT_VERSION = 1

_CHECKPOINT = "checkpoint.json"


@dataclass(frozen=True, eq=False)
class LabelledGame:
    """A game with the expert's action in each of its states.

    Attributes:
        trajectory: Observations and their *labels*, not the actions taken.
        executed: The action of every frame, one byte each.
        start: Start of the game.
        agreed: Share of the states in which the policy's likeliest action is the label, 0 to 1;
            None where no policy played.
    """

    trajectory: Trajectory
    executed: bytes
    start: Start
    agreed: float | None


def train_by_dagger(
    task: ImitationTask,
    path: Path,
    checkpoint_folder: Path,
    progress: Progress,
    device: torch.device = CPU,
) -> ImitatorResult:
    """Train an imitator by DAgger and save its best policy.

    Args:
        task: Behaviour and learned reward, but no demonstrations. Steps are rounded up to whole
            games, which always end at the player's death: after it there is nothing to label.
        path: Where the policy is saved, for plain ``PPO.load``.
        checkpoint_folder: An existing folder of this training alone, from which an interrupted
            training continues. At most a game or the training of one policy is lost.
        progress: Counts steps; receives the curves after every iteration.
        device: Device that policies learn on.

    Raises:
        Invalid: The demonstrator can't show this behaviour, or the checkpoint can't be read.
        RunCancelled: Raised by ``progress``.
    """
    training = _Training(task, checkpoint_folder, progress, device)
    training.restore_or_start()
    while not training.is_done:
        training.iterate()
    write_whole(path, training.best.read_bytes())
    snapshots = tuple(training.snapshots)
    return ImitatorResult(snapshots, best_snapshot(snapshots).steps, Precision.FLOAT32)


def play_labelled(
    game: AgentGame,
    expert: Expert,
    policy: Policy | None,
    expert_share: float,
    rng: np.random.Generator,
    on_step: Callable[[], None],
) -> LabelledGame:
    """Play a game from a random training start and have all of its states labelled.

    Args:
        game: Plays.
        expert: Labels; not on the same console.
        policy: Plays beside the expert; None leaves all steps to the expert.
        expert_share: Probability with which a step is the expert's.
        rng: Source of randomness.
        on_step: Called after every step; what it raises ends the game.
    """
    (expert_rng,) = rng.spawn(1)
    start = draw_start(SPACE_INVADERS.starts, rng)
    game.reset(start)
    expert.begin(expert_rng)
    observations, labels, agreed = [game.observation], [], 0
    while game.end is None:
        label = expert.action(game.episode.save())
        action = label
        if policy is not None:
            likeliest = int(policy.probabilities(observations[-1][None])[0].argmax())
            agreed += likeliest == label
            if rng.random() >= expert_share:
                action = likeliest
        game.step(action)
        observations.append(game.observation)
        labels.append(label)
        on_step()
    labelled = Trajectory(np.stack(observations), np.array(labels, np.int64), game.taken, game.end)
    share = None if policy is None else agreed / len(labels)
    return LabelledGame(labelled, game.episode.actions, start, share)


class _Training:
    """The state of a training, which its checkpoint holds.

    An iteration plays games, each of which is saved in the checkpoint, and then learns a policy,
    which is saved in a file of its own. What is sampled for a game depends on the training seed and
    the game's number alone.
    """

    def __init__(
        self, task: ImitationTask, folder: Path, progress: Progress, device: torch.device
    ) -> None:
        if task.behaviour is None:
            raise Invalid("DAgger needs to know the behaviour: its expert has to show it.")
        self._task = task
        self._folder = folder
        self._progress = progress
        self._device = device
        self._expert = Expert(task.behaviour, SPACE_INVADERS.make_console())
        self._game = AgentGame(SPACE_INVADERS.make_console())
        self._shaping = RewardShaping.of(task.model, task.recipe.policy)
        self._games: list[LabelledGame] = []
        self._n_learned = 0
        self.snapshots: list[SnapshotScore] = []
        self._since = time.monotonic()
        self._steps_since = 0

    @property
    def is_done(self) -> bool:
        """Whether all steps have been played and learned from."""
        return self._learned_steps >= self._task.steps

    @property
    def best(self) -> Path:
        """File of the best policy."""
        return self._policy_file(best_snapshot(self.snapshots).steps)

    @property
    def _steps(self) -> int:
        """Steps played."""
        return sum(game.trajectory.n_steps for game in self._games)

    @property
    def _learned_steps(self) -> int:
        """Steps that the latest policy was learned from."""
        return self.snapshots[-1].steps if self.snapshots else 0

    def restore_or_start(self) -> None:
        """Continue from the checkpoint if there is one."""
        if (self._folder / _CHECKPOINT).exists():
            self._load()
        else:
            self._report_steps(0)
        self._steps_since = self._steps

    def iterate(self) -> None:
        """Play the iteration's missing games, learn from all games, and evaluate the policy."""
        iteration = len(self.snapshots)
        policy = load_policy(self._policy_file(self._learned_steps)) if iteration else None
        recipe = self._task.recipe.dagger
        expert_share = float(recipe.expert_decay**iteration)
        enough = self._learned_steps + recipe.steps_per_iteration
        while self._steps < min(enough, self._task.steps):
            rng = np.random.default_rng([self._task.training_seed, len(self._games)])
            game = play_labelled(
                self._game,
                self._expert,
                policy,
                expert_share,
                rng,
                lambda: self._report_steps(self._steps + self._game.steps),
            )
            self._games.append(game)
            self._save()
        # Reported before it is saved, so that a training that continues leaves no point out.
        self._report_curves(expert_share, self._learn())
        self._n_learned = len(self._games)
        self._save()
        self._drop_superseded()

    def _report_steps(self, steps: int) -> None:
        """Report the steps done; a cancelled run stops here."""
        self._progress.advance(min(steps, self._task.steps), self._task.steps)

    def _learn(self) -> CloneResult:
        """Learn the next policy from all games, evaluate and save it."""
        recipe, steps = self._task.recipe, self._steps

        def on_step() -> None:
            self._report_steps(steps)

        policy, result = train_clone(
            [game.trajectory for game in self._games],
            self._task.game.controls.n_actions,
            replace(
                recipe.cloning,
                network=recipe.policy.network,
                learning_rate=recipe.policy.learning_rate,
            ),
            self._task.training_seed,
            CallbackProgress(on_step),
            self._device,
        )
        policy.set_training_mode(False)
        predicted_return, _ = evaluate_snapshot(
            self._task.game, Policy(policy), self._shaping, recipe, on_step
        )
        save_policy(policy, self._policy_file(steps))
        self.snapshots.append(SnapshotScore(steps, predicted_return))
        return result

    def _report_curves(self, expert_share: float, result: CloneResult) -> None:
        """Report a point of the curves: means over the iteration's games, and the training."""
        points = [self._game_metrics(game) for game in self._games[self._n_learned :]]
        values = {name: float(np.mean([point[name] for point in points])) for name in points[0]}
        now = time.monotonic()
        values["steps_per_s"] = (self._steps - self._steps_since) / max(1e-9, now - self._since)
        self._since, self._steps_since = now, self._steps
        values |= {"expert_share": expert_share, "accuracy": result.accuracy}
        if result.held_out_accuracy is not None:
            values["held_out_accuracy"] = result.held_out_accuracy
        self._progress.advance(min(self._steps, self._task.steps), self._task.steps, values)

    def _game_metrics(self, game: LabelledGame) -> dict[str, float]:
        trajectory = game.trajectory
        rewards = self._task.model.score(trajectory.observations[1:])
        values = {"predicted_return": float(rewards.sum(dtype=np.float64))}
        died = trajectory.end in DEATHS
        values |= episode_metrics(self._task.behaviour, trajectory.n_steps, trajectory.taken, died)
        if game.agreed is not None:
            values["agreement"] = game.agreed
        return values

    def _policy_file(self, steps: int) -> Path:
        return self._folder / f"policy-{steps}.zip"

    def _drop_superseded(self) -> None:
        """Remove all policies but the best and the latest."""
        needed = {self.best, self._policy_file(self._learned_steps)}
        for path in self._folder.glob("policy-*.zip"):
            if path not in needed:
                path.unlink()

    def _save(self) -> None:
        """Save the games as their actions, whose replay gives the observations again."""
        state: dict[str, Any] = {
            "format": FORMAT,
            "version": FORMAT_VERSION,
            "learned_from": self._n_learned,
            "snapshots": [asdict(snapshot) for snapshot in self.snapshots],
            "games": [_to_dict(game) for game in self._games],
        }
        state["sha256"] = _digest(state)
        write_whole(self._folder / _CHECKPOINT, json.dumps(state).encode())

    def _load(self) -> None:
        path = self._folder / _CHECKPOINT
        try:
            state = json.loads(path.read_bytes())
            # Checkpoints of earlier versions have no digest.
            if "sha256" in state and state.pop("sha256") != _digest(state):
                raise CheckpointDamaged(path, "it was damaged after it had been written")
            if (state["format"], state["version"]) != (FORMAT, FORMAT_VERSION):
                raise Invalid(
                    f"{path} is no checkpoint that this version can continue from. Remove it and"
                    " the training begins anew."
                )
            self._n_learned = state["learned_from"]
            self.snapshots = [SnapshotScore(**snapshot) for snapshot in state["snapshots"]]
            for game in state["games"]:
                # The curves end at the latest policy.
                self._report_steps(self._learned_steps)
                self._games.append(_from_dict(game, self._game.console))
        except (ValueError, KeyError, TypeError) as error:
            raise CheckpointDamaged(path, error) from error


def _digest(state: dict[str, Any]) -> str:
    return hashlib.sha256(json.dumps(state).encode()).hexdigest()


def _to_dict(game: LabelledGame) -> dict[str, Any]:
    return {
        "start": asdict(game.start),
        "executed": base64.b64encode(game.executed).decode(),
        "labels": base64.b64encode(bytes(game.trajectory.actions.tolist())).decode(),
        "agreed": game.agreed,
    }


def _from_dict(data: dict[str, Any], console: Console) -> LabelledGame:
    start, executed = AtariStart(**data["start"]), base64.b64decode(data["executed"])
    labels: npt.NDArray[np.uint8] = np.frombuffer(base64.b64decode(data["labels"]), np.uint8)
    labelled = trajectory(Recording(SPACE_INVADERS, start, executed), console)
    labelled = replace(labelled, actions=labels.astype(np.int64))
    return LabelledGame(labelled, executed, start, data["agreed"])
