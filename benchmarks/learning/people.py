"""What an imitator learns from games like a person's, and from further ranked games.

    python -m benchmarks.learning.people -b column-3 --demonstrations person-250 --steps 200000
    python -m benchmarks.learning.people -b column-3 --varied-games 24
    python -m benchmarks.learning.people -b column-3 --rounds 4 --answers 8

A scripted player with a person's limits plays twelve games to be ranked and twelve best efforts;
the order is by outcome, with three swaps of neighbours. `--varied-games` are games of varied play
that are inserted into the order, or, with `--unsorted`, put below the worst, or, with
`--bulk-answers`, sorted by a few answers that each put many of them into one tier. With `--rounds`
the training is interrupted: some of the imitator's own games are inserted into the order (one
answer in ten is wrong), and the reward is learned anew. With `--ranked-alone` the best ranked games
stand in for best efforts; with `--ranked-games` and `--best-efforts` there are fewer than twelve.
With `--attempts` a person who plans no game tries again and again to do all of the behaviour, see
benchmarks.learning.attempts; the best three games are ranked and marked as perfect. The imitator is
judged on the 32 evaluation starts with their openings, greedily and with sticky actions, and
without openings.

Prints the figures and appends them to a ledger, a line of JSON a training, with each game's outcome
and the digests of the recipe, of the weights that ship with Tril, of what infers the wanted aliens
and of the demonstrations; benchmarks.learning.people_table makes tables of it. 600,000 steps take
six to nine minutes on one of two cores.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import tempfile
import time
from collections.abc import Sequence
from copy import deepcopy
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import torch

from benchmarks.learning.attempts import attempt
from benchmarks.learning.few_games import keep_evenly
from benchmarks.learning.own_behaviours import BEHAVIOURS
from testsupport.space_invaders import EVALUATION_STARTS
from trainer.nn.precision import Precision
from trainer.policy.cloning import train_clone
from trainer.policy.evaluation import EvaluatedGame, play
from trainer.policy.imitation import ImitationTask
from trainer.policy.imitator import train_imitator
from trainer.policy.networks import Policy, load_policy, save_policy
from trainer.progress import NullProgress
from trainer.reporting.digests import inference_digest, recipe_digest, weights_digest
from trainer.reward.check import check_ranking, final_level
from trainer.reward.model import RewardModel
from trainer.reward.preference_dataset import PerfectDemonstrations, PreferenceDataset
from trainer.reward.pretraining import read_features
from trainer.reward.reward_trainer import train_reward_model
from tril.demonstrators import example_tasks, execute, kind_named
from tril.demonstrators.judging import merit, swap_neighbours
from tril.demonstrators.random_play import play_randomly
from tril.demonstrators.space_invaders.varied_play import play_varied
from tril.games.atari.starts import EVALUATION_START_COUNT, TRAINING_IDLE_FRAMES, AtariStart
from tril.games.base import Cell, Console, Opening, Start
from tril.games.behaviours import Behaviour, Score, score
from tril.games.space_invaders import SPACE_INVADERS
from tril.games.space_invaders.ends import DEATHS
from tril.games.space_invaders.memory import FRAMES_PER_STEP
from tril.ranking import best_ranked, kendall_tau, normalise
from tril.recipes import FAST, Recipe, with_values
from tril.recording import Recording, Trajectory, trajectory
from tril.store.training.evaluations import ActionSelection

REWARDS = ("ranking", "hits", "shuffled")
"""What the reward is learned from: the ranking, the true hits, the games in a random order."""

N_SCORED = 96
"""Games of varied play whose true hits a reward is fitted to."""

N_MISTAKES, N_MARKED, ATTEMPTS_PER_RANDOM_GAME = 3, 3, 4
"""Of a person who plans no game: swapped neighbours, games marked as perfect, and attempts per game
of random play."""

WRONG_ANSWERS = 0.1
"""Share of the answers about the imitator's games that put them in a random place."""

