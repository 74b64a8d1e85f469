"""What Tril understands of an order of games, while a person makes it."""

from __future__ import annotations

import logging
import threading
from collections import OrderedDict
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from enum import StrEnum
from pathlib import Path
from typing import Self

from sqlalchemy.exc import SQLAlchemyError

from server.play.replays import ReplayProcess
from server.play.replays.request import Told, UnderstandRequest
from server.replay_cache import ReplayCache
from server.vocabularies import VocabularyMaker
from tril.analysis.outcome import ShownMoment
from tril.errors import Invalid, NotFound, Unavailable
from tril.games.base import Clock, Game
from tril.recording import Recording
from tril.vocabulary.answers import Answer
from tril.vocabulary.next_game import NextGame
from tril.vocabulary.watched import Watched

_LOG = logging.getLogger(__name__)

LEAST_GAMES = 4
"""Ranked games from which on there is something to say."""
LEAST_CONTRADICTION = 1.0
"""Log odds by which a game has to be worth more than one above it, to be named."""
MOST_KEPT = 2_000
"""Games that are kept in memory as they were seen, of about 10 kB each."""

Order = Sequence[Sequence[int]]
"""Ids of recordings in tiers, the best first."""
RecordingsOf = Callable[[Sequence[int]], Mapping[int, Recording]]
"""Returns recordings by id; those that do not exist are left out."""


class State(StrEnum):
    """How far Tril is with an order.

    LEARNING: it learns to see the game. FAILED: it could not learn to. WAITING: too few games are
    ranked. WATCHING: it watches the ranked games. READY: it says what it understood.
    """

    LEARNING = "learning"
    FAILED = "failed"
    WAITING = "waiting"
    WATCHING = "watching"
    READY = "ready"


@dataclass(frozen=True)
class ShownStatement:
    """A statement with moments of recordings that show it.

    Attributes:
        told: The statement.
        shown: A moment of a better game in which it holds most; None where nothing differs.
        contrast: A moment of a worse game in which it holds least.
    """

    told: Told
    shown: ShownMoment | None
    contrast: ShownMoment | None

    @classmethod
    def of(cls, told: Told, recording_ids: Sequence[int], clock: Clock) -> Self:
        """Return a statement about games whose rows are those of recordings."""
        moments = told.contrast
        return cls(
            told,
            None if moments is None else moments.most.shown(recording_ids, clock),
            None if moments is None else moments.least.shown(recording_ids, clock),
        )


@dataclass(frozen=True)
class Contradiction:
    """Two games that contradict what was understood of the order.

    Attributes:
        better: The game that is ranked better and worth less.
        worse: The game that is ranked worse and worth more.
    """

    better: int
    worse: int


@dataclass(frozen=True)
class OrderUnderstood:
    """What Tril understands of an order.

    Attributes:
        state: State of the inference.
        progress: Share of what is done, 0 to 1; while it learns or watches.
        statements: The most probable first.
        is_sense: Whether the order is about something rather than drawn by chance; None before it
            is understood.
        values: Value of each watched game, in log odds, keyed by recording id.
        contradiction: The games that contradict most, if any do.
        next_game: The unranked game that tells statements apart best, by its recording's id; None
            if none does.
    """

    state: State
    progress: float = 1.0
    statements: tuple[ShownStatement, ...] = ()
    is_sense: bool | None = None
    values: Mapping[int, float] = field(default_factory=dict)
    contradiction: Contradiction | None = None
    next_game: NextGame | None = None


