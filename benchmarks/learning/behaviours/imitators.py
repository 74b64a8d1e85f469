"""What becomes of a behaviour that is taught by ranked games and best efforts, in any game.

    python -m benchmarks.learning.behaviours.imitators FOLDER --half report --games pong
    python -m benchmarks.learning.behaviours.imitators FOLDER --half report --recipe paper
    python -m benchmarks.learning.behaviours.imitators FOLDER --half report --reward truth

Reward, clone and imitator are learned by a recipe, and play from evaluation starts with sticky
actions, beside a tape of the best efforts. Their games are judged by the truth of the behaviour,
as the person's are. Prints a line for each behaviour, and appends it to a file as JSON; the
folder keeps a game of each player for `benchmarks.learning.behaviours.pages`. With `--reward truth`
the network of `any` reads the behaviour's true worth off the screen, not what a statement says of
it: the bound of what a ranking can teach.
"""

from __future__ import annotations

import argparse
import json
import tempfile
import time
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import torch

from benchmarks.learning.behaviours.games import (
    PlayedGames,
    load_games,
    path_of,
    tasks_of,
    to_row,
    worth_by_step,
    worth_of,
)
from benchmarks.learning.behaviours.orders import ranked_by_person
from benchmarks.learning.behaviours.suite import EVENT_STEPS, SPLITS
from trainer.policy.cloning import train_clone
from trainer.policy.evaluation import Actor, EvaluatedGame, beginnings, play
from trainer.policy.imitation import ImitationTask
from trainer.policy.imitator import train_imitator
from trainer.policy.networks import Policy, load_policy, save_policy
from trainer.progress import NullProgress
from trainer.reward.check import check_ranking
from trainer.reward.model import RewardModel
from trainer.reward.preference_dataset import (
    GameFacts,
    ObservedTrajectory,
    PerfectDemonstrations,
    PreferenceDataset,
)
from trainer.reward.reward_trainer import calibrate_reading, train_reward_model
from trainer.reward.statements import levels_of_facts, reading_network, understanding_of
from trainer.runtime.run_data import N_VARIED
from tril.games.base import Controls, Opening, Start
from tril.recipes import recipe_named, with_values
from tril.recording import Recording, Trajectory, trajectory
from tril.vocabulary.making import varied_games
from tril.vocabulary.sentences import tell
from tril.vocabulary.trace import trace


