"""``tril behaviours``: the behaviours to teach."""

from __future__ import annotations

import json
import re
from dataclasses import asdict, replace
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from rich.table import Table

from cli.output import JsonOption, console, errors, print_json
from cli.workspace import find_behaviour, open_workspace
from tril.demonstrators.varied import play_varied
from tril.errors import Invalid
from tril.exchange import behaviour_transfer
from tril.exchange.formats.behaviour_file import BehaviourRefused
from tril.files.artifact_store import write_whole
from tril.games import DEFAULT_GAME, game_named, ready_made
from tril.games.base import Cell
from tril.games.behaviours import Behaviour
from tril.games.measures import Measure, measure_from_json
from tril.games.settings import GameSettings
from tril.store import audit, behaviours, borrowed, players, rankings
from tril.teaching import varied_games

app = typer.Typer(help="The behaviours to teach.", no_args_is_help=True)

MAX_FILE_BYTES = 256 * 2**20
"""Maximum size of an imported file; 10,000 recordings take about 40 MB."""


@app.command("list")
def list_behaviours(as_json: JsonOption = False) -> None:
    """List the behaviours with their numbers of recordings and runs."""
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
        cells = "none" if target is None else f"{len(target)} items"  # type: ignore[arg-type]
        order = ", in order" if entry["ordered"] else ""
        numbers = (str(entry[key]) for key in ("recordings", "ranked", "perfect", "runs"))
        table.add_row(str(entry["slug"]), str(entry["name"]), cells + order, *numbers)
    console.print(table)


@app.command()
def add(
    name: Annotated[str | None, typer.Argument(help="Name, e.g. 'Left side only'.")] = None,
    description: Annotated[str, typer.Option(help="What a perfect game looks like.")] = "",
    target: Annotated[
        list[str] | None,
        typer.Option(help="A target item as ROW,COLUMN counted from 1, row 1 at the bottom."),
    ] = None,
    ordered: Annotated[bool, typer.Option(help="Targets have to be hit in this order.")] = False,
    game: Annotated[str, typer.Option(help="As `tril games list` names it.")] = DEFAULT_GAME,
    seconds: Annotated[float | None, typer.Option(help="Longest game.")] = None,
    end_rule: Annotated[
        str | None, typer.Option(help="When a loss ends a game; see `tril games show`.")
    ] = None,
    option: Annotated[
        list[str] | None, typer.Option(help="Of the start, e.g. mode=4; see `tril games show`.")
    ] = None,
    measure: Annotated[
        list[str] | None,
        typer.Option(
            help="What tells how well a game shows it, as JSON, e.g."
            ' \'{"kind": "score", "at_least": 100}\'; see docs/behaviour-format.md.'
        ),
    ] = None,
    ready: Annotated[
        str | None,
        typer.Option("--ready-made", help="One that comes with the game; see `tril games show`."),
    ] = None,
) -> None:
    """Add a behaviour: one of your own, or one that comes with its game."""
    with open_workspace() as workspace, workspace.database.writing() as session:
        if ready is not None:
            if target or ordered or seconds or end_rule or option or measure:
                raise Invalid(
                    "A ready-made behaviour is added as it is. Add one of your own instead, or"
                    " change it on the page."
                )
            behaviour = ready_made(game_named(game), ready)
            behaviour = replace(
                behaviour,
                name=name or behaviours.free_name(session, behaviour.name),
                description=description or behaviour.description,
            )
        else:
            if name is None:
                raise Invalid("A behaviour needs a name, or --ready-made.")
            cells = None if target is None else tuple(_cell(text) for text in target)
            clock = game_named(game).clock
            steps = None
            if seconds is not None:
                steps = round(seconds * clock.frame_rate_hz / clock.frames_per_step)
            options = tuple(sorted(_option(text) for text in option or ()))
            settings = GameSettings(None, steps, end_rule, options)
            measures = tuple(map(_measure, measure or ()))
            behaviour = Behaviour("", name, description, game, cells, ordered, settings, measures)
        row = behaviours.create(
            session,
            behaviour.name,
            behaviour.description,
            behaviour.target,
            behaviour.ordered,
            behaviour.game,
            behaviour.settings,
            behaviour.measures,
        )
        console.print(f"Added {row.slug}.")


@app.command()
def delete(behaviour: Annotated[str, typer.Argument(help="Short name.")]) -> None:
    """Delete a behaviour; its recordings and runs stay readable in the database."""
    with open_workspace() as workspace, workspace.database.writing() as session:
        row = find_behaviour(session, behaviour)
        behaviours.delete(session, row)
        console.print(f"Deleted {row.slug}.")


