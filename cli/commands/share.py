"""``tril runs share`` and ``tril gallery``: finished runs as pages that need no server."""

from __future__ import annotations

import contextlib
from pathlib import Path
from typing import Annotated
from uuid import UUID

import typer
from sqlalchemy.orm import Session

from cli.output import errors
from cli.workspace import find_behaviour, open_workspace
from tril.errors import Invalid
from tril.files.artifact_store import ArtifactStore
from tril.games import UnknownGame, game_named
from tril.store import audit, behaviours
from tril.store.training import runs


def share(
    run: Annotated[
        str,
        typer.Argument(help="Run, or short name of a behaviour for its newest finished run."),
    ],
    output: Annotated[Path, typer.Option("--output", "-o", help="HTML file to write.")],
    within: Annotated[
        float | None,
        typer.Option(
            help="Seconds to take at most; ranked games that take longer are left out.", min=1
        ),
    ] = None,
    unlogged: Annotated[
        bool, typer.Option(hidden=True, help="Leave the audit log to who calls this.")
    ] = False,
) -> None:
    """Write a finished run as one page that plays its games anywhere, and its poster beside it."""
    from server.web.pages import share_parts
    from trainer.sharing.page import Parts, make_share_page, poster_path, write_share_page

    with open_workspace() as workspace:
        if output.suffix != ".html":
            raise Invalid(f"Expected a name that ends in .html, got {output.name}.")
        poster_path(output)
        with workspace.database.reading() as session:
            run_id = _run_id(session, run)
        store = ArtifactStore(workspace.settings.artifact_root)
        page = make_share_page(
            workspace.database,
            store,
            run_id,
            workspace.settings.data,
            Parts(*share_parts()),
            within_s=within,
        )
        poster = write_share_page(page, output)
        if not unlogged:
            with workspace.database.writing() as session:
                audit.note(session, audit.Action.EXPORTED, None, f"run {run_id}")
    errors.print(f"Wrote {output} ({len(page.html) / 1e6:.2f} MB) and its poster {poster}.")


def gallery(
    folder: Annotated[Path, typer.Argument(help="Folder to write; made if it isn't there.")],
) -> None:
    """Write a page for each behaviour with a finished run, and index.html with a card for each."""
    from server.web.pages import share_parts
    from trainer.sharing.gallery import write_gallery
    from trainer.sharing.page import Parts

    with open_workspace() as workspace:
        shown: dict[str, str] = {}
        with workspace.database.reading() as session:
            for row in behaviours.listing(session):
                newest = runs.newest_done(session, row.id)
                if newest is None:
                    continue
                try:
                    game_named(row.game)
                except (UnknownGame, Invalid) as unknown:
                    errors.print(f"{row.slug} is left out: {unknown}")
                else:
                    shown[row.slug] = newest.id
        if not shown:
            raise Invalid("No behaviour of a game that is installed has a finished run yet.")
        store = ArtifactStore(workspace.settings.artifact_root)
        index = write_gallery(
            workspace.database, store, shown, workspace.settings.data, Parts(*share_parts()), folder
        )
        with workspace.database.writing() as session:
            for run_id in shown.values():
                audit.note(session, audit.Action.EXPORTED, None, f"run {run_id}")
    errors.print(f"Wrote {index}; {', '.join(shown)}.")


def _run_id(session: Session, name: str) -> str:
    """Return the run of this id, or the newest finished one of the behaviour of this name."""
    with contextlib.suppress(ValueError):
        return runs.get_done(session, str(UUID(name))).id
    behaviour = find_behaviour(session, name)
    newest = runs.newest_done(session, behaviour.id)
    if newest is None:
        raise Invalid(f"{behaviour.name} has no finished run yet.")
    return newest.id
