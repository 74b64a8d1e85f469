"""A whole run in games without a module of their own: recorded, ranked, learned, evaluated."""

from __future__ import annotations

import threading

import numpy as np
import pytest

from testsupport.workplace import TINY_VALUES, Workplace
from trainer.runtime.pipeline import Pipeline
from tril.demonstrators.varied import play_varied
from tril.games import game_named
from tril.games.settings import GameSettings
from tril.recipes import PAPER, with_values
from tril.store import behaviours, rankings, recordings
from tril.store.models import RunStatus, Source
from tril.store.training import evaluations
from tril.teaching.new_run import create_run

TINY_PAPER = with_values(
    PAPER,
    TINY_VALUES | {"name": "tiny-paper", "policy.demonstration_share": 0.5, "cloning.epochs": 1},
)

SETTINGS = {
    "gym:CartPole-v1": GameSettings(),
    "gym:MiniGrid-DoorKey-5x5-v0": GameSettings(max_steps=60),
}


@pytest.mark.lengthy
@pytest.mark.parametrize("name", SETTINGS)
def test_a_run_in_an_environment_is_learned_and_evaluated(workplace: Workplace, name: str) -> None:
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
        run_id = create_run(session, behaviour.id, TINY_PAPER, 64, 0, go_on_anyway=True).id
    pipeline = Pipeline(workplace.database, workplace.settings, "worker-0", threading.Event())
    assert pipeline.train(run_id, pipeline.run_stage) == RunStatus.DONE, workplace.run(
        run_id
    ).message
    with workplace.database.reading() as session:
        evaluated = evaluations.listing(session, run_id)
    assert evaluated
    assert workplace.run(run_id).versions["game_version"] == game.version