@dataclass(frozen=True)
class Judged:
    """Games of a policy from the evaluation starts.

    Attributes:
        worths: Worth of each game by the behaviour, float64 (n_games,).
        games: The games.
    """

    worths: npt.NDArray[np.float64]
    games: Sequence[EvaluatedGame]

    @property
    def median(self) -> Recording:
        """The game of median worth."""
        return self.games[int(np.argsort(self.worths)[len(self.games) // 2])].recording

    def figures(self) -> dict[str, float]:
        """Return the mean worth and the share of games that were lost."""
        died = float(np.mean([one.died for one in self.games]))
        return {"worth": float(self.worths.mean()), "died": died}


class Tape:
    """Replays, in one game, the best effort that begins most like it.

    Args:
        best: The best efforts.
        controls: The game's actions.
    """

    def __init__(self, best: Sequence[Trajectory], controls: Controls) -> None:
        self._best = best
        self._controls = controls
        self._actions: npt.NDArray[np.int64] | None = None
        self._step = 0

    def probabilities(self, observations: npt.NDArray[np.uint8]) -> npt.NDArray[np.float32]:
        """Return 1 for the tape's next action, float32 (1, n_actions); then noop."""
        if self._actions is None:
            apart = [
                np.abs(one.observations[0].astype(np.int16) - observations[0]).mean()
                for one in self._best
            ]
            self._actions = self._best[int(np.argmin(apart))].actions
        chosen = np.zeros((1, self._controls.n_actions), np.float32)
        is_over = self._step >= len(self._actions)
        chosen[0, self._controls.noop if is_over else self._actions[self._step]] = 1
        self._step += 1
        return chosen


class Taught:
    """A behaviour that is taught by some of its player's games.

    Args:
        played: The games of all behaviours of the game.
        task: Index of the behaviour.
        n_ranked: Games that are ranked.
        n_best: Best efforts.
        seed: Draws them, and seeds the training.
        recipe: The recipe.
        reward: "order", or "truth" for the behaviour's true worth.
        changes: Of the recipe, by path.
    """

    def __init__(
        self,
        played: PlayedGames,
        task: int,
        n_ranked: int,
        n_best: int,
        seed: int,
        recipe: str,
        reward: str,
        changes: dict[str, Any],
    ) -> None:
        self.played = played
        self.task = played.tasks[task]
        self.seed = seed
        self.reward = reward
        self.recipe = with_values(recipe_named(recipe, played.game.pretrained), changes)
        rng = np.random.default_rng(
            zlib.crc32(f"{played.game.name}{self.task.name}{seed}".encode())
        )
        mine = played.task == task
        own = rng.permutation(np.flatnonzero(mine & ~played.is_best))[:n_ranked]
        best = rng.permutation(np.flatnonzero(mine & played.is_best))[:n_best]
        self.worth = played.worths[:, task]
        self.tiers = ranked_by_person(self.worth, own, rng)
        self.ranked = [row for tier in self.tiers for row in tier]
        self.best = best.tolist()
        self._console = played.game.make_console()

    def dataset(self) -> PreferenceDataset:
        """Return what the reward is learned from."""
        varied = [self._observed(one) for one in varied_games(self.played.game, N_VARIED)]
        ranked = [self._observed(self.played.recordings[row]) for row in self.ranked]
        best = [self._observed(self.played.recordings[row]) for row in self.best]
        facts = GameFacts(
            self.played.words,
            [facts for _, facts in ranked],
            [facts for _, facts in best],
            [ObservedTrajectory(one.observations, facts=facts) for one, facts in varied],
        )
        return PreferenceDataset.from_demonstrations(
            [one for one, _ in ranked],
            [[index] for index in range(len(ranked))],
            self.recipe.reward,
            PerfectDemonstrations([one for one, _ in best], [None] * len(best)),
            facts,
        )

    def _observed(self, recording: Any) -> tuple[Any, npt.NDArray[np.float32]]:
        played = trace(recording, self._console, self.played.words.scene)
        return trajectory(recording, self._console), self.played.words.facts(played)

    def _true_reward(self, dataset: PreferenceDataset) -> RewardModel:
        """Return a model whose network reads the behaviour's worth off the screen."""
        recordings = [
            *(self.played.recordings[row] for row in (*self.ranked, *self.best)),
            *varied_games(self.played.game, N_VARIED),
        ]
        observations, worths = [], []
        for seen, recording in zip(
            (*dataset.trajectories, *dataset.varied), recordings, strict=True
        ):
            worth = worth_by_step(
                self.task, trace(recording, self._console, self.played.words.scene)
            )
            # The observation at the start has no step; a step cut short by the end has no worth.
            n_steps = min(len(seen.observations) - 1, len(worth))
            observations.append(seen.observations[1 : n_steps + 1])
            worths.append(worth[:n_steps, None])
        most = float(EVENT_STEPS if self.task.counts_events else 1)
        network = reading_network(
            observations,
            (np.concatenate(worths) / most).clip(0, 1).astype(np.float32),
            np.array([most]),
            self.recipe.reward.updates,
            (self.seed, 0),
            NullProgress(),
        )
        return calibrate_reading(network, dataset, None)

    def judge(self, actor: Actor) -> Judged:
        """Let a policy play from the evaluation starts, with sticky actions."""
        return self._judged(play(self.played.game, actor, self._starts(), "sticky", n_processes=1))

    def judge_tape(self, best: Sequence[Trajectory]) -> Judged:
        """Let tapes of the best efforts play from the evaluation starts, with sticky actions."""
        game = self.played.game
        tapes = [(Tape(best, game.controls), one) for one in self._starts()]
        return self._judged(
            [play(game, tape, [one], "sticky", n_processes=1)[0] for tape, one in tapes]
        )

    def _starts(self) -> list[Start | Opening]:
        game = self.played.game
        # Those of `any` for every recipe, so that all are judged alike.
        recipe = recipe_named("any", game.pretrained).evaluation
        return beginnings(game, recipe, list(range(game.starts.n_evaluation)))

    def _judged(self, games: Sequence[EvaluatedGame]) -> Judged:
        horizon = self.played.game.clock.max_steps
        worths = []
        for one in games:
            seen = trace(one.recording, self._console, self.played.words.scene)
            worths.append(worth_of(self.task, seen, horizon))
        return Judged(np.array(worths), games)

    def run(self, steps: int) -> tuple[dict[str, Any], dict[str, Judged]]:
        """Teach it; returns the figures and the games of imitator, clone and tape."""
        began = time.monotonic()
        dataset = self.dataset()
        if self.reward == "truth":
            model, learned = self._true_reward(dataset), {}
        else:
            model = train_reward_model(dataset, self.seed, NullProgress())
            check, model = check_ranking(model, dataset, self.seed, NullProgress())
            learned = {
                "told": self._told(dataset),
                "passed": check.passed,
                "tau": check.tau,
                "held_out": check.held_out_accuracy,
            }
        reward_s = time.monotonic() - began
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "clone.zip"
            console = self._console
            best = [trajectory(self.played.recordings[row], console) for row in self.best]
            n_actions = self.played.game.controls.n_actions
            clone, _ = train_clone(best, n_actions, self.recipe.cloning, self.seed, NullProgress())
            save_policy(clone, path)
            clone_s = time.monotonic() - began - reward_s
            task = ImitationTask(
                game=self.played.game,
                model=model,
                recordings=[self.played.recordings[row] for row in self.ranked],
                tiers=[[index] for index in range(len(self.ranked))],
                recipe=self.recipe,
                steps=steps,
                training_seed=self.seed,
                perfect=[self.played.recordings[row] for row in self.best],
                start_policy=path,
            )
            scratch = Path(folder) / "imitator"
            scratch.mkdir()
            imitator_path = Path(folder) / "imitator.zip"
            train_imitator(task, imitator_path, scratch, NullProgress(), n_processes=1)
            imitator = load_policy(imitator_path)
        seconds = time.monotonic() - began
        judged = {
            "imitator": self.judge(imitator),
            "clone": self.judge(Policy(clone)),
            "tape": self.judge_tape(best),
        }
        figures = {
            "game": self.played.game.name,
            "task": self.task.name,
            "half": self.task.half,
            "recipe": self.recipe.name,
            "reward": self.reward,
            "ranked": len(self.ranked),
            "best": len(self.best),
            "seed": self.seed,
            "steps": steps,
            **learned,
            **{player: games.figures() for player, games in judged.items()},
            **self._levels(model, dataset, judged),
            "best_efforts": float(self.worth[self.best].mean()),
            "ranked_games": float(self.worth[self.ranked].mean()),
            "reward_s": round(reward_s),
            "clone_s": round(clone_s),
            "seconds": round(seconds),
        }
        return figures, judged

    def _levels(
        self, model: RewardModel, dataset: PreferenceDataset, judged: Mapping[str, Judged]
    ) -> dict[str, dict[str, float]]:
        """Return each policy's sums of levels: by facts of replays, and read off the screen."""
        if self.reward == "truth" or self.recipe.reward.method != "statement":
            return {}
        understanding = understanding_of(dataset)
        levels = {}
        for policy in ("imitator", "clone"):
            by_facts, read = [], []
            for game in judged[policy].games:
                seen, facts = self._observed(game.recording)
                by_facts.append(float(levels_of_facts(model, understanding, facts).sum()))
                read.append(float(model.level(model.score(seen.observations[1:])).sum()))
            levels[f"{policy}_levels"] = {
                "by_facts": float(np.mean(by_facts)),
                "read": float(np.mean(read)),
                "correlation": float(np.corrcoef(by_facts, read)[0, 1]),
            }
        return levels

    def _told(self, dataset: PreferenceDataset) -> list[str]:
        if self.recipe.reward.method != "statement":
            return []
        posterior = understanding_of(dataset).posterior
        told = tell(self.played.words, posterior, self.played.game)
        return [f"{one.probability:.2f} {one.sentence}" for one in told]

    def keep(self, path: Path, figures: dict[str, Any], judged: Mapping[str, Judged]) -> None:
        """Write the figures, and games that a page shows: ranked ones and each player's median.

        Args:
            path: The file, of JSON.
            figures: As `run` returns them.
            judged: As `run` returns them.
        """
        rows = [self.played.recordings[row] for row in self.ranked]
        best = self.played.recordings[max(self.best, key=lambda row: float(self.worth[row]))]
        games = {
            "ranked": [to_row(one.start, one.actions) for one in rows],
            "ranked_worths": self.worth[self.ranked].tolist(),
            "best_effort": to_row(best.start, best.actions),
        }
        of_players = {
            player: to_row(games.median.start, games.median.actions)
            for player, games in judged.items()
        }
        path.write_text(json.dumps(figures | {"games": games | of_players}), encoding="utf-8")


def main() -> None:
    """Teach the behaviours."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--half", choices=SPLITS, default="development")
    parser.add_argument("--games", nargs="*", default=())
    parser.add_argument("--tasks", nargs="*", default=())
    parser.add_argument("--recipe", choices=("any", "paper", "gail"), default="any")
    parser.add_argument("--reward", choices=("order", "truth"), default="order")
    parser.add_argument("--ranked", type=int, default=12)
    parser.add_argument("--best", type=int, default=12)
    parser.add_argument("--steps", type=int, default=300_000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--set", action="append", default=[], metavar="PATH=VALUE")
    parser.add_argument("--ledger", type=Path)
    arguments = parser.parse_args()
    if arguments.reward == "truth" and arguments.recipe != "any":
        parser.error("--reward truth takes the recipe any")
    torch.set_num_threads(1)
    changes = dict(one.split("=", 1) for one in arguments.set)
    for name, tasks in tasks_of(arguments.half, arguments.folder, arguments.games).items():
        asked = [one for one in tasks if not arguments.tasks or one.name in arguments.tasks]
        played = load_games(arguments.folder, name, asked)
        for index in range(len(asked)):
            taught = Taught(
                played,
                index,
                arguments.ranked,
                arguments.best,
                arguments.seed,
                arguments.recipe,
                arguments.reward,
                changes,
            )
            figures, judged = taught.run(arguments.steps)
            figures |= {"changes": changes}
            line = json.dumps(figures)
            print(line, flush=True)
            if arguments.ledger:
                with arguments.ledger.open("a") as file:
                    file.write(line + "\n")
            of_reward = "truth" if arguments.reward == "truth" else arguments.recipe
            kept = f"{of_reward}-{arguments.seed}.trained"
            path = path_of(arguments.folder, asked[index]).with_suffix(f".{kept}.json")
            taught.keep(path, figures, judged)


if __name__ == "__main__":
    main()
