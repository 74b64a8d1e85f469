"""How fast, well and reliably the rank page places games by which aliens the others hit.

    python -m benchmarks.learning.opinion

Rankings are of the scripted player's twelve games of a behaviour, flawless (`scripted`) or with a
person's limits (`person-250`), alone or with games of random play, with three pairs of neighbours
swapped, as a person's mistakes. `tril.analysis.opinions` infers from what the games hit which
aliens are wanted; it places each ranked game by the others alone, and unseen games, those of
another seed, by all of them. Places are compared with the true order, and contradicted games are
counted; then one game is put in a wrong place, at least a third of the ranking away. Prints tables
and a JSON line.
"""

from __future__ import annotations

import argparse
import itertools
import json
import time
from collections import defaultdict
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from tril.analysis.opinions import Opinion, form_opinions
from tril.analysis.wanted_aliens import Hits
from tril.demonstrators import example_tasks, execute, kind_named, play_randomly
from tril.demonstrators.judging import merit, swap_neighbours
from tril.games.base import Console
from tril.games.behaviours import Behaviour
from tril.games.space_invaders import SPACE_INVADERS
from tril.games.space_invaders.behaviours import BUILT_IN
from tril.ranking import Ranking, kendall_tau, normalise
from tril.recording import Recording, trajectory

N_SWAPS = 3
N_DRAWS = 4
"""Draws of the mistakes per ranking."""
LEAST_DISTANCE = 1 / 3
"""Of the ranking, between the right place of a misplaced game and the wrong one."""
N_RANDOM = (0, 12, 24)
"""Games of random play beside the twelve."""
SIZES = (12, 36, 100)
N_TIMED = 40


@dataclass(frozen=True)
class Game:
    """What a game hits, and its worth for a behaviour."""

    hits: Hits
    worth: tuple[int, int]


def seen(recording: Recording, console: Console) -> Callable[[Behaviour], Game]:
    """Replay a recording; return what judges it for a behaviour."""
    replayed = trajectory(recording, console)
    hits = Hits.of(((hit.row, hit.column, hit.frame) for hit in replayed.taken), recording.n_frames)
    cells = tuple(hit.cell for hit in replayed.taken)
    return lambda behaviour: Game(hits, merit(behaviour, cells, replayed.end))


def shown(behaviour: Behaviour, kind: str, seed: int, console: Console) -> list[Game]:
    """Play the twelve games of an example."""
    rng = np.random.default_rng(seed)
    made = execute(example_tasks(behaviour, rng, n_perfect=0, kind=kind_named(kind)))
    return [seen(one.recording, console)(behaviour) for one in made]


def order(games: list[Game]) -> Ranking:
    """Rank games, by index, by their worth."""
    tiers: dict[tuple[int, int], list[int]] = {}
    for index, game in enumerate(games):
        tiers.setdefault(game.worth, []).append(index)
    return normalise(tiers[worth] for worth in sorted(tiers, reverse=True))


def middles(ranking: Ranking) -> dict[int, float]:
    """Return the share of the ranking above the middle of each game's tier."""
    ends = np.cumsum([len(tier) for tier in ranking.tiers]) / len(ranking.items)
    sizes = [len(tier) / len(ranking.items) for tier in ranking.tiers]
    return {
        item: float(end - size / 2)
        for tier, end, size in zip(ranking.tiers, ends, sizes, strict=True)
        for item in tier
    }


def misplace(ranking: Ranking, rng: np.random.Generator) -> tuple[int, Ranking]:
    """Put one game into a tier of its own in a wrong place; return it and the new ranking."""
    while True:
        item = int(rng.choice(ranking.items))
        tiers = list(ranking.without([item]).tiers)
        tiers.insert(int(rng.integers(len(tiers) + 1)), (item,))
        wrong = normalise(tiers)
        if abs(middles(wrong)[item] - middles(ranking)[item]) >= LEAST_DISTANCE:
            return item, wrong


def ask(ranking: Ranking, games: list[Game]) -> dict[int, Opinion]:
    """Return the opinion of each game, by index."""
    opinions = form_opinions(ranking, {index: game.hits for index, game in enumerate(games)})
    return opinions.of if opinions else {}


