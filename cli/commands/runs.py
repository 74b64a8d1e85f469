"""``tril train`` and ``tril runs``: training runs and their results."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.table import Table
from sqlalchemy.orm import Session

from cli.commands.share import share
from cli.follow import duration, follow_to_end
from cli.output import JsonOption, console, errors, print_json
from cli.workspace import Workspace, find_behaviour, open_workspace
from tril.analysis.summary import PolicySummary
from tril.demonstrators import SCRIPTED
from tril.errors import Invalid
from tril.exchange.run_archive import read_archive
from tril.exchange.run_transfer import import_run
from tril.files.artifact_store import ArtifactStore
from tril.games import game_of
from tril.games.base import Game
from tril.jobs import estimate, overall_progress
from tril.recipes import RECIPES, Recipe, recipe_named, recipes_for, with_values
from tril.store import audit, behaviours, players, processes
from tril.store.models import RunDevice, RunRow
from tril.store.training import blind_answers, evaluations, runs
from tril.teaching.new_run import create_run

app = typer.Typer(help="Training runs.", no_args_is_help=True)

ID_LENGTH = 36
"""Length of a run's id, a UUID."""

StepsOption = Annotated[
    int | None,
    typer.Option(min=1, max=100_000_000, help="Steps. Default: what the recipe proposes."),
]
SeedOption = Annotated[int, typer.Option(min=0, max=2**31 - 1, help="Seed of every random choice.")]
SetOption = Annotated[
    list[str] | None, typer.Option("--set", help="Change a value of the recipe: NAME=VALUE.")
]


def start_run(
    workspace: Workspace,
    behaviour: str,
    recipe: Recipe,
    steps: int | None,
    training_seed: int,
    *,
    go_on_anyway: bool = False,
    example: bool = False,
    example_kind: str = SCRIPTED.name,
    parent_run_id: str | None = None,
    device: RunDevice = RunDevice.ANY,
) -> str:
    """Create and enqueue a run; return its id."""
    with workspace.database.writing() as session:
        row = create_run(
            session,
            find_behaviour(session, behaviour).id,
            recipe,
            steps,
            training_seed,
            go_on_anyway=go_on_anyway,
            example=example,
            player_id=players.owner(session).id,
            example_kind=example_kind,
            parent_run_id=parent_run_id,
            device=device,
        )
        lacks_gpu = device is RunDevice.GPU and not processes.is_gpu_worker_alive(session)
        cost = estimate(session, recipe)
        run_id = row.id
        expected_s = row.steps / cost.steps_per_s + cost.overhead_s
    basis = "as measured here" if cost.measured else "on two 2.5 GHz cores"
    errors.print(f"Run {run_id}: about {duration(expected_s)} {basis}.")
    if lacks_gpu:
        errors.print("It waits for a worker with a GPU; none is running.")
    with workspace.jobs() as jobs:
        jobs.enqueue(run_id)
    return run_id


def chosen_recipe(
    name: str, values: list[str] | None, game: Game, has_target: bool = True
) -> Recipe:
    """Return a game's recipe with values such as ``policy.learning_rate=0.001`` replaced.

    Args:
        name: The recipe; "" for the one that is proposed.
        values: The values.
        game: The game.
        has_target: Whether the behaviour says which items are wanted.
    """
    name = name or next(iter(recipes_for(game.pretrained, has_target)))
    changes: dict[str, str] = {}
    for entry in values or []:
        path, equals, changes[path] = entry.partition("=")
        if not equals:
            raise Invalid(f"Expected NAME=VALUE such as policy.n_epochs=4, got {entry!r}.")
    return with_values(recipe_named(name, game.pretrained), changes)


