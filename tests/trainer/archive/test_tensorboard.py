"""The event file of a run, read back."""

from __future__ import annotations

import struct
from pathlib import Path

import pytest
from tensorboardX.proto.event_pb2 import Event
from tensorboardX.proto.plugin_hparams_pb2 import HParamsPluginData
from tensorboardX.record_writer import masked_crc32c

from testsupport.finished_runs import make_finished_run
from testsupport.workplace import Workplace
from trainer.archive.tensorboard import write_tensorboard
from tril.errors import NotFound
from tril.store.training import runs


def events_of(path: Path) -> list[Event]:
    """Read TFRecords, checking each checksum as TensorBoard does."""
    content, events = path.read_bytes(), []
    while content:
        length, length_sum = struct.unpack_from("<QI", content)
        assert length_sum == masked_crc32c(content[:8])
        data = content[12 : 12 + length]
        assert struct.unpack_from("<I", content, 12 + length) == (masked_crc32c(data),)
        events.append(Event.FromString(data))
        content = content[16 + length :]
    return events


def scalars_of(events: list[Event]) -> dict[str, list[tuple[int, float, float]]]:
    found: dict[str, list[tuple[int, float, float]]] = {}
    for event in events:
        for value in event.summary.value:
            if value.HasField("simple_value"):
                point = (event.step, value.simple_value, event.wall_time)
                found.setdefault(value.tag, []).append(point)
    return found


def test_curves_results_and_hyperparameters_are_read_back(
    workplace: Workplace, tmp_path: Path
) -> None:
    run_id = make_finished_run(workplace)
    path = write_tensorboard(workplace.database, run_id, tmp_path / "events")
    events = events_of(path)
    assert events[0].file_version == "brain.Event:2"
    scalars = scalars_of(events)
    hits = scalars["imitator/hits"]
    assert [step for step, _, _ in hits] == [128, 256]
    assert [value for _, value, _ in hits] == pytest.approx([1.28, 2.56])
    with workplace.database.reading() as session:
        run = runs.get(session, run_id)
    # Each stage took 1.5 s; four come before the imitator, which is half done at step 128.
    began = (run.started_at or run.created_at).timestamp()
    assert [wall - began for _, _, wall in hits] == pytest.approx([6.75, 7.5], abs=1e-3)
    ((step, tau, _),) = scalars["results/check/tau"]
    assert (step, tau) == (run.steps, 1.0)
    assert {name for name in scalars if name.startswith("results/imitator")} >= {
        "results/imitator_greedy/targets"
    }
    sessions = [
        HParamsPluginData.FromString(value.metadata.plugin_data.content).session_start_info
        for event in events
        for value in event.summary.value
        if value.tag == "_hparams_/session_start_info"
    ]
    (told,) = sessions
    assert told.hparams["training_seed"].number_value == run.training_seed
    assert told.hparams["policy.learning_rate"].number_value == pytest.approx(
        run.recipe["policy"]["learning_rate"]
    )
    assert told.hparams["name"].string_value == "tiny"


def test_a_run_that_is_not_over_has_what_there_is(workplace: Workplace, tmp_path: Path) -> None:
    run_id = workplace.make_run()
    events = events_of(write_tensorboard(workplace.database, run_id, tmp_path))
    assert scalars_of(events) == {}
    with pytest.raises(NotFound):
        write_tensorboard(workplace.database, "unknown", tmp_path)
