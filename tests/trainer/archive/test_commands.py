"""The commands that train a run again."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from cli.commands import runs as runs_commands
from cli.main import app
from trainer.archive.commands import commands
from tril.exchange.example import EXAMPLE
from tril.exchange.formats.run_file import RunObject
from tril.exchange.run_archive import read_archive
from tril.games.behaviours import Behaviour
from tril.games.space_invaders.behaviours import BUILT_IN
from tril.recipes import FAST, Recipe, recipe_from_dict, with_values


@pytest.fixture(scope="module")
def shipped() -> RunObject:
    return read_archive(EXAMPLE).run


def changed(run: RunObject, **values: Any) -> RunObject:
    return run.model_copy(update=values)


def test_an_example_is_one_command(shipped: RunObject) -> None:
    assert commands(changed(shipped, recipe=FAST.to_dict()), BUILT_IN[0]) == [
        f"tril demo --behaviour column-1 --recipe fast --steps {shipped.steps} --training-seed 0"
        " --demonstrations person-250"
    ]


def test_a_persons_run_is_its_recordings_and_a_training(shipped: RunObject) -> None:
    run = changed(shipped, example=False, go_on_anyway=False, recipe=FAST.to_dict())
    assert commands(run, BUILT_IN[0]) == [
        "tril recordings import recordings/ranked.jsonl --behaviour column-1 --rank",
        "tril recordings import recordings/perfect.jsonl --behaviour column-1 --perfect",
        f"tril train column-1 --recipe fast --steps {shipped.steps} --training-seed 0",
    ]
    own = Behaviour("two", "Two of them", "", "space_invaders", ((0, 0), (1, 5)), ordered=True)
    assert commands(run, own)[0] == (
        "tril behaviours add --target 1,1 --target 2,6 --ordered -- 'Two of them'"
    )


def test_the_commands_make_the_recipe_that_the_run_had(
    shipped: RunObject, monkeypatch: pytest.MonkeyPatch, data_folder: Path
) -> None:
    recipe = with_values(
        FAST,
        {
            "policy.n_epochs": 2,
            "policy.warm_start": False,
            "policy.freeze_convolutions": False,
            "evaluation.start_numbers": (3,),
            "evaluation.further_start_numbers": (),
            "policy.snapshot_steps": (),
        },
    )
    asked: list[tuple[Recipe, int, int]] = []

    def start_run(_workspace: Any, _of: str, made: Recipe, steps: int, seed: int, **_: Any) -> str:
        asked.append((made, steps, seed))
        return "r1"

    monkeypatch.setattr(runs_commands, "start_run", start_run)
    run = changed(shipped, example=False, recipe=recipe.to_dict(), training_seed=7)
    train = shlex.split(commands(run, BUILT_IN[0])[-1])
    assert train[0] == "tril"
    done = CliRunner().invoke(app, [*train[1:], "--no-wait"])
    assert done.exit_code == 0, done.output
    assert asked == [(recipe_from_dict(recipe.to_dict()), shipped.steps, 7)]
    assert data_folder.exists()
