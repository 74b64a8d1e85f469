"""Requests to the replay process and their answers. Pure."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from functools import lru_cache
from pathlib import Path

import numpy as np

from server.play.replays.products import (
    frames_file,
    memory_file,
    observations_file,
    thumbnail_png,
)
from server.play.replays.strip import Reel, strip_webp
from tril.demonstrators.varied import play_varied
from tril.exchange.formats.recording_file import ImportedRecording, load_recording
from tril.games import game_named
from tril.games.base import Cell, Console, Game
from tril.games.measures import Measure
from tril.games.measuring import Values
from tril.play.consoles import Consoles
from tril.recording import Recording, Verified, verify
from tril.vocabulary.answers import Answer as StatementAnswer
from tril.vocabulary.facts import Vocabulary
from tril.vocabulary.moments import Contrast
from tril.vocabulary.next_game import NextGame, next_game
from tril.vocabulary.posterior import NothingPossible, Tiers
from tril.vocabulary.sentences import tell
from tril.vocabulary.understanding import shuffles_as_good, understand
from tril.vocabulary.watched import Watched


class ReplayTask(StrEnum):
    """What to replay a recording for; the value is a product's file name extension."""

    CHECK = "check"
    FRAMES = "frames"
    THUMBNAIL = "png"
    STRIP = "strip"
    MEMORY = "ram"
    OBSERVATIONS = "obs"


@dataclass(frozen=True)
class Request:
    """A request for a replay.

    Attributes:
        task: Task of the replay.
        recording: The recording.
        taken: For a check, the items that it is said to take, in order of time.
    """

    task: ReplayTask
    recording: Recording
    taken: tuple[Cell, ...] = ()


@dataclass(frozen=True)
class VariedPlayRequest:
    """A request for a game of varied play.

    Attributes:
        game: Name of the game.
        seed: Seed of all that is drawn for it.
    """

    game: str
    seed: int


@dataclass(frozen=True)
class LoadRequest:
    """A request to load a recording from the exchange format and verify it.

    Attributes:
        content: Parsed JSON.
    """

    content: object


@dataclass(frozen=True)
class MeasureRequest:
    """A request to measure a recording in a replay.

    Attributes:
        recording: The recording.
        measures: Measures to take.
    """

    recording: Recording
    measures: tuple[Measure, ...]


@dataclass(frozen=True)
class WatchRequest:
    """A request to see a recording in the terms of its game's vocabulary, as `Watched.pack` does.

    Attributes:
        recording: The recording.
        vocabulary: File of its game's vocabulary.
    """

    recording: Recording
    vocabulary: Path


@dataclass(frozen=True)
class UnderstandRequest:
    """A request to infer what an order is about.

    Attributes:
        game: The game.
        vocabulary: File of its vocabulary.
        games: The games.
        tiers: Rows of the ranked games, the best tier first.
        best: Rows of the best efforts.
        answers: Answers about statements, the latest last.
        unranked: Games of which one may tell statements apart.
        names: Names that people gave to the game's things, see `Vocabulary.with_names`.
    """

    game: Game
    vocabulary: Path
    games: tuple[Watched, ...]
    tiers: Tiers
    best: tuple[int, ...]
    answers: tuple[StatementAnswer, ...]
    unranked: tuple[Watched, ...] = ()
    names: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Told:
    """A statement as a person reads it, see `tril.vocabulary.sentences.Telling`.

    Attributes:
        sentence: Sentence for the person.
        probability: Probability of the statement.
        subjects: Subjects of the statement.
        kinds: Kinds of things that it is about.
        detail: Bytes of memory that it was read from, for experts.
        contrast: Moments of the ranked games that show it, by the games' rows; None if none do.
    """

    sentence: str
    probability: float
    subjects: tuple[str, ...]
    kinds: tuple[int, ...]
    detail: str = ""
    contrast: Contrast | None = None


@dataclass(frozen=True)
class Understood:
    """What an order is about.

    Attributes:
        statements: The most probable first; none if the answers exclude all.
        is_sense: Whether they explain the order better than all shuffled ones.
        values: Value of each game, in log odds.
        next_game: The unranked game that tells statements apart best; None if none does.
    """

    statements: tuple[Told, ...]
    is_sense: bool
    values: tuple[float, ...]
    next_game: NextGame | None = None


AnyRequest = (
    Request | VariedPlayRequest | LoadRequest | MeasureRequest | WatchRequest | UnderstandRequest
)
Content = bytes | Verified | ImportedRecording | Values | Understood


@dataclass(frozen=True)
class Answer:
    """The answer to a request.

    Attributes:
        content: The product, the film strip for a check; or the game that was played, or loaded; or
            values of measures; or what an order is about.
        refusal: Why the recording does not replay; None if it does.
        unknown_game: That its game is not installed; None if it is.
        failure: A traceback, if something else went wrong.
    """

    content: Content = b""
    refusal: str | None = None
    unknown_game: str | None = None
    failure: str | None = None


_PRODUCTS: Mapping[ReplayTask, Callable[[Recording, Console], bytes]] = {
    ReplayTask.FRAMES: frames_file,
    ReplayTask.THUMBNAIL: thumbnail_png,
    ReplayTask.STRIP: strip_webp,
    ReplayTask.MEMORY: memory_file,
    ReplayTask.OBSERVATIONS: observations_file,
}


def execute(request: AnyRequest, consoles: Consoles) -> Content:
    """Replay a recording and return the product, its film strip for a check; or play or load one.

    Values are returned for a request to measure.

    Raises:
        RecordingRefused: The replay differs from what was recorded.
    """
    if isinstance(request, UnderstandRequest):
        return _understand(request)
    if isinstance(request, VariedPlayRequest):
        return play_varied(
            np.random.default_rng(request.seed), consoles.of(game_named(request.game))
        )
    if isinstance(request, LoadRequest):
        return load_recording(request.content, consoles)
    console = consoles.of(request.recording.game)
    if isinstance(request, MeasureRequest):
        verified = verify(request.recording, console=console, measures=request.measures)
        return verified.replay.measured
    if isinstance(request, WatchRequest):
        words = _vocabulary(request.vocabulary)
        return Watched.of(request.recording, console, words).pack()
    if request.task is ReplayTask.CHECK:
        reel = Reel(request.recording)
        verify(request.recording, request.taken, console, on_frame=reel.add)
        return reel.webp()
    return _PRODUCTS[request.task](request.recording, console)


@lru_cache(maxsize=4)
def _vocabulary(path: Path) -> Vocabulary:
    return Vocabulary.load(path)


def _understand(request: UnderstandRequest) -> Understood:
    words = _vocabulary(request.vocabulary).with_names(request.names)
    summaries = np.stack([game.summary for game in request.games])
    order = words, summaries, request.tiers, request.best, request.answers
    try:
        understanding = understand(*order)
    except NothingPossible:
        return Understood((), True, (0.0,) * len(summaries))
    seconds = [game.seconds for game in request.games]
    tellings = tell(words, understanding.posterior, request.game, understanding.meant)
    ranked = [row for tier in request.tiers for row in tier]
    return Understood(
        tuple(
            Told(
                telling.sentence,
                telling.probability,
                telling.subjects,
                telling.kinds,
                telling.detail,
                understanding.contrast(telling.statement, seconds, request.tiers),
            )
            for telling in tellings
        ),
        not shuffles_as_good(*order),
        tuple(understanding.value(summaries).tolist()),
        next_game(
            understanding,
            tellings,
            summaries[ranked],
            np.array([game.summary for game in request.unranked]),
        ),
    )
