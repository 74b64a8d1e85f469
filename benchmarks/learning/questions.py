"""Which games to ask a person about: how fast answers make the wanted aliens known.

    python -m benchmarks.learning.questions --first-seed 404 --seeds 3

A scripted person has ranked a few games of a behaviour. Then it is asked where one more belongs,
again and again: one of its other ranked games, or of those that it played with another seed. It
puts it beside the first tier that is worth as much; one answer in ten is random. Games are drawn at
random or chosen by what has been inferred so far. Prints, by the number of answers, the sum of the
errors of all labels (1 for an alien that is surely mislabelled), on average.
"""

from __future__ import annotations

import argparse
import itertools
from collections import defaultdict
from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt

from benchmarks.learning.few_games import Example, draw_labels, keep_evenly, make, rank_also
from tril.analysis.wanted_aliens import worth
from tril.games.space_invaders import SPACE_INVADERS
from tril.games.space_invaders.behaviours import BUILT_IN
from tril.ranking import Ranking, normalise

ANSWERS = (0, 1, 2, 3, 5, 7, 10, 15)
WRONG_ANSWERS = 0.1
N_REPEATS = 2
"""With other wrong answers and draws."""

Array = npt.NDArray[np.float64]
Choice = Callable[[Array, Array, np.random.Generator], int]
"""Chooses one of m games by what n ranked games and these are worth in S draws, float64 (S, n) and
(S, m)."""


def at_random(ranked: Array, further: Array, rng: np.random.Generator) -> int:
    """Choose any game."""
    return int(rng.integers(further.shape[1]))


def least_sure(ranked: Array, further: Array, rng: np.random.Generator) -> int:
    """Choose the game whose place among the ranked ones differs most."""
    above = further[:, :, None] > ranked[:, None]
    beside = further[:, :, None] == ranked[:, None]
    return int((above + 0.5 * beside).sum(2).std(0).argmax())


def thought_best(ranked: Array, further: Array, rng: np.random.Generator) -> int:
    """Choose the game that is worth most."""
    return int((further.mean(0) + 1e-6 * rng.random(further.shape[1])).argmax())


CHOICES: dict[str, Choice] = {
    "at random": at_random,
    "the game whose place is least sure": least_sure,
    "the game that is thought best": thought_best,
}


def answer(ranking: Ranking, example: Example, game: int, rng: np.random.Generator) -> Ranking:
    """Rank one more game as the person does."""
    if rng.random() >= WRONG_ANSWERS:
        return rank_also(ranking, example.games, [game])
    tiers = list(ranking.tiers)
    tiers.insert(int(rng.integers(len(tiers) + 1)), (game,))
    return normalise(tiers)


def ask(
    example: Example, ranking: Ranking, marked: Sequence[int], choose: Choice, seed: Sequence[int]
) -> list[float]:
    """Return how far all labels are off, after none to most answers."""
    rng = np.random.default_rng(seed)
    left = [index for index in range(len(example.games)) if index not in {*ranking.items, *marked}]
    errors = []
    for _ in range(max(ANSWERS) + 1):
        labels, order = draw_labels(ranking, example.games, marked, rng)
        errors.append(float(np.abs(labels.mean(0) - example.true_labels).sum() / 2))
        ranked, further = (
            worth(labels, order, [example.games[index].hits for index in games])
            for games in (ranking.items, left)
        )
        game = left.pop(choose(ranked, further, rng))
        ranking = answer(ranking, example, game, rng)
    return errors


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--demonstrations", default="person-250", help="see tril demo --help")
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--first-seed", type=int, default=300)
    parser.add_argument("--ranked-games", type=int, default=3)
    parser.add_argument("--best-efforts", type=int, default=0, help="that are marked as perfect")
    arguments = parser.parse_args()
    console = SPACE_INVADERS.make_console()
    errors: dict[str, list[list[float]]] = defaultdict(list)
    for behaviour, number in itertools.product(BUILT_IN, range(arguments.seeds)):
        seed = arguments.first_seed + number
        own, others = (
            make(behaviour, arguments.demonstrations, one, console) for one in (seed, seed + 500)
        )
        example = Example(
            own.ranking, [*own.games, *others.games], own.best_efforts, own.true_labels
        )
        ranking = keep_evenly(own.ranking, arguments.ranked_games)
        marked = own.best_efforts[: arguments.best_efforts]
        for (name, choose), repeat in itertools.product(CHOICES.items(), range(N_REPEATS)):
            errors[name].append(ask(example, ranking, marked, choose, (seed, repeat)))
    print(f"| answers | {' | '.join(map(str, ANSWERS))} |\n|---|{'---:|' * len(ANSWERS)}")
    for name, found in errors.items():
        means = np.mean(found, 0)[list(ANSWERS)]
        print(f"| {name} | {' | '.join(f'{mean:.2f}' for mean in means)} |")


if __name__ == "__main__":
    main()