def contradicted(opinions: dict[int, Opinion]) -> set[int]:
    """Return the games that are contradicted."""
    return {item for item, opinion in opinions.items() if opinion.contradicted_by}


def judge(
    games: list[Game], unseen: list[Game], rng: np.random.Generator
) -> Iterator[dict[str, float]]:
    """Yield the figures of one set of games, once per draw of the mistakes.

    Args:
        games: The games to rank.
        unseen: Further games, which are not ranked.
        rng: Source of the mistakes.
    """
    n = len(games)
    true = order(games)
    unseen_tiers = [[n + item for item in tier] for tier in order(unseen).tiers]
    for _ in range(N_DRAWS):
        given = swap_neighbours(true, min(N_SWAPS, len(true.tiers) // 2), rng)
        opinions = ask(given, games + unseen)
        places = {item: -opinion.place for item, opinion in opinions.items()}
        right = middles(true)
        inside = [opinions[i].best_place <= right[i] <= opinions[i].worst_place for i in right]
        item, wrong = misplace(given, rng)
        asked = ask(wrong, games)
        found = contradicted(asked)
        doubted = {i: one.p_value for i, one in asked.items() if one.p_value is not None}
        yield {
            "tau left out": kendall_tau(true.tiers, places),
            "tau unseen": kendall_tau(unseen_tiers, places),
            "inside the interval": float(np.mean(inside)),
            "contradicted": len(contradicted(opinions)),
            "misplaced found": item in found,
            "least probable": min(doubted, key=doubted.__getitem__) == item,
            "others beside it": len(found - {item}),
        }


def refit_ms(games: list[Game], n: int, rng: np.random.Generator) -> list[tuple[float, float]]:
    """Return milliseconds, and of processor time, of refits for n games in a random order."""
    times = []
    for _ in range(N_TIMED):
        drawn = [games[index] for index in rng.choice(len(games), n, replace=len(games) < n)]
        ranking = normalise([[index] for index in rng.permutation(n).tolist()])
        begin, begin_cpu = time.perf_counter(), time.process_time()
        ask(ranking, drawn)
        end, end_cpu = time.perf_counter(), time.process_time()
        times.append((1000 * (end - begin), 1000 * (end_cpu - begin_cpu)))
    return times


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--first-seed", type=int, default=100)
    arguments = parser.parse_args()
    console = SPACE_INVADERS.make_console()
    figures: dict[str, list[dict[str, float]]] = defaultdict(list)
    every: list[Game] = []
    seeds = range(arguments.first_seed, arguments.first_seed + arguments.seeds)
    random = {
        seed: [seen(play_randomly(rng, console).recording, console) for _ in range(max(N_RANDOM))]
        for seed in seeds
        for rng in [np.random.default_rng([seed, 7])]
    }
    for behaviour, kind in itertools.product(BUILT_IN, ("person-250", "scripted")):
        examples = {seed: shown(behaviour, kind, seed, console) for seed in seeds}
        for seed, n_random in itertools.product(seeds, N_RANDOM):
            further = [judged(behaviour) for judged in random[seed][:n_random]]
            games = examples[seed] + further
            unseen = examples[seed + 1 if seed + 1 in examples else seeds[0]]
            rng = np.random.default_rng([seed, 11])
            figures[f"{kind} + {n_random} random"] += judge(games, unseen, rng)
            every += games
    names = list(figures["scripted + 0 random"][0])
    print(f"{'ranking':24s}", *(f"{name:>20s}" for name in names))
    means = {
        kind: {name: float(np.mean([one[name] for one in found])) for name in names}
        for kind, found in figures.items()
    }
    for kind, found in means.items():
        print(f"{kind:24s}", *(f"{found[name]:20.2f}" for name in names))
    rng = np.random.default_rng(0)
    times = {n: np.percentile(refit_ms(every, n, rng), (50, 95), axis=0).tolist() for n in SIZES}
    for n, ((p50, cpu_p50), (p95, cpu_p95)) in times.items():
        print(f"refit of {n} games: p50 {p50:.1f} ms, p95 {p95:.1f} ms;", end=" ")
        print(f"processor time p50 {cpu_p50:.1f} ms, p95 {cpu_p95:.1f} ms")
    print(json.dumps({"figures": means, "refit_ms": times}))


if __name__ == "__main__":
    main()
