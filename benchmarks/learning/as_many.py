"""How well Tril infers that as many aliens as possible are wanted.

    python -m benchmarks.learning.as_many --first-seed 706 --seeds 6
    TRIL_DATA=folder python -m benchmarks.learning.as_many --first-seed 720 --keep
    TRIL_DATA=folder tril train as-many-as-you-can

A scripted player with a person's errors shoots at more or fewer aliens of a region, in an order
drawn by chance, and a quarter of the time anywhere; no game can hit all. The games are ranked by
targets - strays, with pairs of neighbours swapped, and the best are marked as perfect. Prints
Kendall's tau of what twenty further games are worth with the sum of the labels of what they hit:
the mean over seeds, and the lowest. With ``--keep``, it leaves one example of twelve games that hit
as many as they can, ranked, three of them marked as perfect, in a data folder, to be trained on.
"""

from __future__ import annotations

import argparse

import numpy as np

from benchmarks.learning.attempts import errors, with_swaps
from benchmarks.learning.few_games import draw_labels
from benchmarks.learning.opinion import Game, order, seen
from cli.workspace import open_workspace
from tril.demonstrators import play_randomly
from tril.demonstrators.space_invaders.human_like import HumanLikePlayer
from tril.demonstrators.space_invaders.plans import DemonstrationPlan, draw_hits
from tril.demonstrators.space_invaders.player import draw_brisk_style, draw_style
from tril.games.base import Cell, Console, draw_start
from tril.games.behaviours import Behaviour
from tril.games.space_invaders import SPACE_INVADERS
from tril.games.space_invaders.memory import COLUMNS, ROWS
from tril.play.episode import Episode
from tril.ranking import kendall_tau
from tril.recording import Recorder, Recording, verify
from tril.store import behaviours, rankings, recordings
from tril.store.models import Source

CELLS = tuple((row, column) for row in range(ROWS) for column in range(COLUMNS))

REGIONS: dict[str, tuple[Cell, ...]] = {
    "all aliens": CELLS,
    "left half": tuple(cell for cell in CELLS if cell[1] < COLUMNS // 2),
    "two lowest rows": tuple(cell for cell in CELLS if cell[0] < 2),
}

SHOWN = ((4, 0, 3), (8, 2, 3), (12, 0, 0), (12, 0, 3), (16, 4, 3))
"""Games of the player and of random play that are ranked, and how many are marked."""

N_SHOWN = 16
N_UNSEEN = 20
N_RANDOM = 4

N_KEPT = 12
N_KEPT_MARKED = 3

ELSEWHERE_SHARE = 0.25
"""Share of games that are played towards any aliens."""

BRISK_SHARE = 0.7

AIMED_AT = (2, 15)
"""Fewest and most aliens that a game is played towards."""


def play_towards(region: tuple[Cell, ...], rng: np.random.Generator, console: Console) -> Recording:
    """Play a game towards some aliens of a region."""
    allowed = frozenset(CELLS if rng.random() < ELSEWHERE_SHARE else region)
    fewest, most = AIMED_AT
    n_hits = int(rng.integers(fewest, min(most, len(allowed)), endpoint=True))
    wanted = draw_hits(DemonstrationPlan(1, "As many", allowed, n_hits, n_hits), rng)
    recorder = Recorder(Episode(console, draw_start(SPACE_INVADERS.starts, rng)))
    style = draw_brisk_style(rng) if rng.random() < BRISK_SHARE else draw_style(rng)
    HumanLikePlayer(recorder, wanted, style, errors(rng), rng).play()
    return recorder.recording()


def tau_of(games: list[Game], unseen: list[Game], n_marked: int, seed: int) -> float:
    """Return Kendall's tau of what unseen games are worth with what the labels make of them."""
    true = order(games)
    ranking = with_swaps(true, seed)
    draws, _ = draw_labels(ranking, games, true.items[:n_marked], np.random.default_rng(seed))
    labels = draws.mean(0)
    tiers = order(unseen).tiers
    return kendall_tau(tiers, [float(labels[one.hits.gone].sum()) for one in unseen])


def keep(seed: int, console: Console) -> None:
    """Add a behaviour without targets to the data folder, and its ranked games."""
    rng = np.random.default_rng(seed)
    behaviour = Behaviour("all", "All", "", "space_invaders", CELLS)
    played = [verify(play_towards(CELLS, rng, console), console=console) for _ in range(N_KEPT)]
    games = [seen(one.recording, console)(behaviour) for one in played]
    true = order(games)
    ranking = with_swaps(true, seed)
    with open_workspace() as workspace, workspace.database.writing() as session:
        own = behaviours.create(session, "As many as you can", target=None)
        ids = [
            recordings.add(
                session,
                own.id,
                one.recording,
                one.replay,
                Source.SCRIPTED,
                perfect=index in true.items[:N_KEPT_MARKED],
            ).id
            for index, one in enumerate(played)
        ]
        rankings.save(session, own.id, 0, [[ids[index] for index in t] for t in ranking.tiers])
        print(f"{own.slug}: {sorted(len(one.replay.taken) for one in played)} aliens hit")


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=6)
    parser.add_argument("--first-seed", type=int, default=706)
    parser.add_argument("--keep", action="store_true")
    arguments = parser.parse_args()
    console = SPACE_INVADERS.make_console()
    if arguments.keep:
        keep(arguments.first_seed, console)
        return
    print("| as many as possible of | games | random play | marked | tau | lowest |")
    print("|---|---:|---:|---:|---:|---:|")
    for name, region in REGIONS.items():
        behaviour = Behaviour("as-many", "As many", "", "space_invaders", region)
        taus: dict[tuple[int, int, int], list[float]] = {one: [] for one in SHOWN}
        for seed in range(arguments.first_seed, arguments.first_seed + arguments.seeds):
            rng = np.random.default_rng(seed)
            played = [play_towards(region, rng, console) for _ in range(N_SHOWN + N_UNSEEN)]
            played += [play_randomly(rng, console).recording for _ in range(N_RANDOM)]
            games = [seen(one, console)(behaviour) for one in played]
            unseen, random = games[N_SHOWN:-N_RANDOM], games[-N_RANDOM:]
            for n_games, n_random, n_marked in SHOWN:
                ranked = [*games[:n_games], *random[:n_random]]
                taus[n_games, n_random, n_marked].append(tau_of(ranked, unseen, n_marked, seed))
        for shown, found in taus.items():
            numbers = " | ".join(map(str, shown))
            print(f"| {name} | {numbers} | {np.mean(found):.2f} | {min(found):.2f} |", flush=True)


if __name__ == "__main__":
    main()
