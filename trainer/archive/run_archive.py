"""A finished run as one zip file: its report, networks, games and tables.

It opens, and its networks load, where there is no Tril; ``tril runs import`` reads it again.
"""

from __future__ import annotations

import base64
import json
import re
import tempfile
import zipfile
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

from trainer.archive.commands import commands
from trainer.archive.games import best_and_worst
from trainer.archive.tables import curves_table, evaluation_table
from trainer.archive.tensorboard import write_tensorboard
from trainer.policy.networks import load_network, save_policy, save_weights
from trainer.reporting.figures import PRINT, VECTOR
from trainer.reporting.rendering import render
from trainer.reporting.run_report import RunReport, read_report
from trainer.reward.model import RewardModel
from tril import __version__
from tril.errors import Invalid
from tril.exchange.recording_transfer import dump_row
from tril.exchange.run_archive import EVALUATION, NETWORKS, RANKED, RUN_FILE, UNRANKED, RunArchive
from tril.exchange.run_transfer import ExportedRun, export_run
from tril.files.artifact_store import ArtifactStore, write_whole
from tril.games import game_named
from tril.recording import Recording
from tril.store import behaviours, recordings
from tril.store.database import Database
from tril.store.models import RecordingRow
from tril.store.training import artifacts, evaluations, metrics, runs
from tril.store.training.evaluations import POLICIES

MakeClip = Callable[[Recording], bytes]
"""Returns a recording as an animated WebP."""

STANDALONE = Path(__file__).with_name("standalone")
PROGRAMS = ("load_policy.py", "reward_wrapper.py")

_EPOCH = (1980, 1, 1, 0, 0, 0)
"""The earliest time that a zip file can hold: members have no time of their own."""


def write_archive(
    database: Database,
    store: ArtifactStore,
    run_id: str,
    path: Path,
    make_clip: MakeClip,
    *,
    compact: bool = False,
) -> None:
    """Write a finished run's archive.

    Args:
        database: The application's database.
        store: The artifact store.
        run_id: The run.
        path: The file, replaced as a whole.
        make_clip: Makes the clips of the report.
        compact: Whether to leave out all that ``tril runs import`` does not read, and to round the
            policies to half precision.

    Raises:
        NotFound: No such run, or its behaviour was deleted.
        Conflict: It is not finished.
        Invalid: The run's recipe belongs to another version.
    """
    with database.reading() as session:
        exported = export_run(session, run_id)
        series = metrics.series(session, run_id)[1]
        games = evaluations.listing(session, run_id)
        behaviour = behaviours.get(session, runs.get(session, run_id).behaviour_id)
        actions = game_named(behaviour.game).controls.actions
    with tempfile.TemporaryDirectory(prefix="tril-archive-") as name:
        folder = Path(name)
        members = dict(_data(exported)) | dict(
            _networks(database, store, run_id, folder, actions, compact)
        )
        report = read_report(database, store, run_id)
        members |= {f"attention/{name}": content for name, content in _pictures(report)}
        if not compact:
            members |= dict(_for_stable_baselines3(database, store, run_id, folder))
            members |= {name: (STANDALONE / name).read_bytes() for name in PROGRAMS}
            members["curves.csv"] = curves_table(series).encode()
            members["evaluation.csv"] = evaluation_table(games).encode()
            events = write_tensorboard(database, run_id, folder / "tensorboard")
            members[f"tensorboard/{events.name}"] = events.read_bytes()
            members["recipe.json"] = _json(exported.run.recipe)
            members |= dict(_pages(report, exported, make_clip))
        write_whole(path, _zipped(folder / "archive.zip", members))


def check_networks(archive: RunArchive) -> None:
    """Load the networks of an archive, as training and inference would.

    Raises:
        Invalid: One of them does not load.
    """
    with tempfile.TemporaryDirectory(prefix="tril-archive-") as name:
        for kind, content in archive.networks.items():
            path = Path(name) / NETWORKS[kind].rpartition("/")[2]
            path.write_bytes(content)
            try:
                if kind in POLICIES:
                    load_network(path)
                else:
                    RewardModel.load(path)
            except (TypeError, ValueError) as error:
                raise Invalid(f"{path.name} cannot be read: {error}") from error


