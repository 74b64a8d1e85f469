"""The blind comparison of a training's games.

Nothing returned before a round is over identifies a game.
"""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from server.api.schemas.base import Schema
from server.api.schemas.recordings import Recording
from tril.analysis.blind import MAX_PAIRS, MAX_ROUND, BlindAnswer, BlindResult
from tril.analysis.extrapolation import PlayerKind

BlindJudgement = Literal[BlindAnswer.LEFT, BlindAnswer.RIGHT, BlindAnswer.EQUAL]

BlindSide = Literal["left", "right"]


class BlindAnswerNew(Schema):
    """What a person does in their round.

    ``pair`` is the one that is judged, counted from 1; for TAKEN_BACK and ENDED, the last judged
    pair.
    """

    round: int = Field(strict=True, ge=1, le=MAX_ROUND)
    pair: int = Field(strict=True, ge=1, le=MAX_PAIRS)
    answer: BlindAnswer


class RevealedPair(Schema):
    """A pair of a round that is over."""

    opponent: PlayerKind
    imitator_left: bool
    answer: BlindJudgement
    imitator: Recording
    other: Recording


class FinishedBlindRound(Schema):
    """A person's round that is over, with whose games they were."""

    number: int
    result: BlindResult
    pairs: list[RevealedPair]


class BlindComparison(Schema):
    """A person's blind comparison of a training's games.

    ``round`` is the number of the round that they are in or begin next, of ``n_pairs`` pairs;
    ``answers`` are theirs to its first pairs. ``frames_url`` leads to the frames of a pair's side,
    once ``{pair}`` and ``{side}`` ("left" or "right") are filled in. ``finished`` are their
    rounds that are over, the newest first.
    """

    round: int
    n_pairs: int
    answers: list[BlindJudgement]
    frames_url: str
    finished: list[FinishedBlindRound]
