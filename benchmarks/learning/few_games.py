"""From how few games of a person Tril infers which aliens are wanted.

    python -m benchmarks.learning.few_games --first-seed 300 --seeds 6

A scripted player with a person's limits plays each behaviour, the built-in ones and some that
people might add: twelve games to be ranked, with three pairs of neighbours swapped, and twelve best
efforts. Some of the ranked games, evenly from the best to the worst, and the first of the best
efforts are kept; without best efforts, the best ranked games stand in for them. Prints, for each
number of both, in how many examples an alien is mislabelled, and how far the worst label is from
the true one (0 to 2) on average.
"""

from __future__ import annotations

import argparse
import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from benchmarks.learning.opinion import Game, order, seen
from benchmarks.learning.own_behaviours import OWN
from tril.analysis.wanted_aliens import (
    Hits,
    Posterior,
    best_games,
    labels_of_draws,
    learned_order,
    log_prior,
    pair_weights,
)
from tril.demonstrators import example_tasks, execute, kind_named
from tril.demonstrators.judging import swap_neighbours
from tril.games.base import Console
from tril.games.behaviours import Behaviour
from tril.games.space_invaders import SPACE_INVADERS
from tril.games.space_invaders.behaviours import BUILT_IN
from tril.games.space_invaders.memory import COLUMNS, ROWS
from tril.ranking import Ranking, normalise

N_RANKED = (2, 3, 4, 6, 8, 12)
N_BEST = (0, 1, 2, 3, 4, 6, 12)

N_PASSES = 200
"""Of Gibbs sampling."""

Labels = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Example:
    """What a scripted person shows of a behaviour.

    Attributes:
        ranking: Of the games, by index.
        games: The ranked games, then the best efforts.
        best_efforts: Their indices.
        true_labels: 1 for aliens that are wanted, -1 for others, float64 (36,).
    """

    ranking: Ranking
    games: Sequence[Game]
    best_efforts: Sequence[int]
    true_labels: Labels


class Mistakes(NamedTuple):
    """What is wrong with inferred labels.

    Attributes:
        n_wrong: Aliens whose label has the wrong sign.
        furthest: How far a label is from the true one at most, 0 to 2.
    """

    n_wrong: int
    furthest: float