N_UNSEEN_VARIED = 48
"""Games of varied play that the learned reward is judged on."""

OPENINGS = [
    SPACE_INVADERS.starts.evaluation_opening(number) for number in range(EVALUATION_START_COUNT)
]

Merit = tuple[int, int]


@dataclass
class Ranked:
    """Ranked games and the order that a scripted person gives them.

    Attributes:
        behaviour: What the order is by.
        recordings: The games.
        trajectories: Their trajectories.
        merits: Their true worth.
        tiers: Indices of them, best tier first.
    """

    behaviour: Behaviour
    recordings: list[Recording] = field(default_factory=list)
    trajectories: list[Trajectory] = field(default_factory=list)
    merits: list[Merit] = field(default_factory=list)
    tiers: list[list[int]] = field(default_factory=list)

    def add(self, recording: Recording, console: Console) -> int:
        """Add a game without ranking it; return its index."""
        seen = trajectory(recording, console)
        self.recordings.append(recording)
        self.trajectories.append(seen)
        self.merits.append(merit(self.behaviour, _cells(seen.taken), seen.end))
        return len(self.merits) - 1

    def levels(self, model: RewardModel) -> list[float]:
        """Return the level that each game ends at."""
        return [final_level(model.level(model.score(t.observations))) for t in self.trajectories]

    def order(self, n_mistakes: int, rng: np.random.Generator) -> None:
        """Rank all games by their merit, with swaps of neighbours."""
        tiers: dict[Merit, list[int]] = {}
        for index, worth in enumerate(self.merits):
            tiers.setdefault(worth, []).append(index)
        true = normalise(tiers[worth] for worth in sorted(tiers, reverse=True))
        self.tiers = [list(tier) for tier in swap_neighbours(true, n_mistakes, rng).tiers]

    def keep_evenly(self, n_games: int) -> None:
        """Drop all games but so many, evenly from the best to the worst."""
        ranking = keep_evenly(normalise(self.tiers), n_games)
        kept = {index: place for place, index in enumerate(ranking.items)}
        self.tiers = [[kept[index] for index in tier] for tier in ranking.tiers]
        self.recordings = [self.recordings[index] for index in kept]
        self.trajectories = [self.trajectories[index] for index in kept]
        self.merits = [self.merits[index] for index in kept]

    def insert(self, index: int, rng: np.random.Generator) -> None:
        """Rank one more game, beside equals if there are any; one answer in ten is wrong."""
        if rng.random() < WRONG_ANSWERS:
            self.tiers.insert(int(rng.integers(len(self.tiers) + 1)), [index])
            return
        worth = self.merits[index]
        for tier in self.tiers:
            if worth in {self.merits[other] for other in tier}:
                tier.append(index)
                return
        self.insert_together([index])

    def insert_together(self, indices: Sequence[int]) -> None:
        """Rank games in a tier of their own, where their mean worth belongs."""
        worth = np.mean([self.merits[index][0] for index in indices])
        means = [np.mean([self.merits[other][0] for other in tier]) for tier in self.tiers]
        self.tiers.insert(sum(bool(mean > worth) for mean in means), [*indices])

    def insert_in_bulk(self, indices: Sequence[int], n_answers: int) -> None:
        """Rank games by a few answers, each of which puts many at once into a tier."""
        ordered = sorted(indices, key=lambda index: self.merits[index])
        for part in np.array_split(ordered, n_answers):
            if len(part):
                self.insert_together(part.tolist())


def _score(behaviour: Behaviour, hits: Sequence[Any]) -> Score:
    found = score(behaviour, _cells(hits))
    assert found is not None
    return found


def _cells(hits: Sequence[Any]) -> tuple[Cell, ...]:
    return tuple((hit.row, hit.column) for hit in hits)


