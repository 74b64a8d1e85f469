"""A whole run in games without a module of their own: recorded, ranked, learned, evaluated."""

from __future__ import annotations

import threading

import numpy as np
import pytest

from testsupport.workplace import TINY_VALUES, Workplace
from trainer.runtime import run_data
from trainer.runtime.pipeline import Pipeline
from tril.demonstrators.varied import play_varied
from tril.games import game_named
from tril.games.settings import GameSettings
from tril.recipes import PAPER, Recipe, recipe_named, with_values
from tril.store import answers, behaviours, rankings, recordings
from tril.store.models import RunStatus, Source
from tril.store.training import evaluations
from tril.teaching.new_run import create_run
from tril.vocabulary import making

TINY_PAPER = with_values(
    PAPER,
    TINY_VALUES | {"name": "tiny-paper", "policy.demonstration_share": 0.5, "cloning.epochs": 1},
)

TINY_ANY = with_values(
    recipe_named("any", pretrained=False), TINY_VALUES | {"name": "tiny-any", "reward.folds": 2}
)

SETTINGS = {
    "gym:CartPole-v1": GameSettings(),
    "gym:MiniGrid-DoorKey-5x5-v0": GameSettings(max_steps=60),
    "pong": GameSettings(max_steps=60),
}


@pytest.mark.lengthy
@pytest.mark.parametrize(
    ("name", "recipe"),
    [
        ("gym:CartPole-v1", TINY_ANY),
        ("gym:MiniGrid-DoorKey-5x5-v0", TINY_PAPER),
        ("pong", TINY_ANY),
    ],
    ids=lambda value: value if isinstance(value, str) else value.name,
)
def test_a_run_in_any_game_is_learned_and_evaluated(
    workplace: Workplace, monkeypatch: pytest.MonkeyPatch, name: str, recipe: Recipe
) -> None:
    monkeypatch.setattr(making, "N_GAMES", 3)
    monkeypatch.setattr(run_data, "N_VARIED", 2)
    game = game_named(name).with_settings(SETTINGS[name])
    console = game.make_console()
    rng = np.random.default_rng(0)
    games = sorted(
        (play_varied(rng, console) for _ in range(4)), key=lambda game: game.recording.n_frames
    )
    with workplace.database.writing() as session:
        behaviour = behaviours.create(session, "Stay up", game=name, settings=SETTINGS[name])
        ids = [
            recordings.add(
                session,
                behaviour.id,
                played.recording,
                played.replay,
                Source.SCRIPTED,
                perfect=number == 0,
            ).id
            for number, played in enumerate(reversed(games))
        ]
        rankings.save(session, behaviour.id, 0, [[number] for number in ids])
        answers.give(session, behaviour.id, ["time played"], "the game going on longer", True)
        run_id = create_run(session, behaviour.id, recipe, 64, 0, go_on_anyway=True).id
    pipeline = Pipeline(workplace.database, workplace.settings, "worker-0", threading.Event())
    assert pipeline.train(run_id, pipeline.run_stage) == RunStatus.DONE, workplace.run(
        run_id
    ).message
    with workplace.database.reading() as session:
        evaluated = evaluations.listing(session, run_id)
    assert evaluated
    check = workplace.run(run_id).outcome.check
    assert check is not None
    is_statement = recipe.reward.method == "statement"
    assert bool(check.statements) == is_statement
    assert [one.meant for one in check.answers] == [True] * is_statement
    headline = workplace.run(run_id).outcome.headline
    assert headline is not None
    assert (headline.understood is not None) == is_statement
    if headline.understood:
        assert headline.understood.best.n == 1
        assert headline.understood.imitator is not None
        assert headline.understood.read is not None
        assert headline.understood.read.n == headline.understood.imitator.n
        assert headline.elsewhere is not None
        assert headline.elsewhere.best is None  # there is one
        assert headline.elsewhere.imitator is not None
        assert 0 <= headline.elsewhere.imitator.mean <= 1
    # What was said to be meant is part of all that was understood.
    assert all("the game going on" in one.sentence for one in check.statements)
    assert all("time played" in one.subjects for one in check.statements)
    lengths = dict(zip(ids, (played.recording.n_frames for played in reversed(games)), strict=True))
    moments = [m for one in check.statements for m in (one.shown, one.contrast) if m]
    for moment in moments:
        assert moment.first_frame + moment.n_frames <= lengths[moment.recording_id]
    assert workplace.run(run_id).versions["game_version"] == game.version
