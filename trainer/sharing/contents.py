"""What a share page shows of a run, read from the database."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from trainer.reward.model import RewardModel
from trainer.sharing.figures import Figure, figures_of
from trainer.sharing.words import result_of
from tril.analysis.outcome import ToldStatement
from tril.analysis.verdict import Verdict
from tril.demonstrators import kind_named
from tril.errors import Invalid, NotFound
from tril.files.artifact_store import ArtifactStore
from tril.games import game_of
from tril.games.base import Console, Game
from tril.games.behaviours import Behaviour
from tril.recording import Recording, trajectory
from tril.store import behaviours, recordings
from tril.store.database import Database
from tril.store.models import EvaluationRow, RecordingRow, RunRow
from tril.store.training import artifacts, blind_answers, evaluations, runs
from tril.store.training.alarms import alarm_of
from tril.store.training.demonstrations import best_demonstration
from tril.store.training.judged_games import PLAYERS
from tril.store.training.verdicts import verdict_of
from tril.vocabulary.answers import kinds_about
from tril.vocabulary.facts import Vocabulary
from tril.vocabulary.making import pictures_path, vocabulary_path
from tril.vocabulary.pictures import read_picture

MOST_STATEMENTS = 3
LEVEL_DIGITS = 3


@dataclass(frozen=True)
class SharedGame:
    """A game that a share page plays.

    Attributes:
        number: Id of its recording.
        actor: The player, a key of ``reporting.figures.COLOURS``.
        result: How it came out, in words.
        recording: The recording.
        still_frame: Frame that stands for it.
        place: Place of its tier in the ranking, from 1; 0 if it is not ranked.
        level: Mean level of R of its last states, where it is known.
    """

    number: int
    actor: str
    result: str
    recording: Recording
    still_frame: int
    place: int = 0
    level: float | None = None


@dataclass(frozen=True)
class Statement:
    """What Tril understood, with pictures of the things that it is about as PNGs."""

    sentence: str
    probability: float
    pictures: tuple[bytes, ...]


@dataclass(frozen=True)
class Contents:
    """What a share page shows.

    Attributes:
        run_id: The run.
        title: Name of the run, if it has one.
        about: Facts of the training, in words.
        behaviour: What is taught.
        game: The game as the behaviour sets it.
        verdict: Verdict on the run.
        imitator: The imitator's game; None if it has played none.
        best: The best demonstration, if there is one.
        ranked: The ranked games, the best first.
        n_swapped: Pairs of neighbouring places that the scripted player swapped on purpose.
        statements: What Tril understood, the most probable first.
        figures: At most five.
    """

    run_id: str
    title: str
    about: tuple[str, ...]
    behaviour: Behaviour
    game: Game
    verdict: Verdict | None
    imitator: SharedGame | None
    best: SharedGame | None
    ranked: tuple[SharedGame, ...]
    n_swapped: int
    statements: tuple[Statement, ...]
    figures: tuple[Figure, ...]


def read_contents(database: Database, run_id: str, data: Path) -> Contents:
    """Read what a share page shows.

    Args:
        database: The application's database.
        run_id: The run.
        data: The data folder, which has the pictures of a game's things.

    Raises:
        NotFound: No such run, or its behaviour was deleted.
        Conflict: It is not finished.
    """
    with database.reading() as session:
        run = runs.get_done(session, run_id)
        behaviour = behaviours.as_behaviour(behaviours.get(session, run.behaviour_id))
        game = game_of(behaviour)
        tiers = run.snapshot.tiers if run.snapshot else []
        rows = recordings.by_ids(session, [number for tier in tiers for number in tier])
        games = evaluations.listing(session, run_id)
        best = best_demonstration(session, run)
        played = evaluations.shown_game(games, best)
        check = run.outcome.check
        ranked = tuple(
            _shared(
                rows[number],
                behaviour,
                game,
                place=place,
                level=check.final_levels.get(number) if check else None,
            )
            for place, tier in enumerate(tiers, 1)
            for number in tier
            if number in rows
        )
        return Contents(
            run_id=run_id,
            title=run.name,
            about=_about(run, games, len(ranked)),
            behaviour=behaviour,
            game=game,
            verdict=verdict_of(session, run, alarm_of(session, run)),
            imitator=None if played is None else _shared(played.recording, behaviour, game),
            best=None if best is None else _shared(best, behaviour, game),
            ranked=ranked,
            n_swapped=kind_named(run.example_kind).n_mistakes if run.example else 0,
            statements=_statements(check.statements if check else (), data, game),
            figures=tuple(
                figures_of(
                    run,
                    behaviour,
                    game,
                    games,
                    list(rows.values()),
                    blind_answers.result_of(session, run_id),
                )
            ),
        )


def levels_of(
    database: Database,
    store: ArtifactStore,
    contents: Contents,
    games: Sequence[SharedGame],
    console: Console,
) -> Mapping[int, list[float]]:
    """Return the level of the learned reward at every step of some games, by their numbers.

    Args:
        database: The application's database.
        store: The artifact store.
        contents: What the page shows of the run.
        games: The games.
        console: A console of their game.

    Returns:
        Empty if the run has no reward model.
    """
    try:
        with artifacts.local_file(database, store, contents.run_id, "reward_model") as file:
            model = RewardModel.load(file)
    except NotFound:
        return {}
    levels = {}
    for shared in games:
        seen = trajectory(shared.recording.with_hidden_areas_of(contents.game), console)
        values = model.level(model.score(seen.observations)).astype(np.float64)
        # Adding zero makes zero of its negative.
        levels[shared.number] = (values.round(LEVEL_DIGITS) + 0.0).tolist()
    return levels


def _shared(
    row: RecordingRow,
    behaviour: Behaviour,
    game: Game,
    place: int = 0,
    level: float | None = None,
) -> SharedGame:
    taken = recordings.taken_of(row)
    return SharedGame(
        number=row.id,
        actor=PLAYERS[row.source],
        result=result_of(row, behaviour, game),
        recording=recordings.as_recording(row),
        # The moment after the last item was taken, else one when the game is well under way.
        still_frame=taken[-1].frame if taken else row.n_frames * 2 // 3,
        place=place,
        level=level,
    )


def _about(run: RunRow, games: Sequence[EvaluationRow], n_ranked: int) -> tuple[str, ...]:
    finished = "" if run.finished_at is None else f"finished {run.finished_at:%Y-%m-%d}"
    n_played = sum(row.policy == "imitator" for row in games)
    facts = (
        f"learned from {n_ranked} ranked games" if n_ranked else "",
        f"{run.steps:,} steps of practice",
        f"{n_played} games played to test it" if n_played else "",
        finished,
    )
    return tuple(fact for fact in facts if fact)


def _statements(told: Sequence[ToldStatement], data: Path, game: Game) -> tuple[Statement, ...]:
    path = pictures_path(data, game)
    try:
        words = Vocabulary.load(vocabulary_path(data, game))
    except Invalid:
        # There are no pictures either before Tril has learned to see the game.
        return tuple(Statement(one.sentence, one.probability, ()) for one in told[:MOST_STATEMENTS])
    return tuple(
        Statement(
            statement.sentence,
            statement.probability,
            tuple(
                picture
                for kind in kinds_about(words, statement.subjects)
                if (picture := read_picture(path, kind)) is not None
            ),
        )
        for statement in told[:MOST_STATEMENTS]
    )
