"""A run's curves and results as an event file, which TensorBoard and others read.

Points have no time of their own in the database. Their wall times are spread evenly over the time
that their stage took, stages in the order in which a run goes through them.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from tensorboardX.proto.event_pb2 import Event
from tensorboardX.record_writer import masked_crc32c
from tensorboardX.summary import hparams, scalar

from tril.analysis.summary import Interval
from tril.files.artifact_store import write_whole
from tril.stages import stages_of
from tril.store import behaviours
from tril.store.database import Database
from tril.store.models import RunRow
from tril.store.training import evaluations, metrics, runs

VERSION = "brain.Event:2"
"""What TensorBoard expects of a file's first event."""

_RESULTS = ("targets", "strays", "death_rate", "perfect", "predicted_return")


def write_tensorboard(database: Database, run_id: str, folder: Path) -> Path:
    """Write the event file of a run, finished or not, into a folder.

    Scalars are named by stage and curve, such as ``imitator/hits``, and the results such as
    ``results/imitator_sticky/targets``: means over the evaluation games from held-out starts.
    Hyperparameters have the names that the recipe has them under.

    Args:
        database: The application's database.
        run_id: The run.
        folder: Made if it isn't there; the run's earlier file in it is replaced.

    Returns:
        The file.

    Raises:
        NotFound: No such run.
    """
    with database.reading() as session:
        run = runs.get(session, run_id)
        series = metrics.series(session, run_id)[1]
        games = evaluations.listing(session, run_id)
        n_targets = behaviours.n_targets(session, run.behaviour_id)
    results = dict(_results(run, evaluations.summaries(games, n_targets)))
    began_s = (run.started_at or run.created_at).timestamp()
    ended_s = began_s + sum(run.finished_stages.values())
    # TensorBoard takes a run's begin from the file's name.
    path = folder / f"events.out.tfevents.{int(began_s)}.{run_id}"
    events = [Event(wall_time=began_s, file_version=VERSION)]
    values = _hyperparameters(run)
    events += [Event(wall_time=began_s, summary=summary) for summary in hparams(values, results)]
    for wall_time, step, name, value in _points(run, series, began_s):
        events.append(Event(wall_time=wall_time, step=step, summary=scalar(name, value)))
    for name, value in results.items():
        events.append(Event(wall_time=ended_s, step=run.steps, summary=scalar(name, value)))
    folder.mkdir(parents=True, exist_ok=True)
    write_whole(path, b"".join(_record(event.SerializeToString()) for event in events))
    return path


def _points(
    run: RunRow, series: metrics.Series, began_s: float
) -> Iterator[tuple[float, int, str, float]]:
    """Yield wall time, step, name and value of every point."""
    at_s = began_s
    for stage in stages_of(run.example):
        curves = series.get(stage, {})
        seconds = run.finished_stages.get(stage, 0.0)
        last = max((step for curve in curves.values() for step, _ in curve), default=0)
        for name, curve in curves.items():
            for step, value in curve:
                yield at_s + seconds * step / max(last, 1), step, f"{stage}/{name}", value
        at_s += seconds


def _results(run: RunRow, summaries: Mapping[tuple[str, str], Any]) -> Iterator[tuple[str, float]]:
    if (check := run.outcome.check) is not None:
        for name in ("tau", "pair_accuracy", "held_out_accuracy"):
            value = getattr(check, name)
            if value is not None:
                yield f"results/check/{name}", float(value)
    for (policy, action_selection), summary in summaries.items():
        for name in _RESULTS:
            interval: Interval | None = getattr(summary, name)
            if interval is not None:
                yield f"results/{policy}_{action_selection}/{name}", interval.mean


def _hyperparameters(run: RunRow) -> dict[str, str | bool | float]:
    """Return the recipe's values by dotted path, and what else a training is told."""
    values: dict[str, Any] = {"steps": run.steps, "training_seed": run.training_seed}
    for name, value in run.recipe.items():
        inner = {f"{name}.{k}": v for k, v in value.items()} if isinstance(value, dict) else {}
        values |= inner or {name: value}
    return {
        name: value if isinstance(value, str | bool | int | float) else json.dumps(value)
        for name, value in values.items()
    }


def _record(content: bytes) -> bytes:
    """Return an event framed as a TFRecord: its length and itself, each with its checksum."""
    length = struct.pack("<Q", len(content))
    checksums = [struct.pack("<I", masked_crc32c(part)) for part in (length, content)]
    return length + checksums[0] + content + checksums[1]
