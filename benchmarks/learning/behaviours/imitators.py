"""What becomes of a behaviour that is taught by ranked games and best efforts, in any game.

    python -m benchmarks.learning.behaviours.imitators FOLDER --games pong freeway

Reward, clone and imitator are learned by the recipe `any`, and play from evaluation starts with
sticky actions. Their games are judged by the truth of the behaviour, beside the person's. Prints a
line for each behaviour, and appends it to a file as JSON.
"""

from __future__ import annotations

import argparse
import json
import tempfile
import time
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import torch

from benchmarks.learning.behaviours.games import PlayedGames, load_games, tasks_of, worth_of
from benchmarks.learning.behaviours.orders import ranked_by_person
from trainer.policy.cloning import train_clone
from trainer.policy.evaluation import Actor, beginnings, play
from trainer.policy.imitation import ImitationTask
from trainer.policy.imitator import train_imitator
from trainer.policy.networks import Policy, load_policy, save_policy
from trainer.progress import NullProgress
from trainer.reward.check import check_ranking
from trainer.reward.preference_dataset import (
    GameFacts,
    ObservedTrajectory,
    PerfectDemonstrations,
    PreferenceDataset,
)
from trainer.reward.reward_trainer import train_reward_model
from trainer.reward.statements import understanding_of
from trainer.runtime.run_data import N_VARIED
from tril.recipes import recipe_named, with_values
from tril.recording import trajectory
from tril.vocabulary.making import varied_games
from tril.vocabulary.sentences import tell
from tril.vocabulary.trace import trace


class Taught:
    """A behaviour that is taught by some of its player's games.

    Args:
        played: The games of all behaviours of the game.
        task: Index of the behaviour.
        n_ranked: Games that are ranked.
        n_best: Best efforts.
        seed: Draws them, and seeds the training.
        changes: Of the recipe, by path.
    """

    def __init__(
        self,
        played: PlayedGames,
        task: int,
        n_ranked: int,
        n_best: int,
        seed: int,
        changes: dict[str, Any],
    ) -> None:
        self.played = played
        self.task = played.tasks[task]
        self.seed = seed
        self.recipe = with_values(recipe_named("any", played.game.pretrained), changes)
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
        played = trace(recording, self._console, self.played.words.background)
        return trajectory(recording, self._console), self.played.words.facts(played)

    def judge(self, actor: Actor) -> dict[str, float]:
        """Let a policy play from the evaluation starts, with sticky actions."""
        game = self.played.game
        numbers = range(game.starts.n_evaluation)
        starts = beginnings(game, self.recipe.evaluation, list(numbers))
        games = play(game, actor, starts, "sticky", n_processes=1)
        worths = []
        for one in games:
            seen = trace(one.recording, self._console, self.played.words.background)
            worths.append(worth_of(self.task, seen, game.clock.max_steps))
        return {
            "worth": float(np.mean(worths)),
            "died": float(np.mean([one.died for one in games])),
        }

    def run(self, steps: int) -> dict[str, Any]:
        """Teach it; returns the figures."""
        began = time.monotonic()
        dataset = self.dataset()
        understood = understanding_of(dataset)
        told = tell(self.played.words, understood.posterior, self.played.game)
        model = train_reward_model(dataset, self.seed, NullProgress())
        check, model = check_ranking(model, dataset, self.seed, NullProgress())
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
        return {
            "game": self.played.game.name,
            "task": self.task.name,
            "half": self.task.half,
            "ranked": len(self.ranked),
            "best": len(self.best),
            "seed": self.seed,
            "steps": steps,
            "told": [f"{one.probability:.2f} {one.sentence}" for one in told],
            "passed": check.passed,
            "tau": check.tau,
            "held_out": check.held_out_accuracy,
            "imitator": self.judge(imitator),
            "clone": self.judge(Policy(clone)),
            "best_efforts": float(self.worth[self.best].mean()),
            "ranked_games": float(self.worth[self.ranked].mean()),
            "reward_s": round(reward_s),
            "clone_s": round(clone_s),
            "seconds": round(seconds),
        }


def main() -> None:
    """Teach the behaviours."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--half", choices=("development", "report"), default="development")
    parser.add_argument("--games", nargs="*", default=())
    parser.add_argument("--tasks", nargs="*", default=())
    parser.add_argument("--ranked", type=int, default=12)
    parser.add_argument("--best", type=int, default=12)
    parser.add_argument("--steps", type=int, default=300_000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--set", action="append", default=[], metavar="PATH=VALUE")
    parser.add_argument("--ledger", type=Path)
    arguments = parser.parse_args()
    torch.set_num_threads(1)
    changes = dict(one.split("=", 1) for one in arguments.set)
    for name, tasks in tasks_of(arguments.half, arguments.folder, arguments.games).items():
        asked = [one for one in tasks if not arguments.tasks or one.name in arguments.tasks]
        played = load_games(arguments.folder, name, asked)
        for index in range(len(asked)):
            taught = Taught(
                played, index, arguments.ranked, arguments.best, arguments.seed, changes
            )
            line = json.dumps(taught.run(arguments.steps) | {"changes": changes})
            print(line, flush=True)
            if arguments.ledger:
                with arguments.ledger.open("a") as file:
                    file.write(line + "\n")


if __name__ == "__main__":
    main()
