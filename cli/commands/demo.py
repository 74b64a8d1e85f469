"""``tril demo``: a complete example, from scripted demonstrations to an evaluated imitator."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from cli.commands.runs import (
    RecipeOption,
    SeedOption,
    SetOption,
    StepsOption,
    chosen_recipe,
    print_results,
    start_run,
)
from cli.follow import follow_to_end
from cli.output import console, errors
from cli.workspace import open_workspace
from tril.demonstrators import KINDS, SCRIPTED
from tril.files.artifact_store import ArtifactStore
from tril.games import DEFAULT_GAME, game_named


def demo(
    behaviour: Annotated[
        str, typer.Option("--behaviour", "-b", help="Short name of the behaviour.")
    ] = "column-1",
    steps: StepsOption = None,
    recipe: RecipeOption = "fast",
    training_seed: SeedOption = 0,
    value: SetOption = None,
    demonstrations: Annotated[
        str, typer.Option(help="; ".join(f"{kind.name}: {kind.summary}" for kind in KINDS) + ".")
    ] = SCRIPTED.name,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="Folder for summary and pictures.")
    ] = None,
) -> None:
    """Make scripted demonstrations, rank them, train, evaluate, and write summary and pictures."""
    from trainer.reporting.run_entry import describe_example
    from trainer.reporting.run_report import write_report

    with open_workspace() as workspace:
        chosen = chosen_recipe(recipe, value, game_named(DEFAULT_GAME))
        run_id = start_run(
            workspace,
            behaviour,
            chosen,
            steps,
            training_seed,
            go_on_anyway=True,
            example=True,
            example_kind=demonstrations,
        )
        row = follow_to_end(workspace, run_id)
        folder = output or workspace.settings.data / "results" / run_id
        store = ArtifactStore(workspace.settings.artifact_root)
        page = write_report(workspace.database, store, run_id, folder)
        print_results(workspace, row)
        errors.print("The demonstrations were played by a script, not by a person.")
        if described := describe_example(row.outcome):
            errors.print(described)
        console.print(f"Summary and pictures: {page}", soft_wrap=True)
