"""DAgger (Ross, Gordon, Bagnell 2011): a policy learned from an expert's corrections of its games.

The expert is the scripted demonstrator. It is privileged: it reads the emulator's memory and looks
ahead on the saved game. What comes of it shows what imitation could reach with a teacher that
answers in every state; nothing else here learns from it.

Algorithm 3.1 with these choices:

- Iteration i plays by the expert with a probability of beta_i = p^(i-1) at each step, else by what
  the policy finds likeliest. All states but the last one of each game are labelled.
- The policy is learned anew on everything collected, as clones are (trainer.policy.cloning).
- The policy kept is the best by what the learned reward pays in games from training starts, as
  with PPO, instead of by the loss on a validation set.
"""

from __future__ import annotations

import base64
import json
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import torch

from trainer.nn.devices import CPU
from trainer.nn.precision import Precision
from trainer.policy.cloning import CloneResult, clone
from trainer.policy.imitator import (
    ImitationTask,
    ImitatorResult,
    SnapshotScore,
    game_values,
    judge,
)
from trainer.policy.networks import Policy, load_policy, save_policy
from trainer.policy.reward_shaping import RewardShaping
from trainer.progress import Progress, Ticking
from tril.demonstrator import Expert
from tril.errors import Invalid
from tril.files.artifact_store import write_whole
from tril.game.agent import AgentGame
from tril.game.console import Console
from tril.game.episode import DEATHS
from tril.game.starts import Start, draw_start
from tril.recording import Recording, Trajectory, trajectory

FORMAT = "tril-dagger-checkpoint"
FORMAT_VERSION = 1

_CHECKPOINT = "checkpoint.json"


@dataclass(frozen=True, eq=False)
class LabelledGame:
    """A game that was played, with what the expert would have done in each of its states.

    Attributes:
        seen: The observations and what was *labelled*, not what was done.
        executed: The action of every frame, one byte each.
        start: How the game began.
        agreed: Share of the states in which the policy's likeliest action is the label, 0 to 1;
            None where no policy was asked.
    """

    seen: Trajectory
    executed: bytes
    start: Start
    agreed: float | None


def train_by_dagger(
    task: ImitationTask,
    path: Path,
    checkpoint_folder: Path,
    progress: Progress,
    *,
    n_processes: int | None = None,
    precision: Precision = Precision.FLOAT32,
    device: torch.device = CPU,
) -> ImitatorResult:
    """Train an imitator by DAgger, or go on training it, and save the best policy.

    Args:
        task: What it is trained from: the behaviour, and the learned reward to choose by. The
            demonstrations are not looked at. Its steps are rounded up to whole games, which end at
            the hit in any case: after it there is nothing to be done.
        path: Where the policy is saved, for plain ``PPO.load``.
        checkpoint_folder: An existing folder of this training alone. What a training that was
            killed left there is gone on from; it loses at most a game, or the training of one
            iteration's policy.
        progress: Told of steps, with the curves after every iteration.
        n_processes: Not used: the games are played one after the other.
        precision: Not used: it learns by classification, in 32 bits.
        device: Where each policy is learned.

    Raises:
        Invalid: The demonstrator knows nothing of this behaviour, or the checkpoint can't be read.
        RunCancelled: Raised by ``progress``.
    """
    training = _Training(task, checkpoint_folder, progress, device)
    training.begin()
    while not training.is_done:
        training.iterate()
    write_whole(path, training.best.read_bytes())
    return ImitatorResult(tuple(training.snapshots), training.best_steps, Precision.FLOAT32)


def play_labelled(
    game: AgentGame,
    expert: Expert,
    policy: Policy | None,
    expert_share: float,
    rng: np.random.Generator,
    tick: Callable[[], None],
) -> LabelledGame:
    """Play a game from a drawn training start and have all of its states labelled.

    Args:
        game: Where it is played.
        expert: Who labels; not on the same console.
        policy: Who plays beside the expert; None leaves all to the expert.
        expert_share: Probability with which a step is the expert's.
        rng: Where all chances of the game come from.
        tick: Called after every step; what it raises ends the game.
    """
    (expert_rng,) = rng.spawn(1)
    start = draw_start(rng)
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
        tick()
    seen = Trajectory(np.stack(observations), np.array(labels, np.int64), game.hits, game.end)
    share = None if policy is None else agreed / len(labels)
    return LabelledGame(seen, game.episode.actions, start, share)


