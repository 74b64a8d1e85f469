"""``tril demo``: a whole example, from scripted demonstrations to an evaluated imitator."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from cli.commands.runs import chosen_recipe, print_results, start_run
from cli.follow import follow, say_how_it_ended, standby_worker
from cli.output import console, errors
from cli.workspace import open_workspace
from tril.demonstrator import KINDS, SCRIPTED
from tril.files.artifact_store import ArtifactStore
from tril.recipes import RECIPES


def demo(
    behaviour: Annotated[
        str, typer.Option("--behaviour", "-b", help="Short name of the behaviour.")
    ] = "column-1",
    steps: Annotated[int | None, typer.Option(min=1, help="Steps; else the recipe's.")] = None,
    recipe: Annotated[str, typer.Option(help=f"One of {', '.join(RECIPES)}.")] = "fast",
    training_seed: Annotated[int, typer.Option(min=0, help="Feeds every random choice.")] = 0,
    value: Annotated[
        list[str] | None, typer.Option("--set", help="Change the recipe: NAME=VALUE.")
    ] = None,
    demonstrations: Annotated[
        str, typer.Option(help="; ".join(f"{kind.name}: {kind.summary}" for kind in KINDS) + ".")
    ] = SCRIPTED.name,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="Folder of summary and pictures.")
    ] = None,
) -> None:
    """Make scripted demonstrations, rank them, train, evaluate, and write summary and pictures."""
    from trainer.reporting.run_entry import describe_example
    from trainer.reporting.run_report import write_report

    with open_workspace() as workspace:
        chosen = chosen_recipe(recipe, value)
        run_id = start_run(
            workspace,
            behaviour,
            chosen,
            steps or chosen.default_steps,
            training_seed,
            go_on_anyway=True,
            example=True,
            example_kind=demonstrations,
        )
        with standby_worker(workspace) as worker:
            row = follow(workspace, run_id, worker)
        if not say_how_it_ended(row):
            raise typer.Exit(1)
        folder = output or workspace.settings.data / "results" / run_id
        store = ArtifactStore(workspace.settings.artifact_root)
        page = write_report(workspace.database, store, run_id, folder)
        print_results(workspace, row)
        errors.print("The demonstrations were played by a script, not by a person.")
        if described := describe_example(row.outcome):
            errors.print(described)
        console.print(f"Summary and pictures: {page}", soft_wrap=True)
