"""``tril demo``: a complete example, from demonstrations that nobody plays to an imitator."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from cli.commands.runs import (
    SeedOption,
    SetOption,
    StepsOption,
    chosen_recipe,
    print_results,
    start_run,
)
from cli.follow import follow_to_end
from cli.output import console, errors
from cli.score_example import describe_games, print_scores, score_example
from cli.workspace import open_workspace
from tril.demonstrators import KINDS, SCRIPTED
from tril.errors import Invalid
from tril.files.artifact_store import ArtifactStore
from tril.games import DEFAULT_GAME, game_named
from tril.recipes import RECIPES

DEFAULT_BEHAVIOUR = "column-1"
N_GAMES = 12
"""Games of an example without a scripted player."""


def demo(
    behaviour: Annotated[
        str | None,
        typer.Option("--behaviour", "-b", help=f"Short name. Default: {DEFAULT_BEHAVIOUR}."),
    ] = None,
    game: Annotated[
        str,
        typer.Option(
            help="As `tril games list` names it. In others than the default, random games ranked by"
            " the game's score are the example."
        ),
    ] = DEFAULT_GAME,
    steps: StepsOption = None,
    recipe: Annotated[
        str, typer.Option(help=f"One of {', '.join(RECIPES)}. Default: as proposed for the game.")
    ] = "",
    training_seed: SeedOption = 0,
    value: SetOption = None,
    demonstrations: Annotated[
        str | None,
        typer.Option(help="; ".join(f"{kind.name}: {kind.summary}" for kind in KINDS) + "."),
    ] = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="Folder for summary and pictures.")
    ] = None,
) -> None:
    """Make demonstrations, rank them, train, evaluate, and write summary and pictures."""
    from trainer.reporting.run_entry import describe_example
    from trainer.reporting.run_report import write_report
    from trainer.reporting.score_results import read_scores

    with open_workspace() as workspace:
        taught = game_named(game)
        has_script = game == DEFAULT_GAME
        if not has_script and (behaviour or demonstrations):
            raise Invalid(
                f"There is no scripted player of {taught.title}, so --behaviour and"
                " --demonstrations can't be chosen: leave them out."
            )
        chosen = chosen_recipe(recipe, value, taught)
        if has_script:
            behaviour = behaviour or DEFAULT_BEHAVIOUR
        else:
            behaviour = score_example(workspace, taught, N_GAMES, training_seed)
        run_id = start_run(
            workspace,
            behaviour,
            chosen,
            steps,
            training_seed,
            go_on_anyway=True,
            example=has_script,
            example_kind=demonstrations or SCRIPTED.name,
        )
        row = follow_to_end(workspace, run_id)
        folder = output or workspace.settings.data / "results" / run_id
        store = ArtifactStore(workspace.settings.artifact_root)
        page = write_report(workspace.database, store, run_id, folder)
        print_results(workspace, row)
        if has_script:
            errors.print("The demonstrations were played by a script, not by a person.")
        else:
            print_scores(read_scores(workspace.database, run_id))
            errors.print(
                f"The demonstrations are {describe_games(taught, N_GAMES)}, ranked by the game's"
                " score: nobody played them, and no person's idea of a good game is in their order."
            )
        if described := describe_example(row.outcome):
            errors.print(described)
        console.print(f"Summary and pictures: {page}", soft_wrap=True)
