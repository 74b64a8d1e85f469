"""What is understood of an order about some aliens of a formation, by the recipe `any`.

    python -m benchmarks.learning.behaviours.sets FOLDER --seeds 3

A scripted player with a person's limits plays Space Invaders' built-in behaviours and some that
people might add: twelve games to be ranked, with three pairs of neighbours swapped, and twelve best
efforts. Prints Kendall's tau with what other games are worth, of the same behaviour and of others,
and what the first order of each behaviour is about. Games are kept in the folder.
"""

from __future__ import annotations

import argparse
import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from benchmarks.learning.behaviours.games import from_row, to_row
from benchmarks.learning.behaviours.orders import tau_b
from benchmarks.learning.few_games import keep_evenly
from benchmarks.learning.opinion import order, seen
from benchmarks.learning.own_behaviours import OWN
from tril.demonstrators import example_tasks, execute, kind_named
from tril.demonstrators.judging import swap_neighbours
from tril.games.behaviours import Behaviour
from tril.games.space_invaders import SPACE_INVADERS
from tril.games.space_invaders.behaviours import BUILT_IN
from tril.ranking import Ranking
from tril.vocabulary.facts import Vocabulary
from tril.vocabulary.making import vocabulary_of
from tril.vocabulary.sentences import tell
from tril.vocabulary.trace import trace
from tril.vocabulary.understanding import understand

BEHAVIOURS: tuple[Behaviour, ...] = (*BUILT_IN, *OWN)
CELLS = ((7, 3), (12, 0), (12, 12))
"""Ranked games and best efforts."""
PLAYER = "person-250"
FIRST_SEED = 900
N_RANKED = 12


@dataclass(frozen=True)
class Example:
    """What a person shows of a behaviour.

    Attributes:
        behaviour: Index of the behaviour.
        ranking: Of the games, by index.
        summaries: Facts of the games, the best efforts last, float32 (n_games, n_facts).
        worths: Of the games by each behaviour, float64 (n_games, n_behaviours).
    """

    behaviour: int
    ranking: Ranking
    summaries: npt.NDArray[np.float32]
    worths: npt.NDArray[np.float64]


def example(folder: Path, behaviour: int, seed: int, words: Vocabulary) -> Example:
    """Return an example; its games are played once."""
    kind, console = kind_named(PLAYER), SPACE_INVADERS.make_console()
    path = folder / f"set-{behaviour}-{seed}.json"
    if not path.exists():
        rng = np.random.default_rng(FIRST_SEED + seed)
        shown = execute(example_tasks(BEHAVIOURS[behaviour], rng, kind=kind))
        rows = [to_row(one.recording.start, one.recording.actions) for one in shown]
        path.write_text(json.dumps(rows))
    recordings = [from_row(row, SPACE_INVADERS) for row in json.loads(path.read_text())]
    games = [seen(one, console) for one in recordings]
    true = order([game(BEHAVIOURS[behaviour]) for game in games[:N_RANKED]])
    n_swaps = min(kind.n_mistakes, len(true.tiers) // 2)
    ranking = swap_neighbours(true, n_swaps, np.random.default_rng([seed, 11]))
    # Targets less two for each stray, and 1 for surviving.
    worths = [[sum(game(one).worth) for one in BEHAVIOURS] for game in games]
    summaries = [words.summary(words.facts(trace(one, console, words.scene))) for one in recordings]
    console.close()
    return Example(behaviour, ranking, np.stack(summaries), np.array(worths, np.float64))


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--seeds", type=int, default=3)
    arguments = parser.parse_args()
    arguments.folder.mkdir(parents=True, exist_ok=True)
    words = vocabulary_of(arguments.folder, SPACE_INVADERS)
    examples = [
        example(arguments.folder, behaviour, seed, words)
        for behaviour in range(len(BEHAVIOURS))
        for seed in range(arguments.seeds)
    ]
    for n_ranked, n_best in CELLS:
        taus: list[tuple[float, float]] = []
        for one in examples:
            tiers = keep_evenly(one.ranking, n_ranked).tiers
            best = range(N_RANKED, N_RANKED + n_best)
            understood = understand(words, one.summaries, tiers, best)
            same = [e for e in examples if e.behaviour == one.behaviour and e is not one]
            others = [e for e in examples if e.behaviour != one.behaviour]
            own, varied = (
                tau_b(
                    understood.value(np.concatenate([e.summaries for e in of])),
                    np.concatenate([e.worths[:, one.behaviour] for e in of]),
                )
                for of in (same, others)
            )
            taus.append((own, varied))
            if one is examples[one.behaviour * arguments.seeds]:
                told = tell(words, understood.posterior, SPACE_INVADERS)[0]
                name = BEHAVIOURS[one.behaviour].name
                print(f"{n_ranked:2} + {n_best:2} {name:20} {told.probability:.2f} {told.sentence}")
        own, varied = np.mean(taus, axis=0)
        print(
            f"{n_ranked:2} + {n_best:2} tau: own games {own:.2f}, varied {varied:.2f}", flush=True
        )


if __name__ == "__main__":
    main()