def train(
    behaviour: Annotated[str, typer.Argument(help="Short name of the behaviour.")],
    recipe: Annotated[
        str,
        typer.Option(help=f"One of {', '.join(RECIPES)}; else the one proposed for the behaviour."),
    ] = "",
    steps: StepsOption = None,
    training_seed: SeedOption = 0,
    value: SetOption = None,
    go_on_anyway: Annotated[
        bool, typer.Option(help="Train even if the ranking fails its check.")
    ] = False,
    continue_from: Annotated[
        str | None,
        typer.Option(metavar="RUN_ID", help="Begin with this run's imitator, not with the clone."),
    ] = None,
    device: Annotated[
        RunDevice, typer.Option(help="gpu: only a worker that learns on a GPU takes the run.")
    ] = RunDevice.ANY,
    wait: Annotated[bool, typer.Option(help="Follow the run until it is over.")] = True,
) -> None:
    """Train an imitator and a clone on a behaviour's ranking."""
    with open_workspace() as workspace:
        with workspace.database.reading() as session:
            taught = behaviours.as_behaviour(find_behaviour(session, behaviour))
        chosen = chosen_recipe(recipe, value, game_of(taught), taught.target is not None)
        run_id = start_run(
            workspace,
            behaviour,
            chosen,
            steps,
            training_seed,
            go_on_anyway=go_on_anyway,
            parent_run_id=continue_from,
            device=device,
        )
        if not wait:
            console.print(run_id)
            return
        row = follow_to_end(workspace, run_id)
        print_results(workspace, row)


@app.command("list")
def list_runs(
    behaviour: Annotated[str | None, typer.Option("--behaviour", "-b")] = None,
    as_json: JsonOption = False,
) -> None:
    """List runs, newest first."""
    with open_workspace() as workspace, workspace.database.reading() as session:
        of = None if behaviour is None else find_behaviour(session, behaviour).id
        entries = [run_entry(session, row) for row in runs.listing(session, of)]
    if as_json:
        print_json(entries)
        return
    table = Table(box=None)
    # Whole, so that other commands take it.
    table.add_column("run", no_wrap=True, min_width=ID_LENGTH)
    for title in ("name", "recipe", "status", "stage", "message"):
        table.add_column(title)
    for title in ("steps", "training seed", "done"):
        table.add_column(title, justify="right")
    for entry in entries:
        table.add_row(
            entry["id"],
            entry["name"],
            entry["recipe"],
            entry["status"],
            entry["stage"],
            entry["message"],
            f"{entry['steps']:,}",
            str(entry["training_seed"]),
            f"{entry['progress']:.0%}",
        )
    console.print(table)


@app.command()
def show(run_id: str, as_json: JsonOption = False) -> None:
    """Show a run and its evaluation."""
    with open_workspace() as workspace:
        with workspace.database.reading() as session:
            row = runs.get(session, run_id)
            entry = run_entry(session, row)
            blind = blind_answers.result_of(session, row.id)
        if as_json:
            print_json(
                entry
                | {
                    "outcome": row.outcome.model_dump(mode="json", exclude_unset=True),
                    "recipe_values": row.recipe,
                    "blind": None if blind is None else asdict(blind),
                }
            )
            return
        if row.name:
            console.print(row.name)
        console.print(f"{row.recipe_name}, {row.steps:,} steps: {row.status} {row.message}")
        if row.notes:
            console.print(row.notes)
        if row.parent_run_id is not None:
            console.print(f"Continues run {row.parent_run_id}.")
        print_results(workspace, row)


@app.command()
def cancel(run_id: str) -> None:
    """Cancel a run; it can be resumed from its last checkpoint."""
    with open_workspace() as workspace, workspace.jobs() as jobs:
        jobs.cancel(run_id)
        console.print("Cancelled.")


@app.command()
def resume(run_id: str) -> None:
    """Resume a cancelled, stopped or failed run from its last checkpoint."""
    with open_workspace() as workspace, workspace.jobs() as jobs:
        jobs.resume(run_id)
        console.print("Resumed.")


@app.command("export")
def export(
    run_id: str,
    output: Annotated[Path, typer.Option("--output", "-o", help="Zip file to write.")],
    compact: Annotated[
        bool,
        typer.Option(
            "--compact",
            help="Leave out all that an import does not read, and round policies to 16 bits.",
        ),
    ] = False,
    unlogged: Annotated[
        bool, typer.Option(hidden=True, help="Leave the audit log to who calls this.")
    ] = False,
) -> None:
    """Write a finished run as one zip: report, networks that load without Tril, games, tables."""
    from server.clips.render import render
    from server.clips.request import ClipKind
    from trainer.archive.run_archive import write_archive

    with open_workspace() as workspace:
        store = ArtifactStore(workspace.settings.artifact_root)
        write_archive(
            workspace.database,
            store,
            run_id,
            output,
            lambda recording: render(recording, ClipKind.WEBP),
            compact=compact,
        )
        if not unlogged:
            with workspace.database.writing() as session:
                audit.note(session, audit.Action.EXPORTED, None, f"run {run_id}")
    size = output.stat().st_size
    errors.print(f"Wrote {output} ({size / 1e6:.1f} MB).")


