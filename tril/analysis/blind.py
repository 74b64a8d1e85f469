"""The blind comparison: whose game is closer to what was meant, judged without knowing whose it is.

Games of the imitator are shown beside the clone's and beside demonstrations.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import StrEnum
from uuid import UUID

import numpy as np

from tril.analysis.extrapolation import PlayerKind
from tril.analysis.summary import Interval, proportion_interval

PAIRS_PER_OPPONENT = 5
MAX_PAIRS = 2 * PAIRS_PER_OPPONENT
MAX_ROUND = 1000


class BlindAnswer(StrEnum):
    """What a person does in a round, in order of time.

    LEFT, RIGHT and EQUAL judge the next pair. TAKEN_BACK takes the last judgement back. ENDED ends
    the round, after which the players are revealed.
    """

    LEFT = "left"
    RIGHT = "right"
    EQUAL = "equal"
    TAKEN_BACK = "taken back"
    ENDED = "ended"


@dataclass(frozen=True)
class BlindPair:
    """Two games side by side.

    Attributes:
        imitator_id: Recording of the imitator's game.
        other_id: Recording of the other game.
        imitator_left: Whether the imitator's is on the left.
    """

    imitator_id: int
    other_id: int
    imitator_left: bool

    @property
    def sides(self) -> tuple[int, int]:
        """The recordings on the left and on the right."""
        both = (self.imitator_id, self.other_id)
        return both if self.imitator_left else both[::-1]


@dataclass(frozen=True)
class JudgedPair(BlindPair):
    """A pair that a person has judged.

    Attributes:
        number: Number in its round, from 1.
        opponent: Player of the other game.
        answer: Answer to which of the two is closer to what was meant.
    """

    number: int
    opponent: PlayerKind
    answer: BlindAnswer

    @property
    def wins(self) -> float:
        """1 if the imitator's game is closer, 0 if the other one is, a half if they are equal."""
        if self.answer is BlindAnswer.EQUAL:
            return 0.5
        return float((self.answer is BlindAnswer.LEFT) == self.imitator_left)


@dataclass(frozen=True)
class OpponentScore:
    """How often the imitator's game was closer than an opponent's.

    Attributes:
        opponent: Player of the other games.
        wins: Pairs in which it was closer; equal ones count half.
        n: Number of pairs.
    """

    opponent: PlayerKind
    wins: float
    n: int


@dataclass(frozen=True)
class BlindResult:
    """How often the imitator's game was closer to what was meant.

    Attributes:
        wins: Pairs in which it was closer; equal ones count half.
        share: Share of the pairs, with its 95% interval.
        against: Score against each opponent.
        n_people: Number of people whose answers these are.
    """

    wins: float
    share: Interval
    against: list[OpponentScore]
    n_people: int

    @property
    def sentence(self) -> str:
        """The result in words."""
        who = "" if self.n_people == 1 else f" by {self.n_people} people"
        parts = [
            f"{score.wins:g} of {score.n} against the"
            f" {_PLURALS.get(score.opponent, score.opponent)}"
            for score in self.against
        ]
        pairs = "pair" if self.share.n == 1 else "pairs"
        return (
            f"Compared blind{who}, the imitator's game was closer to what was meant in"
            f" {self.wins:g} of {self.share.n} {pairs} ({self.share.low:.0%} to"
            f" {self.share.high:.0%}): {', '.join(parts)}."
        )


_PLURALS: dict[PlayerKind, str] = {
    "clone": "clone's",
    "person": "person's",
    "demonstrator": "demonstrator's",
}


def draw_pairs(
    run_id: str, round_number: int, starts: Sequence[tuple[int, int]], demonstrations: Sequence[int]
) -> list[BlindPair]:
    """Draw the pairs of a round, the same whenever and for whomever they are drawn.

    A game of the imitator is beside the clone's from the same start, or beside a demonstration. Its
    games come twice only where there are too few. It is on the left in every other pair of each
    opponent, before the pairs are shuffled.

    Args:
        run_id: Id of the run, a UUID.
        round_number: Number of the round, from 1.
        starts: Recordings of the imitator's and of the clone's game from each start.
        demonstrations: Recordings to compare with.

    Returns:
        At most MAX_PAIRS pairs, in order.
    """
    if not starts:
        return []
    rng = np.random.default_rng((UUID(run_id).int, round_number))
    games = [starts[place] for place in rng.permutation(len(starts))]
    clones = games[:PAIRS_PER_OPPONENT]
    shown = [demonstrations[place] for place in rng.permutation(len(demonstrations))]
    others = shown[: min(PAIRS_PER_OPPONENT, len(games))]
    beside = [games[(len(clones) + place) % len(games)][0] for place in range(len(others))]
    first = int(rng.integers(2))
    pairs = [
        BlindPair(imitator_id, other_id, (place + first) % 2 == 0)
        for place, (imitator_id, other_id) in enumerate(
            [*clones, *zip(beside, others, strict=True)]
        )
    ]
    return [pairs[place] for place in rng.permutation(len(pairs))]


def blind_result(rounds: Iterable[Sequence[JudgedPair]]) -> BlindResult | None:
    """Return the result of rounds of several people; None if nothing was judged."""
    judged = [pairs for pairs in rounds if pairs]
    if not judged:
        return None
    by_opponent: dict[PlayerKind, list[float]] = defaultdict(list)
    for pair in (pair for pairs in judged for pair in pairs):
        by_opponent[pair.opponent].append(pair.wins)
    wins = sum(map(sum, by_opponent.values()))
    return BlindResult(
        wins=wins,
        share=proportion_interval(wins, sum(map(len, by_opponent.values()))),
        against=[
            OpponentScore(opponent, sum(by_opponent[opponent]), len(by_opponent[opponent]))
            for opponent in sorted(by_opponent)
        ],
        n_people=len(judged),
    )
