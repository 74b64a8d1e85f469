"""How well Tril infers the wanted aliens from games of a person who does not plan them.

    python -m benchmarks.learning.attempts --first-seed 604 --seeds 4

A scripted player of varying skill tries to do all of a behaviour, again and again; each game has
limits of its own, up to three times those of `person-250`. Some games of random play are ranked
beside the attempts, as if the player had fooled around. All are ranked by what they are worth, with
pairs of neighbours swapped, and the best are marked as perfect, whatever they miss. Prints in how
many examples an alien is mislabelled, how many aliens are on average, how far the worst label is
from the true one (0 to 2), and what the best game is worth (targets - strays).
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from benchmarks.learning.few_games import Example, judge, true_labels
from benchmarks.learning.opinion import Game, order, seen
from benchmarks.learning.own_behaviours import OWN
from tril.demonstrators import HUMAN, ErrorModel, example_plans, play_randomly
from tril.demonstrators.judging import swap_neighbours
from tril.demonstrators.space_invaders.human_like import HumanLikePlayer
from tril.demonstrators.space_invaders.plans import draw_hits
from tril.demonstrators.space_invaders.player import draw_brisk_style, draw_style
from tril.games.base import Console, draw_start
from tril.games.behaviours import Behaviour
from tril.games.space_invaders import SPACE_INVADERS
from tril.games.space_invaders.behaviours import BUILT_IN
from tril.play.episode import Episode
from tril.ranking import Ranking
from tril.recording import Recorder, Recording


class Kept(NamedTuple):
    """What of the games is ranked and marked."""

    n_attempts: int
    n_random: int
    n_marked: int


KEPT = (
    Kept(4, 2, 3),
    Kept(8, 2, 3),
    Kept(12, 0, 3),
    Kept(16, 4, 0),
    Kept(16, 4, 3),
    Kept(16, 4, 6),
)

CLUMSIER = (1.0, 3.0)
"""Range of the factor of a game's errors."""

SLOWER = (0.8, 1.6)
"""Range of the factor of a game's reaction time."""

MISSED_BOMBS = 0.5
"""Upper limit of the share of bombs that go unnoticed."""


def errors(rng: np.random.Generator) -> ErrorModel:
    """Draw the errors of one game."""
    factor = rng.uniform(*CLUMSIER)
    return replace(
        HUMAN,
        name="attempt",
        reaction_frames=int(HUMAN.reaction_frames * rng.uniform(*SLOWER)),
        aim_error_px=HUMAN.aim_error_px * factor,
        key_error_frames=HUMAN.key_error_frames * factor,
        slip_share=HUMAN.slip_share * factor,
        missed_bomb_share=min(MISSED_BOMBS, HUMAN.missed_bomb_share * factor),
    )


def attempt(behaviour: Behaviour, rng: np.random.Generator, console: Console) -> Recording:
    """Play a game that tries to do all of a behaviour."""
    recorder = Recorder(Episode(console, draw_start(SPACE_INVADERS.starts, rng)))
    wanted = draw_hits(example_plans(behaviour)[0], rng)
    style = draw_brisk_style(rng) if rng.random() < 0.5 else draw_style(rng)
    HumanLikePlayer(recorder, wanted, style, errors(rng), rng).play()
    return recorder.recording()


def play(
    behaviour: Behaviour, seed: int, console: Console
) -> tuple[Sequence[Game], Sequence[Game]]:
    """Return attempts and games of random play, as many as are kept at most."""
    rng = np.random.default_rng(seed)
    n_attempts, n_random = max(one.n_attempts for one in KEPT), max(one.n_random for one in KEPT)
    attempts = [attempt(behaviour, rng, console) for _ in range(n_attempts)]
    about = [play_randomly(rng, console).recording for _ in range(n_random)]
    attempted, random = (
        [seen(one, console)(behaviour) for one in played] for played in (attempts, about)
    )
    return attempted, random


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=4)
    parser.add_argument("--first-seed", type=int, default=604)
    arguments = parser.parse_args()
    console = SPACE_INVADERS.make_console()
    for name, behaviours in (("Built-in behaviours", BUILT_IN), ("Further behaviours", OWN)):
        print(
            f"\n{name}:\n\n| attempts | random play | marked | wrong | aliens | furthest | best |"
        )
        print("|---:|---:|---:|---:|---:|---:|---:|")
        seeds = range(arguments.first_seed, arguments.first_seed + arguments.seeds)
        played = {(one, seed): play(one, seed, console) for one in behaviours for seed in seeds}
        for kept in KEPT:
            print(row(kept, played), flush=True)


def with_swaps(ranking: Ranking, seed: int) -> Ranking:
    """Return a ranking with up to three pairs of neighbours swapped, of a few games with one."""
    n_swaps = min(3 if len(ranking.items) > 8 else 1, len(ranking.tiers) // 2)
    return swap_neighbours(ranking, n_swaps, np.random.default_rng(seed))


def row(
    kept: Kept, played: dict[tuple[Behaviour, int], tuple[Sequence[Game], Sequence[Game]]]
) -> str:
    """Return a row of the table."""
    mistakes, best = [], []
    for (behaviour, seed), (attempts, random) in played.items():
        games = [*attempts[: kept.n_attempts], *random[: kept.n_random]]
        true = order(games)
        ranking = with_swaps(true, seed)
        marked = true.items[: kept.n_marked]
        example = Example(ranking, games, marked, true_labels(behaviour))
        if (found := judge(example, len(games), kept.n_marked, seed)) is not None:
            mistakes.append(found)
            best.append(games[true.items[0]].worth[0])
    n_wrong = [one.n_wrong for one in mistakes]
    wrong = f"{np.count_nonzero(n_wrong)} of {len(mistakes)}"
    furthest = float(np.mean([one.furthest for one in mistakes]))
    return (
        f"| {' | '.join(map(str, kept))} | {wrong} | {np.mean(n_wrong):.2f} | {furthest:.2f} |"
        f" {np.mean(best):.1f} |"
    )


if __name__ == "__main__":
    main()