def judge(
    policy: Policy,
    behaviour: Behaviour,
    model: RewardModel,
    starts: Sequence[Start | Opening],
    how: ActionSelection,
) -> dict[str, Any]:
    """Return a policy's figures over games, and how far the reward model agrees with them."""
    games = play(SPACE_INVADERS, policy, starts, how, model=model)
    figures = [_figures(behaviour, game) for game in games]
    levels = [final_level(model.level(g.rewards)) for g in games if g.rewards is not None]
    worths = [merit(behaviour, _cells(game.taken), game.end) for game in games]
    return {name: float(np.mean([one[name] for one in figures])) for name in figures[0]} | {
        "level": float(np.mean(levels)),
        "tau": _tau(worths, levels),
        "games": {name: [int(one[name]) for one in figures] for name in figures[0]},
    }


class UnseenGames:
    """Games of others that a learned reward should order as they are worth.

    Args:
        behaviour: What they are worth something in.
        console: The console to play on.
    """

    def __init__(self, behaviour: Behaviour, console: Console) -> None:
        rng = np.random.default_rng(2_000_003)
        self._console = console
        self._own, self._varied = Ranked(behaviour), Ranked(behaviour)
        for kind in ("scripted", "person-150"):
            for one in execute(example_tasks(behaviour, rng, 1, kind_named(kind))):
                self._own.add(one.recording, console)
        self._clean = [
            index
            for index, seen in enumerate(self._own.trajectories)
            if not _score(behaviour, seen.taken).strays
        ]
        for _ in range(N_UNSEEN_VARIED):
            self._varied.add(play_varied(rng, console).recording, console)

    @property
    def kinds(self) -> dict[str, Ranked]:
        """The games: own ones of the behaviour, and games of varied play."""
        return {"own": self._own, "varied": self._varied}

    def taus(self, model: RewardModel) -> dict[str, float | None]:
        """Return Kendall's tau of final levels with the games' worth, by kind of games.

        The clean ones are the own games without a stray, which their targets tell apart.
        """
        own = self._own.levels(model)
        return {
            "tau_own": _tau(self._own.merits, own),
            "tau_clean": _tau(
                [self._own.merits[i] for i in self._clean], [own[i] for i in self._clean]
            ),
            "tau_varied": _tau(self._varied.merits, self._varied.levels(model)),
            "epic": self.epic_distance(model),
        }

    def epic_distance(self, model: RewardModel) -> float:
        """Return the EPIC distance of R to (targets - strays), over the states of all games.

        Gleave et al. 2021, definition 4.6. Both rewards depend on the state that a step leads to
        alone, so canonicalising adds a constant, and what is left is the Pearson distance: 0 for
        rewards that differ by a positive factor and a constant, 1 for opposite ones.
        """
        learned, true = [], []
        for games in self.kinds.values():
            for seen in games.trajectories:
                learned.append(model.score(seen.observations[1:]))
                true.append(hit_worth(games.behaviour, seen)[1:])
        correlation = np.corrcoef(np.concatenate(learned), np.concatenate(true))[0, 1]
        return float(np.sqrt((1 - correlation) / 2))


def _tau(worths: Sequence[Merit], levels: Sequence[float]) -> float | None:
    """Return Kendall's tau between worth and levels; None if all games are worth the same."""
    tiers: dict[Merit, list[int]] = {}
    for index, worth in enumerate(worths):
        tiers.setdefault(worth, []).append(index)
    order = [tiers[worth] for worth in sorted(tiers, reverse=True)]
    return kendall_tau(order, levels) if len(order) > 1 else None


def _figures(behaviour: Behaviour, game: EvaluatedGame) -> dict[str, float]:
    found = _score(behaviour, game.taken)
    assert behaviour.target is not None
    died = game.end in DEATHS
    flawless = found.targets == len(behaviour.target) and not found.strays and not died
    return {
        "targets": found.targets,
        "strays": found.strays,
        "died": died,
        "perfect": flawless and not found.order_errors,
    }