class _Training:
    """The training as it stands, which its checkpoint holds.

    An iteration plays games, each of them kept in the checkpoint, and then learns a policy, which
    is kept in a file of its own. What is drawn for a game depends on the training seed and the
    game's number alone.
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
        self._expert = Expert(task.behaviour, Console())
        self._game = AgentGame(Console())
        self._payment = RewardShaping.of(task.model, task.recipe.policy)
        self._games: list[LabelledGame] = []
        self._learned_from = 0
        self.snapshots: list[SnapshotScore] = []
        self._since = time.monotonic()
        self._steps_since = 0

    @property
    def is_done(self) -> bool:
        """Whether all steps have been played and learned from."""
        return self._learned_steps >= self._task.steps

    @property
    def best_steps(self) -> int:
        """Steps of the best policy; of equally good ones the latest."""
        return max(self.snapshots, key=lambda one: (one.predicted_return, one.steps)).steps

    @property
    def best(self) -> Path:
        """File of the best policy."""
        return self._policy_file(self.best_steps)

    @property
    def _steps(self) -> int:
        """Steps played."""
        return sum(game.seen.n_steps for game in self._games)

    @property
    def _learned_steps(self) -> int:
        """Steps that the latest policy was learned from."""
        return self.snapshots[-1].steps if self.snapshots else 0

    def begin(self) -> None:
        """Take the checkpoint up if there is one."""
        if (self._folder / _CHECKPOINT).exists():
            self._load()
        else:
            self._tick(0)
        self._steps_since = self._steps

    def iterate(self) -> None:
        """Play the games of an iteration that are missing, learn from all games, and judge."""
        iteration = len(self.snapshots)
        policy = load_policy(self._policy_file(self._learned_steps)) if iteration else None
        recipe = self._task.recipe
        share = float(recipe.dagger.expert_decay**iteration)
        enough = self._learned_steps + max(1, recipe.dagger.steps_per_iteration)
        while self._steps < min(enough, self._task.steps):
            rng = np.random.default_rng([self._task.training_seed, len(self._games)])
            game = play_labelled(
                self._game,
                self._expert,
                policy,
                share,
                rng,
                lambda: self._tick(self._steps + self._game.steps),
            )
            self._games.append(game)
            self._save()
        self._report(share, self._learn())
        self._learned_from = len(self._games)
        self._save()
        self._drop_superseded()

    def _tick(self, steps: int) -> None:
        """Say where the training is; a cancelled run stops here."""
        self._progress.advance(min(steps, self._task.steps), self._task.steps)

    def _learn(self) -> CloneResult:
        """Learn the next policy from all games, judge it and write it to its file."""
        recipe, steps = self._task.recipe, self._steps

        def tick() -> None:
            self._tick(steps)

        learned, result = clone(
            [game.seen for game in self._games],
            replace(
                recipe.cloning,
                network=recipe.policy.network,
                learning_rate=recipe.policy.learning_rate,
            ),
            self._task.training_seed,
            Ticking(tick),
            self._device,
        )
        learned.set_training_mode(False)
        judged = judge(Policy(learned), self._payment, recipe, tick)
        save_policy(learned, self._policy_file(steps))
        self.snapshots.append(SnapshotScore(steps, judged))
        return result

    def _report(self, share: float, result: CloneResult) -> None:
        """Pass the curves' next point on: means over the iteration's games, and what was learned.

        It comes before the checkpoint, so that a training which goes on leaves no point out.
        """
        points = [self._values(game) for game in self._games[self._learned_from :]]
        values = {name: float(np.mean([point[name] for point in points])) for name in points[0]}
        now = time.monotonic()
        values["steps_per_s"] = (self._steps - self._steps_since) / max(1e-9, now - self._since)
        self._since, self._steps_since = now, self._steps
        values |= {"expert_share": share, "accuracy": result.accuracy}
        if result.left_out_accuracy is not None:
            values["left_out_accuracy"] = result.left_out_accuracy
        done = min(self._steps, self._task.steps)
        self._progress.advance(done, self._task.steps, values)

    def _values(self, game: LabelledGame) -> dict[str, float]:
        seen = game.seen
        scores = self._task.model.score(seen.observations[1:])
        values = {"predicted_return": float(scores.sum(dtype=np.float64))}
        values |= game_values(self._task.behaviour, seen.n_steps, seen.hits, seen.end in DEATHS)
        if game.agreed is not None:
            values["agreement"] = game.agreed
        return values

    # Files

    def _policy_file(self, steps: int) -> Path:
        return self._folder / f"policy-{steps}.zip"

    def _drop_superseded(self) -> None:
        """Remove all policies but the best and the latest."""
        wanted = {self.best, self._policy_file(self._learned_steps)}
        for path in self._folder.glob("policy-*.zip"):
            if path not in wanted:
                path.unlink()

    def _save(self) -> None:
        """Keep the games as their actions, from which a replay makes the observations again."""
        state = {
            "format": FORMAT,
            "version": FORMAT_VERSION,
            "learned_from": self._learned_from,
            "snapshots": [asdict(snapshot) for snapshot in self.snapshots],
            "games": [_stored(game) for game in self._games],
        }
        write_whole(self._folder / _CHECKPOINT, json.dumps(state).encode())

    def _load(self) -> None:
        path = self._folder / _CHECKPOINT
        try:
            state = json.loads(path.read_bytes())
            if (state["format"], state["version"]) != (FORMAT, FORMAT_VERSION):
                raise Invalid(
                    f"{path} is no checkpoint that this version can go on from. Remove it and the"
                    " training begins anew."
                )
            self._learned_from = state["learned_from"]
            self.snapshots = [SnapshotScore(**snapshot) for snapshot in state["snapshots"]]
            for stored in state["games"]:
                # The curves end there.
                self._tick(self._learned_steps)
                self._games.append(_replayed(stored, self._game.console))
        except (ValueError, KeyError, TypeError) as error:
            raise Invalid(f"{path} cannot be read: {error}. Remove it to begin anew.") from error


def _stored(game: LabelledGame) -> dict[str, Any]:
    return {
        "start": asdict(game.start),
        "executed": base64.b64encode(game.executed).decode(),
        "labels": base64.b64encode(bytes(game.seen.actions.tolist())).decode(),
        "agreed": game.agreed,
    }


def _replayed(stored: dict[str, Any], console: Console) -> LabelledGame:
    start, executed = Start(**stored["start"]), base64.b64decode(stored["executed"])
    labels: npt.NDArray[np.int64] = np.frombuffer(base64.b64decode(stored["labels"]), np.uint8)
    seen = trajectory(Recording(start, executed), console)
    return LabelledGame(
        replace(seen, actions=labels.astype(np.int64)), executed, start, stored["agreed"]
    )
