"""``tril recordings``: the library of recordings."""

from __future__ import annotations

import json
import sys
from contextlib import nullcontext
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table
from rich.text import Text

from cli.output import JsonOption, console, errors, print_json
from cli.workspace import find_behaviour, open_workspace
from tril.errors import Invalid
from tril.exchange import recording_transfer
from tril.files.artifact_store import whole_file
from tril.games.behaviours import score
from tril.recording import RecordingRefused, verify
from tril.store import audit, behaviours, players, recordings

app = typer.Typer(help="The library of recordings.", no_args_is_help=True)

BehaviourOption = Annotated[str, typer.Option("--behaviour", "-b", help="Short name.")]


@app.command("list")
def list_recordings(behaviour: BehaviourOption, as_json: JsonOption = False) -> None:
    """List a behaviour's recordings, newest first."""
    table = Table("recording", "source", "end", "verified", "perfect", "notes", box=None)
    for title in ("targets", "strays", "seconds"):
        table.add_column(title, justify="right")
    with open_workspace() as workspace, workspace.database.reading() as session:
        of = find_behaviour(session, behaviour)
        taught = behaviours.as_behaviour(of)
        for row in recordings.in_order(session, recordings.library_ids(session, of.id)):
            result = score(taught, tuple((r, c) for r, c, _ in row.taken))
            if as_json:
                print_json(
                    {
                        "id": row.id,
                        "number": row.number,
                        "source": row.source,
                        "frames": row.n_frames,
                        "end": row.end,
                        "hits": row.taken,
                        "targets": result.targets if result else None,
                        "strays": result.strays if result else None,
                        "order_errors": result.order_errors if result else None,
                        "perfect": row.perfect,
                        "verification": row.verification,
                        "notes": row.notes,
                    }
                )
                continue
            table.add_row(
                "" if row.number is None else str(row.number),
                row.source,
                row.end or "",
                row.verification,
                "yes" if row.perfect else "",
                row.notes,
                str(result.targets) if result else "",
                str(result.strays) if result else "",
                f"{row.n_frames / 60:.1f}",
            )
    if not as_json:
        console.print(table)


@app.command("import")
def import_files(
    files: Annotated[
        list[Path], typer.Argument(help="Recordings or action lists: JSON or JSON Lines.")
    ],
    behaviour: BehaviourOption,
    rank: Annotated[
        bool, typer.Option("--rank", help="Rank the recordings in the files' order, best first.")
    ] = False,
    perfect: Annotated[
        bool, typer.Option("--perfect", help="Mark all recordings as perfect.")
    ] = False,
    as_json: JsonOption = False,
) -> None:
    """Import recordings after verifying each by a replay."""
    refused = 0
    with open_workspace() as workspace:
        with workspace.database.reading() as session:
            of, player = find_behaviour(session, behaviour).id, players.owner(session).id
        for path in files:
            try:
                content = path.open("rb")
            except OSError as error:
                raise Invalid(f"{path} can't be read: {error.strerror}.") from error
            with content:
                outcome = recording_transfer.import_recordings(
                    workspace.database, of, content, rank=rank, perfect=perfect, player_id=player
                )
            refused += outcome.n_refused
            _report(path, outcome, as_json)
    if refused:
        raise typer.Exit(1)


@app.command("export")
def export(
    behaviour: BehaviourOption,
    output: Annotated[Path | None, typer.Option("--output", "-o", help="File to write.")] = None,
) -> None:
    """Export a behaviour's recordings as JSON Lines, ranked ones first, best to worst."""
    with open_workspace() as workspace:
        n_written = 0
        with workspace.database.reading() as session:
            of = find_behaviour(session, behaviour)
            with whole_file(output) if output else nullcontext(sys.stdout.buffer) as file:
                for entry in recording_transfer.export_recordings(session, of.id):
                    file.write(f"{json.dumps(entry)}\n".encode())
                    n_written += 1
        with workspace.database.writing() as session:
            subject = f"behaviour {of.id}"
            audit.note(session, audit.Action.EXPORTED, None, subject, recordings=n_written)
    if output is not None:
        errors.print(f"Wrote {n_written} recordings to {output}.")


@app.command("verify")
def verify_all(behaviour: BehaviourOption) -> None:
    """Verify every recording of a behaviour by a replay."""
    with open_workspace() as workspace:
        with workspace.database.reading() as session:
            ids = recordings.library_ids(session, find_behaviour(session, behaviour).id)
        wrong = 0
        for key in ids:
            # No transaction is open while it is replayed.
            with workspace.database.reading() as session:
                row = recordings.get(session, key)
            try:
                verify(recordings.as_recording(row), recordings.cells_of(row))
            except RecordingRefused as refusal:
                wrong += 1
                errors.print(f"{row.title}: {refusal}")
        console.print(f"{len(ids) - wrong} of {len(ids)} recordings verify.")
    if wrong:
        raise typer.Exit(1)


def _report(path: Path, outcome: recording_transfer.RecordingImportResult, as_json: bool) -> None:
    if as_json:
        print_json(
            {
                "file": str(path),
                "imported": outcome.recording_ids,
                "already_there": outcome.already_there,
                "notices": [asdict(message) for message in outcome.notices],
                "refusals": [asdict(message) for message in outcome.refusals],
                "n_notices": outcome.n_notices,
                "n_refused": outcome.n_refused,
            }
        )
        return
    duplicates = f", {len(outcome.already_there)} already there" if outcome.already_there else ""
    console.print(f"{path}: {len(outcome.recording_ids)} imported{duplicates}")
    for message in outcome.notices:
        console.print(f"  line {message.line}: {message.reason}")
    if n_left_out := outcome.n_notices - len(outcome.notices):
        console.print(f"  and {n_left_out:,} more notices")
    for message in outcome.refusals:
        label = f"  line {message.line} refused:"
        errors.print(Text.assemble((label, "red"), f" {message.reason}"))
    if n_left_out := outcome.n_refused - len(outcome.refusals):
        errors.print(f"  and {n_left_out:,} more lines refused", style="red")