def hit_worth(behaviour: Behaviour, seen: Trajectory) -> npt.NDArray[np.float32]:
    """Return targets hit minus strays at each state of a trajectory, float32 (T + 1,)."""
    assert behaviour.target is not None
    worth = np.zeros(len(seen.observations), np.float32)
    for hit in seen.taken:
        step = -(-hit.frame // FRAMES_PER_STEP)
        worth[step:] += 1.0 if (hit.row, hit.column) in behaviour.target else -1.0
    return worth


def fitted_to_hits(model: RewardModel, games: Ranked) -> RewardModel:
    """Return a pretrained model whose output is fitted to the true hits, by ridge regression.

    PPO on it is the bound of what a ranking can teach: R is (targets - strays) of all targets, as
    far as what the network reads off the screen tells.
    """
    behaviour = games.behaviour
    assert behaviour.target is not None
    network = deepcopy(model.network)
    size = network.output.in_features
    products, sums = torch.zeros(size + 1, size + 1), torch.zeros(size + 1)
    for seen in games.trajectories:
        read = read_features(seen.observations)
        inputs = torch.cat([read, torch.ones(len(read), 1)], 1)
        products += inputs.T @ inputs
        sums += inputs.T @ torch.from_numpy(hit_worth(behaviour, seen) / len(behaviour.target))
    solution = torch.linalg.solve(products + torch.eye(size + 1), sums)
    with torch.no_grad():
        network.output.weight.copy_(solution[None, :-1])
        network.output.bias.copy_(solution[-1:])
    return RewardModel(network)


class Lesson:
    """A scripted person's demonstrations, and the imitator that learns from them.

    Args:
        arguments: Of the command line.
    """

    def __init__(self, arguments: argparse.Namespace) -> None:
        self.arguments = arguments
        self.behaviour = BEHAVIOURS[arguments.behaviour]
        self.recipe: Recipe = with_values(FAST, dict(one.split("=", 1) for one in arguments.set))
        self.seed: int = arguments.training_seed
        self.console = SPACE_INVADERS.make_console()
        self.rng = np.random.default_rng([self.seed, 1_000_039])
        self.ranked = Ranked(self.behaviour)
        self.perfect: list[Recording] = []
        self.ranked_as: list[int | None] = []
        if arguments.attempts:
            n_mistakes = N_MISTAKES
            self._show_attempts()
        else:
            n_mistakes = self._show_kind()
        self._add_varied_games(n_mistakes)
        if arguments.reward == "shuffled":
            np.random.default_rng([self.seed, 3]).shuffle(self.ranked.tiers)
        if arguments.ranked_alone:
            best = best_ranked(self.ranked.tiers)
            self.perfect = [self.ranked.recordings[index] for index in best]
            self.ranked_as = [None] * len(best)
        self.seen = [trajectory(recording, self.console) for recording in self.perfect]
        self.unseen = UnseenGames(self.behaviour, self.console)

    def _show_kind(self) -> int:
        """Show games that are planned; return how many mistakes there are in their order."""
        kind = kind_named(self.arguments.demonstrations)
        best_efforts = []
        for one in execute(
            example_tasks(self.behaviour, np.random.default_rng(self.seed), kind=kind)
        ):
            if one.perfect:
                best_efforts.append(one.recording)
            else:
                self.ranked.add(one.recording, self.console)
        self.ranked.order(kind.n_mistakes, self.rng)
        if self.arguments.ranked_games < len(self.ranked.recordings):
            self.ranked.keep_evenly(self.arguments.ranked_games)
        self.perfect = best_efforts[: self.arguments.best_efforts]
        self.ranked_as = [None] * len(self.perfect)
        return kind.n_mistakes

    def _show_attempts(self) -> None:
        """Show attempts and random play; the best are ranked and marked as perfect."""
        rng = np.random.default_rng(self.seed)
        for _ in range(self.arguments.attempts):
            self.ranked.add(attempt(self.behaviour, rng, self.console), self.console)
        for _ in range(self.arguments.attempts // ATTEMPTS_PER_RANDOM_GAME):
            self.ranked.add(play_randomly(rng, self.console).recording, self.console)
        self.ranked.order(0, self.rng)
        marked = [index for tier in self.ranked.tiers for index in tier][:N_MARKED]
        self.perfect = [self.ranked.recordings[index] for index in marked]
        self.ranked_as = [*marked]
        self.ranked.order(min(N_MISTAKES, len(self.ranked.tiers) // 2), self.rng)

    def _add_varied_games(self, n_mistakes: int) -> None:
        play_one = play_randomly if self.arguments.random_play else play_varied
        games = [
            self.ranked.add(play_one(self.rng, self.console).recording, self.console)
            for _ in range(self.arguments.varied_games)
        ]
        if games and self.arguments.unsorted:
            self.ranked.tiers.append(games)
        elif self.arguments.bulk_answers:
            self.ranked.insert_in_bulk(games, self.arguments.bulk_answers)
        elif games:
            self.ranked.order(n_mistakes, self.rng)

    def _scored_games(self) -> Ranked:
        rng = np.random.default_rng([self.seed, 1_000_081])
        games = Ranked(self.behaviour)
        for one in execute(example_tasks(self.behaviour, rng, n_perfect=12)):
            games.add(one.recording, self.console)
        for _ in range(N_SCORED):
            games.add(play_varied(rng, self.console).recording, self.console)
        return games

    def digest(self) -> str:
        """Return eight hexadecimal digits that change when a game or its rank does."""
        digest = hashlib.blake2b(json.dumps(self.ranked.tiers).encode(), digest_size=4)
        for recording in (*self.ranked.recordings, *self.perfect):
            digest.update(f"{recording.start}".encode() + recording.actions)
        return digest.hexdigest()

    def dataset(self) -> PreferenceDataset:
        """Return what the reward is learned from, by the ranking as it is now."""
        recipe = self.recipe.reward
        perfect = PerfectDemonstrations(self.seen, self.ranked_as)
        ranked = self.ranked
        return PreferenceDataset.from_demonstrations(
            ranked.trajectories, ranked.tiers, recipe, perfect
        )

    def train(self, folder: Path) -> dict[str, Any]:
        """Train the clone, then reward and imitator in rounds; return all figures."""
        clone, _ = train_clone(self.seen, 6, self.recipe.cloning, self.seed, NullProgress())
        start = folder / "clone.zip"
        save_policy(clone, start)
        rounds = []
        for number in range(self.arguments.rounds):
            began = time.monotonic()
            dataset = self.dataset()
            model = train_reward_model(dataset, self.seed, NullProgress())
            if self.arguments.reward == "hits":
                model = fitted_to_hits(model, self._scored_games())
            learned = time.monotonic()
            taus = self.unseen.taus(model)
            print(number, json.dumps(taus), flush=True)
            check = None
            if self.arguments.check:
                check, _ = check_ranking(model, dataset, self.seed, NullProgress())
            place = folder / str(number)
            place.mkdir()
            start = self._imitate(model, start, place, number)
            imitator = load_policy(start)
            found = {
                "sticky": judge(imitator, self.behaviour, model, OPENINGS, "sticky"),
                "greedy": judge(imitator, self.behaviour, model, OPENINGS, "greedy"),
                "idle starts": judge(imitator, self.behaviour, model, EVALUATION_STARTS, "greedy"),
                "reward_s": learned - began,
                "imitator_s": time.monotonic() - learned,
                "n_ranked": len(self.ranked.recordings),
                **taus,
            }
            if check:
                found |= {"tau": check.tau, "held_out_accuracy": check.held_out_accuracy}
            print(number, json.dumps(found), flush=True)
            rounds.append(found)
            if number + 1 < self.arguments.rounds:
                self._answer(imitator, number)
        judged = judge(Policy(clone), self.behaviour, model, OPENINGS, "sticky")
        return {"rounds": rounds, "clone": judged}

    def _imitate(self, model: RewardModel, start: Path, folder: Path, number: int) -> Path:
        task = ImitationTask(
            game=SPACE_INVADERS,
            model=model,
            recordings=self.ranked.recordings,
            tiers=self.ranked.tiers,
            recipe=self.recipe,
            steps=self.arguments.steps // self.arguments.rounds,
            training_seed=100 * self.seed + number,
            behaviour=self.behaviour,
            perfect=self.perfect,
            start_policy=start,
        )
        path = folder / "imitator.zip"
        precision = Precision.of("auto", torch.device("cpu"))
        train_imitator(task, path, folder, NullProgress(), precision=precision)
        return path

    def _answer(self, imitator: Policy, number: int) -> None:
        """Insert some of the imitator's games from training starts into the order."""
        rng = np.random.default_rng([self.seed, number, 5])
        idle_frames = rng.choice(TRAINING_IDLE_FRAMES, self.arguments.answers, replace=False)
        starts = [
            SPACE_INVADERS.starts.draw_opening(AtariStart(idle), rng)
            for idle in idle_frames.tolist()
        ]
        for game in play(SPACE_INVADERS, imitator, starts, "sampled", sampling_seed=1_000 + number):
            self.ranked.insert(self.ranked.add(game.recording, self.console), rng)


def arguments_of(words: Sequence[str] | None = None) -> argparse.Namespace:
    """Return the command line's arguments, or those of other words."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-b", "--behaviour", choices=BEHAVIOURS, default="column-3")
    parser.add_argument("--demonstrations", default="person-250", help="see tril demo --help")
    parser.add_argument("-s", "--training-seed", type=int, default=0)
    parser.add_argument("--steps", type=int, default=200_000, help="of all rounds together")
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE")
    parser.add_argument(
        "--attempts", type=int, default=0, help="so many of a person who plans no game, instead"
    )
    parser.add_argument("--ranked-games", type=int, default=12, help="evenly from the order")
    parser.add_argument("--best-efforts", type=int, default=12)
    parser.add_argument("--varied-games", type=int, default=0)
    parser.add_argument("--random-play", action="store_true", help="of random play alone")
    parser.add_argument("--unsorted", action="store_true", help="all of them below the worst")
    parser.add_argument(
        "--bulk-answers", type=int, default=0, help="sort them by so many answers instead of fully"
    )
    parser.add_argument("--reward", choices=REWARDS, default="ranking", help="is learned from this")
    parser.add_argument(
        "--ranked-alone",
        action="store_true",
        help="no best efforts: the best ranked games in their place",
    )
    parser.add_argument("--rounds", type=int, default=1)
    parser.add_argument("--answers", type=int, default=8, help="games inserted between two rounds")
    parser.add_argument(
        "--check", action="store_true", help="measure the check of the ranking, too"
    )
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--ledger", type=Path, help="file that a line is appended to")
    return parser.parse_args(words)


def main() -> None:
    """Train, judge and print."""
    arguments = arguments_of()
    torch.set_num_threads(arguments.threads)
    with tempfile.TemporaryDirectory() as folder:
        lesson = Lesson(arguments)
        digests = {
            "digest": recipe_digest(lesson.recipe),
            "weights": weights_digest(),
            "inference": inference_digest(),
            "demonstrations_digest": lesson.digest(),
        }
        found = digests | lesson.train(Path(folder))
    asked = {k: v for k, v in vars(arguments).items() if k not in {"ledger", "threads", "check"}}
    line = json.dumps(asked | found)
    print(line)
    if arguments.ledger:
        with arguments.ledger.open("a") as ledger:
            ledger.write(line + "\n")


if __name__ == "__main__":
    main()