class OrderReader:
    """Infers what orders are about; thread-safe.

    Facts of recordings are made in the background by the process that replays. What an order is
    about is inferred by a process of its own, so that nobody who drags a game waits for a replay
    and games being played wait for nothing.

    Args:
        vocabularies: Makes vocabularies.
        cache: Watches recordings and keeps what is seen of them.
    """

    def __init__(self, vocabularies: VocabularyMaker, cache: ReplayCache) -> None:
        self._vocabularies = vocabularies
        self._cache = cache
        self._process = ReplayProcess()
        self._lock = threading.Lock()
        self._games: OrderedDict[tuple[str, int], Watched] = OrderedDict()
        self._refused: set[tuple[str, int]] = set()
        self._at_work: set[tuple[str, int]] = set()
        self._stopping = threading.Event()
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="facts")

    def read(
        self,
        game: Game,
        tiers: Order,
        best: Sequence[int],
        answers: Sequence[Answer],
        recordings_of: RecordingsOf,
        unranked: Sequence[int] = (),
        names: Mapping[str, str] | None = None,
    ) -> OrderUnderstood:
        """Infer the statements that an order is about.

        Args:
            game: The game, as its behaviour sets it.
            tiers: The order.
            best: Ids of the best efforts, ranked or not.
            answers: Answers about statements, the latest last.
            recordings_of: Called in another thread.
            unranked: Ids of games of which one may tell statements apart.
            names: Names that people gave to the game's things.

        Raises:
            Unavailable: It could not be inferred.
        """
        making = self._vocabularies.vocabulary(game)
        if making.failed:
            return OrderUnderstood(State.FAILED)
        if making.path is None:
            return OrderUnderstood(State.LEARNING, making.progress)
        ranked = [key for tier in tiers for key in tier]
        recording_ids = list(dict.fromkeys([*ranked, *best, *unranked]))
        seen, n_waiting = self._watched_of(making.path, recording_ids, recordings_of)
        others = [key for key in unranked if key in seen]
        order = [[key for key in tier if key in seen] for tier in tiers]
        order = [tier for tier in order if tier]
        if n_waiting:
            return OrderUnderstood(State.WATCHING, 1 - n_waiting / len(recording_ids))
        if len(order) < 2 or sum(map(len, order)) < LEAST_GAMES:
            return OrderUnderstood(State.WAITING)
        keys = [key for key in dict.fromkeys([*ranked, *best]) if key in seen]
        row = {key: index for index, key in enumerate(keys)}
        understood = self._process.understand(
            UnderstandRequest(
                game,
                making.path,
                tuple(seen[key] for key in keys),
                [[row[key] for key in tier] for tier in order],
                tuple(row[key] for key in best if key in row),
                tuple(answers),
                tuple(seen[key] for key in others),
                names or {},
            )
        )
        telling = understood.next_game
        values = dict(zip(keys, understood.values, strict=True))
        return OrderUnderstood(
            State.READY,
            statements=tuple(
                ShownStatement.of(told, keys, game.clock) for told in understood.statements
            ),
            is_sense=understood.is_sense,
            values=values,
            contradiction=strongest_contradiction(order, values),
            next_game=telling and replace(telling, game=others[telling.game]),
        )

    def stop(self) -> None:
        """Stop after the recording that is watched."""
        self._stopping.set()
        self._thread.shutdown(cancel_futures=True)
        self._process.stop()

    def _watched_of(
        self,
        vocabulary: Path,
        ids: Sequence[int],
        recordings_of: RecordingsOf,
    ) -> tuple[dict[int, Watched], int]:
        """Return what was seen of recordings, and how many are still to be watched."""
        name = vocabulary.stem
        with self._lock:
            seen = {key: self._games[name, key] for key in ids if (name, key) in self._games}
            for key in seen:
                self._games.move_to_end((name, key))
            missing = [key for key in ids if key not in seen and (name, key) not in self._refused]
            unwatched = [key for key in missing if (name, key) not in self._at_work]
            self._at_work.update((name, key) for key in unwatched)
        for key in unwatched:
            self._thread.submit(self._watch, vocabulary, key, recordings_of)
        return seen, len(missing)

    def _watch(self, vocabulary: Path, key: int, recordings_of: RecordingsOf) -> None:
        entry = vocabulary.stem, key
        try:
            if self._stopping.is_set():
                return
            recording = recordings_of([key]).get(key)
            if recording is None:
                raise NotFound("there is no such recording")
            watched = self._cache.watched(recording, vocabulary).without_things()
        except (Invalid, NotFound) as refusal:
            _LOG.warning("Recording %d is left out of what Tril understands: %s", key, refusal)
            with self._lock:
                self._refused.add(entry)
        except (Unavailable, SQLAlchemyError) as failure:
            # Tried again when it is next asked for.
            _LOG.warning("Recording %d is not watched yet: %s", key, failure)
        else:
            with self._lock:
                self._games[entry] = watched
                while len(self._games) > MOST_KEPT:
                    self._games.popitem(last=False)
        finally:
            with self._lock:
                self._at_work.discard(entry)


def strongest_contradiction(order: Order, values: Mapping[int, float]) -> Contradiction | None:
    """Return the two games whose values contradict their order most; None if none do clearly.

    Args:
        order: Ids of games in tiers, the best first.
        values: Values of the games, in log odds.
    """
    largest_gap, pair = LEAST_CONTRADICTION, None
    lowest_above: int | None = None
    # Of the games above, the one of least value contradicts most.
    for tier in order:
        if lowest_above is not None:
            highest = max(tier, key=lambda key: values[key])
            if values[highest] - values[lowest_above] >= largest_gap:
                largest_gap = values[highest] - values[lowest_above]
                pair = Contradiction(lowest_above, highest)
        lowest = min(tier, key=lambda key: values[key])
        if lowest_above is None or values[lowest] < values[lowest_above]:
            lowest_above = lowest
    return pair
