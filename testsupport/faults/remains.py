"""What a campaign leaves: in the database, in the store, on disk and in memory."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from pathlib import Path

import psutil
from sqlalchemy import select

from testsupport.databases import corrupt_databases
from testsupport.faults.clients import BEHAVIOUR, deletion_of, digest, name_of, notes_of
from testsupport.faults.injection import Target
from testsupport.faults.ledger import read_ledger
from testsupport.faults.rules import Found, Stored
from testsupport.worker_kills import flaws
from testsupport.workplace import Workplace
from tril.errors import NotFound
from tril.files.artifact_store import ArtifactStore
from tril.games.space_invaders import SPACE_INVADERS
from tril.recording import RecordingRefused, verify
from tril.store import recordings
from tril.store.models import (
    ArtifactRow,
    RankingRow,
    RecordingRow,
    RecordingState,
    RunRow,
    RunStatus,
    Verification,
)

MOST_NEW_DESCRIPTORS = 64
LEAVES_WITHIN_S = 20.0
SWEPT_WITHIN_S = 90.0
"""Workers look once a minute for scratch folders that nobody needs."""


class Remains:
    """Looks at what is left of a campaign.

    Args:
        workplace: The database and the settings.
        target: The processes.
    """

    def __init__(self, workplace: Workplace, target: Target) -> None:
        self._workplace = workplace
        self._settings = workplace.settings
        self._target = target
        self._workers = target.of_kind("worker")
        self._descriptors: dict[int, int] = {}

    def count_descriptors(self) -> None:
        """Count the descriptors of the processes that have just started."""
        for member in self._target.members:
            process = psutil.Process(member.pid)
            self._descriptors.setdefault(member.pid, process.num_fds())

    def found(self, first_revision: int, references: dict[int, str]) -> Found:
        """Return what there is once every run is over.

        Args:
            first_revision: The ranking's revision before the campaign.
            references: By length, a run that nothing happened to.
        """
        database = self._workplace.database
        with database.reading() as session:
            of_recordings = list(session.scalars(select(RecordingRow)))
            of_runs = list(session.scalars(select(RunRow)))
            of_ranking = session.scalars(
                select(RankingRow).where(RankingRow.behaviour_id == BEHAVIOUR)
            )
            revisions = {row.revision: row.tiers for row in of_ranking}
        values: dict[str, object] = {}
        for recording in of_recordings:
            values[notes_of(recording.id)] = recording.notes
            values[deletion_of("recording", recording.id)] = recording.deleted_at is not None
        for run in of_runs:
            values[name_of(run.id)] = run.name
            values[deletion_of("run", run.id)] = run.deleted_at is not None
        unlike = [
            f"Run {run.id}: {flaw}"
            for run in of_runs
            if run.id not in references.values() and run.steps in references
            for flaw in flaws(self._workplace, run.id, references[run.steps])
        ]
        return Found(
            values=values,
            recordings=dict(_stored(of_recordings)),
            revisions=revisions,
            first_revision=first_revision,
            runs={run.id: run.status for run in of_runs},
            ledger=read_ledger(database),
            left_behind=[*self._open_descriptors(), *self._left_on_disk(of_runs)],
            damaged=[*corrupt_databases(self._settings.data), *self._missing_files()],
            unlike=unlike,
        )

    def _missing_files(self) -> list[str]:
        """Return the files that the database names and the store does not have as they were."""
        store = ArtifactStore(self._settings.artifact_root)
        with self._workplace.database.reading() as session:
            named = {row.path: row.size_bytes for row in session.scalars(select(ArtifactRow))}
        found = []
        for path, size_bytes in named.items():
            try:
                stored = len(store.get(path))
            except NotFound:
                stored = None
            if stored != size_bytes:
                found.append(f"The file {path} of {size_bytes} bytes is {stored} in the store.")
        return found

    def _open_descriptors(self) -> Iterator[str]:
        for member in self._target.members:
            before = self._descriptors[member.pid]
            now = psutil.Process(member.pid).num_fds()
            if now > before + MOST_NEW_DESCRIPTORS:
                yield f"The {member.name} holds {now} descriptors, {before} after its start."

    def _left_on_disk(self, of_runs: Sequence[RunRow]) -> list[str]:
        """Return the scratch folders of finished runs that are left, once they may not be."""
        done = {run.id for run in of_runs if run.status == RunStatus.DONE}
        folders = {Path(member.environment["TRIL_DATA"]) / "runs" for member in self._workers}

        def left() -> list[Path]:
            return [place for folder in folders for place in folder.glob("*") if place.name in done]

        give_up_at = time.monotonic() + SWEPT_WITHIN_S
        while left() and time.monotonic() < give_up_at:
            time.sleep(0.2)
        return [f"The scratch folder {place} is left, though its run is done." for place in left()]


def _stored(rows: Sequence[RecordingRow]) -> Iterator[tuple[int, Stored]]:
    """Yield every recording of people, replayed."""
    console = SPACE_INVADERS.make_console()
    for row in rows:
        if row.state == RecordingState.PLAYING or row.behaviour_id != BEHAVIOUR:
            continue
        recording = recordings.as_recording(row)
        refusal: str | None = None
        if row.verification != Verification.VERIFIED:
            refusal = row.verification_note or "Nobody has replayed it yet."
        else:
            try:
                verify(recording, console=console)
            except RecordingRefused as problem:
                refusal = str(problem)
        yield row.id, Stored(digest(recording), row.n_frames, row.behaviour_id, refusal)


def left_running(folder: Path) -> list[str]:
    """Return the processes that are still there once everything was stopped."""

    def left() -> list[psutil.Process]:
        found = []
        for process in psutil.process_iter():
            try:
                if process.environ().get("TRIL_DATA", "").startswith(f"{folder}/"):
                    found.append(process)
            except psutil.Error:
                continue
        return found

    give_up_at = time.monotonic() + LEAVES_WITHIN_S
    while left() and time.monotonic() < give_up_at:
        time.sleep(0.2)
    return [f"Process {process.pid} is left: {process.cmdline()}" for process in left()]
