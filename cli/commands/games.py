"""``tril games``: the games that can be taught."""

from __future__ import annotations

from typing import Annotated

import typer
from rich.table import Table

from cli.output import JsonOption, console, errors, print_json
from cli.progress import progress_bar
from cli.workspace import open_workspace
from tril.games import game_named, game_titles

app = typer.Typer(help="The games that can be taught.", no_args_is_help=True)


@app.command("list")
def list_games(
    search: Annotated[str, typer.Argument(help="Only those with this in the name.")] = "",
    as_json: JsonOption = False,
) -> None:
    """List the games, in order of their titles."""
    text = search.casefold()
    titles = {
        name: title
        for name, title in game_titles().items()
        if text in name.casefold() or text in title.casefold()
    }
    if as_json:
        print_json([{"name": name, "title": title} for name, title in titles.items()])
        return
    table = Table("game", "title", box=None)
    for name, title in titles.items():
        table.add_row(name, title)
    console.print(table)


@app.command("show")
def show_game(
    name: Annotated[str, typer.Argument(help="The game, as `tril games list` names it.")],
    as_json: JsonOption = False,
) -> None:
    """Show what a game has: its buttons, how it ends, what can be set, what learning sees."""
    game = game_named(name)
    facts = {
        "name": game.name,
        "title": game.title,
        "version": game.version,
        "screen": f"{game.screen.width} x {game.screen.height}",
        "frames a second": game.clock.frame_rate_hz,
        "frames a step": game.clock.frames_per_step,
        "longest game": f"{game.clock.max_steps} steps",
        "actions": ", ".join(game.controls.actions),
        "buttons": ", ".join(game.controls.buttons),
        "ends": "; ".join(f"{end.name}: {end.sentence}" for end in game.ends),
        "rules of a loss": "; ".join(f"{rule.name}: {rule.title}" for rule in game.end_rules),
        "options": "; ".join(
            f"{option}: {', '.join(map(str, values))}"
            for option, values in game.starts.options.items()
        ),
        "hidden from learning": "; ".join(
            f"{area.left}, {area.top} to {area.right}, {area.bottom}" for area in game.screen.hidden
        ),
        "items": "none"
        if game.items is None
        else f"{game.items.rows} x {game.items.columns} {game.items.plural}",
        "things that can be measured": ", ".join(game.things) or "none",
        "counters": ", ".join((*game.counters, *game.tallies)) or "none",
        "ready-made behaviours": ", ".join(behaviour.slug for behaviour in game.behaviours)
        or "none",
        "rewinding": "yes" if game.saves_states else "no: the game does not save states",
    }
    if as_json:
        print_json(facts)
        return
    table = Table(box=None, show_header=False)
    for label, value in facts.items():
        table.add_row(label, str(value))
    console.print(table)


@app.command("prepare")
def prepare_game(
    name: Annotated[str, typer.Argument(help="The game, as `tril games list` names it.")],
) -> None:
    """Make what can be said of a game, from random play, so that no training waits for it."""
    # Loaded when it is used: what looks at screens takes a second to import.
    from tril.vocabulary.making import vocabulary_of

    with open_workspace() as workspace:
        game = game_named(name)
        with progress_bar(f"Looking at {game.title}") as reporter:
            words = vocabulary_of(workspace.settings.data, game, reporter.advance)
    errors.print(
        f"{game.title}: {len(words.kinds)} kinds of things, {len(words.groups)} groups of facts."
    )
