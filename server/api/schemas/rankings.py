"""Rankings and their revisions."""

from __future__ import annotations

from typing import Annotated

from pydantic import FailFast, Field, StrictBool

from server.api.schemas.base import Id, Schema
from server.understanding import State
from tril.analysis.outcome import StatementAnswer, ToldStatement, WantedAliens
from tril.text import Line

# Otherwise each wrong id is an error, which takes the event loop 40 microseconds.
Tiers = Annotated[
    list[Annotated[list[Id], Field(min_length=1, max_length=500), FailFast()]],
    Field(max_length=500),
    FailFast(),
]


class Ranking(Schema):
    """``tiers`` best first. Unranked are the library's recordings and borrowed ones in no tier.

    Recordings that are not kept or not verified can't be ranked.
    """

    behaviour_id: int
    revision: int
    tiers: list[list[int]]
    n_pairs: int
    can_undo: bool
    can_redo: bool


class RankingUpdate(Schema):
    """``base_revision`` is the revision that was edited; an old one answers 409."""

    base_revision: int = Field(strict=True, ge=0, le=2**31 - 1)
    tiers: Tiers


class RankingStep(Schema):
    """Undo or redo from this revision."""

    base_revision: int = Field(strict=True, ge=0, le=2**31 - 1)


class VariedGamesWish(Schema):
    """How many varied games are to be added; at most half of them are borrowed."""

    count: int = Field(default=24, strict=True, ge=1, le=60)


class BorrowedGames(Schema):
    """Games to borrow, all or none: of other behaviours, or of the policies of any training."""

    recording_ids: list[Id] = Field(min_length=1, max_length=60)


class RankingConflict(Schema):
    """Somebody else saved first: ``current`` is their ranking, ``yours`` what was sent."""

    detail: str
    current: Ranking
    yours: list[list[int]]


class GameOpinion(Schema):
    """Where the other ranked games place a game.

    Places are shares of the ranked games that are better, from 0 for the best to 1, with the ends
    of a central interval of 68%; tiers count from 1. ``contradicted_by`` are ranked games that
    are worth about no more but ranked above it, or about no less but ranked below it; empty unless
    its tier is improbable.
    """

    recording_id: int
    place: float
    best_place: float
    worst_place: float
    tier: int
    best_tier: int
    worst_tier: int
    contradicted_by: list[int]


class RankingOpinion(Schema):
    """What a revision of the ranking says of each game, and which aliens it asks for.

    ``games`` is empty and ``wanted`` null of rankings of fewer than four games or two tiers. Of
    unranked games the newest 60 are looked at, and all perfect ones.
    """

    revision: int
    games: list[GameOpinion]
    wanted: WantedAliens | None


SUBJECT = r"^(thing|pieces|formation|memory|button|time) [a-z0-9:~ -]{1,90}$"
"""See `tril.vocabulary.answers.subject_of`."""

Subjects = Annotated[
    list[Annotated[str, Field(pattern=SUBJECT)]],
    Field(min_length=1, max_length=2),
]


class ShownOrder(Schema):
    """An order that is shown, saved or not; ``with_next`` also asks which game to rank next."""

    tiers: Tiers
    with_next: StrictBool = False


class UnderstoodStatement(ToldStatement):
    """A statement that fits an order; ``pictures`` are those of its things, if there are any."""

    pictures: list[str]


class Meaning(Schema):
    """What may be meant, e.g. "what you steer further to the left or right"."""

    subjects: list[str]
    sentence: str


class NamedThing(Schema):
    """A kind of things on the game's screen, and what may be meant of it.

    ``given`` is the name that somebody gave to it, ``name`` as sentences have it. ``key`` names it
    in any vocabulary of the game.
    """

    kind: int
    key: str
    name: str
    given: str | None
    picture: str | None
    meanings: list[Meaning]


class NamedThings(Schema):
    """What may be meant: of things, what the player steers first, and of what is no thing."""

    things: list[NamedThing]
    others: list[Meaning]


class ThingName(Schema):
    """A name for a kind of things, by its key; an empty one removes the name that it was given."""

    key: str = Field(max_length=80)
    name: Line = Field(max_length=40)


class ThingInSight(Schema):
    """A thing in a step of a recording: its kind, and its box in pixels of the game."""

    kind: int
    left: int
    top: int
    width: int
    height: int


class StatementAnswerUpdate(Schema):
    """An answer to a statement; ``meant`` null takes back what was said of it before."""

    subjects: Subjects
    sentence: Line = Field(max_length=400)
    meant: StrictBool | None


class ContradictingGames(Schema):
    """Two games of which the worse one has more of what was understood."""

    better: int
    worse: int


class NextGame(Schema):
    """An unranked game that tells the first statement from another one.

    ``other`` is the other's place among the statements, from 0. The shares are those of the ranked
    games that it is better than by either.
    """

    recording_id: int
    other: int
    better_than: float
    better_than_by_other: float


class Understanding(Schema):
    """What Tril understands of an order.

    ``progress`` is the share of what is done while it is learning to see the game or watching the
    ranked ones. ``is_sense`` is false if shuffled orders of the games are explained as well.
    ``values`` are those of the games by recording id, in log odds. ``next_game`` is null unless it
    is asked for, and where no game tells statements apart.
    """

    state: State
    progress: float
    statements: list[UnderstoodStatement]
    is_sense: bool | None
    values: dict[int, float]
    contradiction: ContradictingGames | None
    next_game: NextGame | None
    answers: list[StatementAnswer]