def _data(exported: ExportedRun) -> Iterator[tuple[str, bytes]]:
    run = exported.run
    yield RUN_FILE, run.model_dump_json(exclude_unset=True, indent=1).encode()
    tiers = {number: place for place, tier in enumerate(run.tiers, start=1) for number in tier}
    yield RANKED, _lines(exported.ranked, tiers)
    yield UNRANKED, _lines(exported.unranked, {})
    yield EVALUATION, _lines((game.recording for game in exported.evaluation), {})


def _lines(rows: Iterable[RecordingRow], tiers: dict[int, int]) -> bytes:
    lines = (json.dumps(dump_row(row, tiers.get(row.id))) for row in rows)
    return "".join(f"{line}\n" for line in lines).encode()


def _networks(
    database: Database,
    store: ArtifactStore,
    run_id: str,
    folder: Path,
    actions: Sequence[str],
    half: bool,
) -> Iterator[tuple[str, bytes]]:
    for kind, name in NETWORKS.items():
        with artifacts.local_file(database, store, run_id, kind) as file:
            if kind in POLICIES:
                written = folder / f"{kind}.safetensors"
                save_weights(load_network(file), written, actions, half=half)
                yield name, written.read_bytes()
            else:
                yield name, file.read_bytes()


def _for_stable_baselines3(
    database: Database, store: ArtifactStore, run_id: str, folder: Path
) -> Iterator[tuple[str, bytes]]:
    for kind in POLICIES:
        with artifacts.local_file(database, store, run_id, kind) as file:
            if file.suffix != ".zip":
                # An imported run has none.
                network, file = load_network(file), folder / f"{kind}.zip"
                save_policy(network, file)
            yield f"policy/{kind}.zip", file.read_bytes()


def _pictures(report: RunReport) -> Iterator[tuple[str, bytes]]:
    yield from ((n, content) for n, content in report.attention.items() if n.endswith(".png"))


def _pages(
    report: RunReport, exported: ExportedRun, make_clip: MakeClip
) -> Iterator[tuple[str, bytes]]:
    figures = {name: draw(form=VECTOR) for name, draw in report.figures.items()}
    for name, draw in report.figures.items():
        yield f"figures/{name}.svg", figures[name]
        yield f"figures/{name}.png", draw(form=PRINT)
    clips = [
        (title, game, _data_url(make_clip(recordings.as_recording(game.recording)), "image/webp"))
        for title, game in best_and_worst(exported.evaluation)
    ]
    lines = commands(exported.run, report.view["behaviour"])
    view = report.view | {
        "run": exported.run,
        "recipe_values": _flat(exported.run.recipe),
        "commands": lines,
        # Longer than any fence that a name may hold.
        "fence": "`" * max(3, 1 + max(map(len, re.findall("`+", "".join(lines))), default=0)),
        "tril": __version__,
    }
    drawn = {name: content.decode().partition("<svg")[2] for name, content in figures.items()}
    page = render(
        "run.html.j2",
        **view,
        figures={name: f"<svg{markup}" for name, markup in drawn.items()},
        clips=clips,
        pictures={n: _data_url(content, "image/png") for n, content in _pictures(report)},
    )
    yield "report.html", page.encode()
    yield "model-card.md", render("model-card.md.j2", **view).encode()


def _flat(recipe: dict[str, Any]) -> dict[str, Any]:
    """Return a recipe's values by dotted path."""
    values: dict[str, Any] = {}
    for name, value in recipe.items():
        inner = {f"{name}.{k}": v for k, v in value.items()} if isinstance(value, dict) else {}
        values |= inner or {name: value}
    return values


def _data_url(content: bytes, media_type: str) -> str:
    return f"data:{media_type};base64,{base64.b64encode(content).decode()}"


def _json(values: Any) -> bytes:
    return f"{json.dumps(values, indent=1)}\n".encode()


def _zipped(path: Path, members: dict[str, bytes]) -> bytes:
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        for name, content in sorted(members.items()):
            entry = zipfile.ZipInfo(name, _EPOCH)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = 0o644 << 16
            archive.writestr(entry, content, compresslevel=9)
    return path.read_bytes()
