"""What tests of backups share."""

from __future__ import annotations

from testsupport.workplace import Workplace
from tril.files.artifact_store import ArtifactStore
from tril.store.models import RunRow, RunStatus
from tril.store.training import artifacts

MODEL = b"weights" * 1000


def finished_run(workplace: Workplace) -> str:
    """A run that is done and has a file."""
    run_id = workplace.make_run()
    store = ArtifactStore(workplace.settings.artifact_root)
    size = store.put(artifacts.path_of(run_id, "model.bin"), MODEL)
    with workplace.database.writing() as session:
        session.get_one(RunRow, run_id).status = RunStatus.DONE
        artifacts.save(session, run_id, "model", "model.bin", "application/octet-stream", size)
    return run_id