@app.command()
def borrow(
    behaviour: Annotated[str, typer.Argument(help="Short name.")],
    count: Annotated[int, typer.Option(min=1, max=60, help="How many games.")] = 24,
    below_worst: Annotated[
        bool, typer.Option("--below-worst", help="Rank them as one tier below the worst.")
    ] = False,
    as_json: JsonOption = False,
) -> None:
    """Add varied games to rank: up to half from other behaviours, the others of varied play."""
    with open_workspace() as workspace:
        with workspace.database.reading() as session:
            row = find_behaviour(session, behaviour)
        emulator = game_named(row.game).make_console()
        added = varied_games.add_varied_games(
            workspace.database,
            row.id,
            count,
            lambda seed: play_varied(np.random.default_rng(seed), emulator),
            np.random.default_rng(),
        )
        with workspace.database.writing() as session:
            if below_worst:
                newest = rankings.current(session, row.id)
                tiers = [*newest.tiers, added]
                player = players.owner(session)
                rankings.save(session, row.id, newest.revision, tiers, player.id)
            of_others = {game.id for game in borrowed.listing(session, row.id)}
    n_borrowed = len(of_others.intersection(added))
    if as_json:
        print_json({"recordings": added, "borrowed": n_borrowed})
        return
    place = "ranked below the worst" if below_worst else "unranked"
    console.print(
        f"Varied games added to {row.slug}, {place}: {n_borrowed} borrowed,"
        f" {len(added) - n_borrowed} of varied play."
    )


@app.command("export")
def export_file(
    behaviour: Annotated[str, typer.Argument(help="Short name.")],
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="File to write. Default: SHORT-NAME.tril.json."),
    ] = None,
) -> None:
    """Export a behaviour with its recordings and every revision of the ranking to a file."""
    with open_workspace() as workspace:
        with workspace.database.reading() as session:
            row = find_behaviour(session, behaviour)
            content, notices = behaviour_transfer.export_behaviour(session, row)
        place = output or Path(f"{row.slug}.tril.json")
        try:
            write_whole(place, f"{json.dumps(content, indent=1)}\n".encode())
        except OSError as error:
            raise Invalid(f"{place} can't be written: {error.strerror}.") from error
        with workspace.database.writing() as session:
            audit.note(session, audit.Action.EXPORTED, None, f"behaviour {row.id}")
    for notice in notices:
        errors.print(notice, style="yellow")
    console.print(
        f"Wrote {row.slug} to {place}: {len(content['recordings'])} recordings,"
        f" {len(content['rankings'])} revisions of the ranking."
    )


@app.command("import")
def import_file(
    file: Annotated[Path, typer.Argument(help="A file of `tril behaviours export`.")],
    name: Annotated[
        str | None, typer.Option(help="Import as a new behaviour with this name.")
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Import a behaviour from a file after verifying each recording by a replay."""
    with open_workspace() as workspace:
        try:
            if file.stat().st_size > MAX_FILE_BYTES:
                raise Invalid(f"{file} is larger than {MAX_FILE_BYTES // 2**20} MiB.")
            content = file.read_bytes()
        except OSError as error:
            raise Invalid(f"{file} can't be read: {error.strerror}.") from error
        try:
            outcome = behaviour_transfer.import_behaviour(workspace.database, content, name)
        except BehaviourRefused as refusal:
            raise Invalid(f"{file} was refused: {refusal}") from refusal
    if as_json:
        print_json(asdict(outcome))
        return
    for notice in outcome.notices:
        console.print(notice)
    where = "which was empty" if outcome.was_there else "a new behaviour"
    console.print(
        f"Imported into {outcome.slug}, {where}: {outcome.n_recordings} recordings,"
        f" {outcome.n_revisions} revisions of the ranking."
    )


def _option(text: str) -> tuple[str, int]:
    name, _, value = text.partition("=")
    if not re.fullmatch(r"-?\d{1,9}", value):
        raise Invalid(f"Expected an option as NAME=NUMBER, e.g. mode=4, got {text!r}.")
    return name, int(value)


def _measure(text: str) -> Measure:
    try:
        return measure_from_json(json.loads(text))
    except json.JSONDecodeError as error:
        raise Invalid(f"Expected a measure as JSON, got {text!r}: {error}.") from None


def _cell(text: str) -> Cell:
    try:
        row, column = (int(part) for part in text.split(","))
    except ValueError:
        raise Invalid(f"Expected ROW,COLUMN such as 1,6, got {text!r}.") from None
    return row - 1, column - 1
