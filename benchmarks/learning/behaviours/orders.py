"""How well an order says what is meant: Kendall's tau of unseen games with the truth.

    python -m benchmarks.learning.behaviours.players FOLDER     # plays the games, an hour
    python -m benchmarks.learning.behaviours.orders FOLDER --half report

Of each behaviour some games are ranked with a quarter of the neighbours swapped, beside best
efforts and varied games that are sorted. "own" are unseen games of the behaviour's own players,
"varied" those of other behaviours' players. "one click" is the best of the five statements that
Tril tells, as if the person had chosen it. "sense" is how often the order surpasses all
shuffled ones, and how often it is not refused; "noise" the same of an order drawn by chance.
"""

from __future__ import annotations

import argparse
import json
import time
import zlib
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from benchmarks.learning.behaviours.games import Array, PlayedGames, load_games, tasks_of
from benchmarks.learning.behaviours.suite import SPLITS
from tril.vocabulary.answers import Answer
from tril.vocabulary.sentences import tell
from tril.vocabulary.understanding import MOST_AS_GOOD, shuffles_as_good, understand

CELLS = ((7, 3, 0), (12, 0, 0), (12, 12, 0), (24, 0, 0), (12, 12, 20))
"""Ranked games, best efforts, sorted varied games."""
SWAPPED = 0.25
"""Share of the neighbours in an order that a person confuses."""


@dataclass(frozen=True)
class Outcome:
    """What came of one order."""

    game: str
    task: str
    cell: tuple[int, int, int]
    seed: int
    own: float
    varied: float
    one_click: float
    sense: int
    noise: int
    seconds: float
    told: tuple[str, ...]


def tau_b(values: Array, truth: Array) -> float:
    """Return Kendall's tau-b of two rows of values; ties count in neither's favour."""
    first, second = np.triu_indices(len(values), 1)
    of_values = np.sign(values[first] - values[second])
    of_truth = np.sign(truth[first] - truth[second])
    n_pairs = np.sqrt(max((of_values != 0).sum(), 1) * max((of_truth != 0).sum(), 1))
    return float((of_values * of_truth).sum() / n_pairs)


def ranked_by_person(
    worth: Array, rows: npt.NDArray[np.int64], rng: np.random.Generator
) -> list[list[int]]:
    """Return rows in tiers of one, the best first, with some neighbours swapped."""
    order = rows[np.argsort(-worth[rows], kind="stable")].tolist()
    for place in range(len(order) - 1):
        if rng.random() < SWAPPED:
            order[place], order[place + 1] = order[place + 1], order[place]
    return [[row] for row in order]


def examine(played: PlayedGames, task: int, cell: tuple[int, int, int], seed: int) -> Outcome:
    """Let one order be understood and compare with the truth."""
    n_ranked, n_best, n_sorted = cell
    name = played.tasks[task].name
    rng = np.random.default_rng(zlib.crc32(f"{played.game.name}{name}{seed}".encode()))
    worth = played.worths[:, task]
    own = np.flatnonzero((played.task == task) & ~played.is_best)
    best_efforts = np.flatnonzero((played.task == task) & played.is_best)
    others = rng.permutation(np.flatnonzero((played.task != task) & ~played.is_best))
    ranked = rng.permutation(own)[:n_ranked]
    best = rng.permutation(best_efforts)[:n_best]
    tiers = ranked_by_person(worth, ranked, rng)
    if n_sorted:
        # Sorted into the same order, as a person inserts them.
        tiers = ranked_by_person(worth, np.concatenate([ranked, others[:n_sorted]]), rng)
    began = time.perf_counter()
    understood = understand(played.words, played.summaries, tiers, best.tolist())
    seconds = time.perf_counter() - began
    random = [[int(row)] for row in rng.permutation([row for tier in tiers for row in tier])]
    unseen = np.setdiff1d(own, ranked)
    told = tell(played.words, understood.posterior, played.game)
    values = understood.value(played.summaries)
    varied = others[n_sorted:]
    clicks = []
    for one in told:
        meant = [Answer(frozenset(one.subjects), meant=True)]
        agreed = understand(played.words, played.summaries, tiers, best.tolist(), meant)
        clicks.append(tau_b(agreed.value(played.summaries)[unseen], worth[unseen]))
    return Outcome(
        played.game.name,
        name,
        cell,
        seed,
        tau_b(values[unseen], worth[unseen]),
        tau_b(values[varied], worth[varied]),
        max(clicks),
        shuffles_as_good(played.words, played.summaries, tiers, best.tolist()),
        shuffles_as_good(played.words, played.summaries, random, best.tolist()),
        seconds,
        tuple(f"{one.probability:.2f} {one.sentence}" for one in told[:3]),
    )


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--half", choices=SPLITS, default="development")
    parser.add_argument("--games", nargs="*", default=())
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--told", action="store_true", help="print what is told of the first seed")
    parser.add_argument("--json", type=Path, help="write every outcome here")
    arguments = parser.parse_args()
    outcomes: list[Outcome] = []
    for name, tasks in tasks_of(arguments.half, arguments.folder, arguments.games).items():
        played = load_games(arguments.folder, name, tasks)
        for index in range(len(tasks)):
            for cell in CELLS:
                for seed in range(arguments.seeds):
                    outcome = examine(played, index, cell, seed)
                    outcomes.append(outcome)
                    if arguments.told and not seed:
                        counts = "+".join(map(str, cell))
                        print(f"{name:15} {outcome.task:22} {counts:8}", "; ".join(outcome.told))
    print(f"{'games':9} own  varied  one click  sense       noise       seconds")
    for cell in CELLS:
        rows = [one for one in outcomes if one.cell == cell]
        own, varied, click, seconds, *passing = np.mean(
            [
                (
                    one.own,
                    one.varied,
                    one.one_click,
                    one.seconds,
                    one.sense == 0,
                    one.sense <= MOST_AS_GOOD,
                    one.noise == 0,
                    one.noise <= MOST_AS_GOOD,
                )
                for one in rows
            ],
            axis=0,
        )
        print(
            f"{'+'.join(map(str, cell)):9} {own:.2f} {varied:.2f}    {click:.2f}       "
            + " ".join(f"{share:5.0%}" for share in passing)
            + f"   {seconds:.2f}"
        )
    for game, task in dict.fromkeys((one.game, one.task) for one in outcomes):
        means = [
            np.mean(
                [
                    one.own
                    for one in outcomes
                    if (one.game, one.task, one.cell) == (game, task, cell)
                ]
            )
            for cell in CELLS
        ]
        print(f"{game:15} {task:22}", " ".join(f"{mean:5.2f}" for mean in means))
    if arguments.json:
        arguments.json.write_text(json.dumps([asdict(one) for one in outcomes], indent=1))


if __name__ == "__main__":
    main()