def make(behaviour: Behaviour, kind_name: str, seed: int, console: Console) -> Example:
    """Play an example."""
    kind = kind_named(kind_name)
    rng = np.random.default_rng(seed)
    shown = list(execute(example_tasks(behaviour, rng, kind=kind)))
    games = [seen(one.recording, console)(behaviour) for one in shown]
    n_ranked = sum(not one.perfect for one in shown)
    true = order(games[:n_ranked])
    n_swaps = min(kind.n_mistakes, len(true.tiers) // 2)
    return Example(
        swap_neighbours(true, n_swaps, np.random.default_rng([seed, 11])),
        games,
        range(n_ranked, len(games)),
        true_labels(behaviour),
    )


def true_labels(behaviour: Behaviour) -> Labels:
    """Return 1 for a behaviour's targets and -1 for all other aliens, float64 (36,)."""
    labels = np.full((ROWS, COLUMNS), -1.0)
    for row, column in behaviour.target or ():
        labels[row, column] = 1.0
    return labels.ravel()


def keep_evenly(ranking: Ranking, n_games: int) -> Ranking:
    """Return the ranking of so many of the games, evenly from the best to the worst."""
    places = np.linspace(0, len(ranking.items) - 1, n_games).round().astype(int)
    kept = {ranking.items[place] for place in places.tolist()}
    return normalise([index for index in tier if index in kept] for tier in ranking.tiers)


def join_tiers(ranking: Ranking, n_tiers: int) -> Ranking:
    """Return the ranking with neighbouring tiers joined into so many, if it has more."""
    if len(ranking.tiers) <= n_tiers:
        return ranking
    parts = np.array_split(np.arange(len(ranking.tiers)), n_tiers)
    return normalise([item for tier in part for item in ranking.tiers[tier]] for part in parts)


def rank_also(ranking: Ranking, games: Sequence[Game], further: Sequence[int]) -> Ranking:
    """Return the ranking with further games: each beside the first tier that is worth as much."""
    tiers = [list(tier) for tier in ranking.tiers]
    for index in further:
        worth = games[index].worth
        of_tiers = [games[tier[0]].worth for tier in tiers]
        if worth in of_tiers:
            tiers[of_tiers.index(worth)].append(index)
        else:
            tiers.insert(sum(other > worth for other in of_tiers), [index])
    return normalise(tiers)


def draw_labels(
    ranking: Ranking, games: Sequence[Game], marked: Sequence[int], rng: np.random.Generator
) -> tuple[Labels, Labels]:
    """Return draws of all labels, float64 (S, 36), and how surely each counts in order, (36,)."""
    best = best_games(ranking.tiers, marked)
    hits: dict[int, Hits] = {index: games[index].hits for index in (*ranking.items, *best)}
    hits_of_best = [hits[index] for index in best]
    pairs = ranking.pairs()
    weights = pair_weights(pairs, ranking.tiers)
    order = learned_order(hits_of_best)
    posterior = Posterior(hits, pairs, weights, log_prior(hits_of_best), order)
    return labels_of_draws(posterior.draws(rng, N_PASSES)), order


def judge(
    example: Example,
    n_ranked: int,
    n_best: int,
    seed: int,
    n_tiers: int | None = None,
    n_further: int = 0,
) -> Mistakes | None:
    """Return what is wrong with the labels; None if the kept games are all in one tier.

    Args:
        example: What is shown.
        n_ranked: Number of its ranked games that are kept.
        n_best: Number of its best efforts.
        seed: Of the sampling.
        n_tiers: Join the ranked games into so many tiers.
        n_further: Number of other best efforts that are ranked, too.
    """
    ranking = keep_evenly(example.ranking, n_ranked)
    if n_tiers is not None:
        ranking = join_tiers(ranking, n_tiers)
    others = example.best_efforts[n_best:]
    ranking = rank_also(ranking, example.games, others[:n_further])
    if len(ranking.tiers) < 2:
        return None
    marked = example.best_efforts[:n_best]
    draws, _ = draw_labels(ranking, example.games, marked, np.random.default_rng(seed))
    labels = draws.mean(0)
    return Mistakes(
        int((np.sign(labels) != example.true_labels).sum()),
        float(np.abs(labels - example.true_labels).max()),
    )


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--demonstrations", default="person-250", help="see tril demo --help")
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--first-seed", type=int, default=300)
    parser.add_argument(
        "--tiers", type=int, help="join neighbouring tiers into so many, two or more"
    )
    parser.add_argument("--further", type=int, default=0, help="rank so many other best efforts")
    arguments = parser.parse_args()
    console = SPACE_INVADERS.make_console()
    for name, behaviours in (("Built-in behaviours", BUILT_IN), ("Further behaviours", OWN)):
        found: dict[tuple[int, int], list[Mistakes]] = {}
        for behaviour, number in itertools.product(behaviours, range(arguments.seeds)):
            seed = arguments.first_seed + number
            example = make(behaviour, arguments.demonstrations, seed, console)
            for kept in itertools.product(N_RANKED, N_BEST):
                mistakes = judge(example, *kept, seed, arguments.tiers, arguments.further)
                if mistakes is not None:
                    found.setdefault(kept, []).append(mistakes)
        print(f"\n{name}:\n\n{table(found)}", flush=True)


def table(found: dict[tuple[int, int], list[Mistakes]]) -> str:
    """Return a table in Markdown: a row for each number of ranked games."""
    rows = [
        "| ranked | " + " | ".join(f"{n} best efforts" for n in N_BEST) + " |",
        "|---:|" + "---:|" * len(N_BEST),
    ]
    for n_ranked in N_RANKED:
        cells = []
        for n_best in N_BEST:
            mistakes = found[n_ranked, n_best]
            n_wrong = sum(one.n_wrong > 0 for one in mistakes)
            error = float(np.mean([one.furthest for one in mistakes]))
            cells.append(f"{n_wrong} of {len(mistakes)} ({error:.2f})")
        rows.append(f"| {n_ranked} | " + " | ".join(cells) + " |")
    return "\n".join(rows)


if __name__ == "__main__":
    main()