app.command()(share)


@app.command("tensorboard")
def tensorboard(
    run_id: str,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="Folder to write to. Default: tensorboard/RUN_ID."),
    ] = None,
) -> None:
    """Write a run's curves, results and hyperparameters as an event file for TensorBoard."""
    from trainer.archive.tensorboard import write_tensorboard

    with open_workspace() as workspace:
        folder = output or Path("tensorboard") / run_id
        file = write_tensorboard(workspace.database, run_id, folder)
        with workspace.database.writing() as session:
            audit.note(session, audit.Action.EXPORTED, None, f"run {run_id}")
    command = shlex.join(["tensorboard", "--logdir", str(folder)])
    errors.print(f"Wrote {file}. Show it with: {command}")


@app.command("import")
def import_file(
    file: Annotated[Path, typer.Argument(help="What `tril runs export` wrote.")],
    name: Annotated[
        str | None, typer.Option(help="Name of a new behaviour for it. Default: the file's.")
    ] = None,
) -> None:
    """Add a run that was exported, with its games and ranking; each game is replayed first."""
    from trainer.archive.run_archive import check_networks

    with open_workspace() as workspace:
        archive = read_archive(file)
        check_networks(archive)
        store = ArtifactStore(workspace.settings.artifact_root)
        added = import_run(workspace.database, store, archive, name=name)
        with workspace.database.reading() as session:
            of = behaviours.get(session, added.behaviour_id)
        state = "is here already" if added.was_there else "was imported"
        errors.print(f"The run {state}; it teaches {of.name} ({of.slug}).")
        console.print(added.run_id)


def run_entry(session: Session, row: RunRow) -> dict[str, Any]:
    """Return a run as JSON data."""
    return {
        "id": row.id,
        "name": row.name,
        "notes": row.notes,
        "behaviour_id": row.behaviour_id,
        "parent_run_id": row.parent_run_id,
        "recipe": row.recipe_name,
        "steps": row.steps,
        "training_seed": row.training_seed,
        "device": row.device,
        "status": row.status,
        "stage": row.stage,
        "progress": overall_progress(session, row),
        "message": row.message,
        "created_at": row.created_at,
        "finished_at": row.finished_at,
    }


def print_results(workspace: Workspace, row: RunRow) -> None:
    """Print the evaluation games of a run and their means by policy."""
    with workspace.database.reading() as session:
        of = behaviours.get(session, row.behaviour_id)
        games = evaluations.listing(session, row.id)
        n_targets = behaviours.n_targets(session, row.behaviour_id)
        blind = blind_answers.result_of(session, row.id)
    table = Table(
        "start", "policy", "actions", "end", title=of.name, box=None, title_justify="left"
    )
    for title in ("targets", "strays", "predicted return"):
        table.add_column(title, justify="right")
    for game in games:
        name = str(game.start_number) + ("" if game.held_out else " (seen)")
        numbers = ("" if n is None else str(n) for n in (game.targets, game.strays))
        returned = "" if game.predicted_return is None else f"{game.predicted_return:.1f}"
        table.add_row(
            name, game.policy, game.action_selection, game.recording.end or "", *numbers, returned
        )
    console.print(table if games else "No evaluation games yet.")
    _print_means(evaluations.summaries(games, n_targets))
    if blind is not None:
        console.print(blind.sentence)


def _print_means(summaries: Mapping[tuple[str, str], PolicySummary]) -> None:
    """Print the means over games from held-out starts."""
    if not summaries:
        return
    title = "Means over held-out starts, with 95% intervals"
    table = Table("policy", "actions", title=title, box=None, title_justify="left")
    for heading in ("games", "targets", "strays", "death rate", "perfect games"):
        table.add_column(heading, justify="right")
    for (policy, action_selection), summary in summaries.items():
        cells = (
            "" if value is None else f"{value.mean:.2f} ({value.low:.2f} to {value.high:.2f})"
            for value in (summary.targets, summary.strays, summary.death_rate, summary.perfect)
        )
        table.add_row(policy, action_selection, str(summary.steps.n), *cells)
    console.print(table)
