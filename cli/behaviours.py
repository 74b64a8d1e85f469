"""``tril behaviours``: what is being taught."""

from __future__ import annotations

from typing import Annotated

import typer
from rich.table import Table

from cli.output import JsonOption, console, print_json
from cli.workspace import find_behaviour, open_workspace
from tril.behaviours import Cell
from tril.errors import Invalid
from tril.store import behaviours

app = typer.Typer(help="What is being taught.", no_args_is_help=True)


@app.command("list")
def list_behaviours(as_json: JsonOption = False) -> None:
    """List the behaviours with what there is of each."""
    with open_workspace() as workspace, workspace.database.reading() as session:
        counts = behaviours.counts(session)
        entries = [
            {
                "slug": row.slug,
                "name": row.name,
                "target": row.target,
                "ordered": row.ordered,
                "recordings": of.n_recordings,
                "ranked": of.n_ranked,
                "perfect": of.n_perfect,
                "runs": of.n_runs,
            }
            for row in behaviours.listing(session)
            for of in [counts.get(row.id, behaviours.Counts())]
        ]
    if as_json:
        print_json(entries)
        return
    table = Table("behaviour", "name", "target", box=None)
    for title in ("recordings", "ranked", "perfect", "runs"):
        table.add_column(title, justify="right")
    for entry in entries:
        target = entry["target"]
        cells = "none" if target is None else f"{len(target)} aliens"  # type: ignore[arg-type]
        order = ", in order" if entry["ordered"] else ""
        numbers = (str(entry[key]) for key in ("recordings", "ranked", "perfect", "runs"))
        table.add_row(str(entry["slug"]), str(entry["name"]), cells + order, *numbers)
    console.print(table)


@app.command()
def add(
    name: Annotated[str, typer.Argument(help="Name, e.g. 'Left side only'.")],
    description: Annotated[str, typer.Option(help="What a perfect game looks like.")] = "",
    target: Annotated[
        list[str] | None,
        typer.Option(help="A target alien as ROW,COLUMN counted from 1, row 1 at the bottom."),
    ] = None,
    ordered: Annotated[bool, typer.Option(help="They have to be hit in this order.")] = False,
) -> None:
    """Add a behaviour of your own."""
    with open_workspace() as workspace, workspace.database.writing() as session:
        cells = None if target is None else tuple(_cell(text) for text in target)
        row = behaviours.create(session, name, description, cells, ordered)
        console.print(f"Added {row.slug}.")


@app.command()
def delete(behaviour: Annotated[str, typer.Argument(help="Short name.")]) -> None:
    """Delete a behaviour; its recordings and runs stay readable in the database."""
    with open_workspace() as workspace, workspace.database.writing() as session:
        row = find_behaviour(session, behaviour)
        behaviours.delete(session, row)
        console.print(f"Deleted {row.slug}.")


def _cell(text: str) -> Cell:
    try:
        row, column = (int(part) for part in text.split(","))
    except ValueError:
        raise Invalid(f"Expected ROW,COLUMN such as 1,6, got {text!r}.") from None
    return row - 1, column - 1
