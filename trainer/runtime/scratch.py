"""A run's scratch folder, where its checkpoints are, and copies for workers of other machines."""

from __future__ import annotations

import io
import logging
import shutil
import tarfile
import tempfile
import threading
from collections.abc import Callable, Collection
from pathlib import Path
from typing import Self

from tril.errors import NotFound
from tril.files.artifact_store import ArtifactStore
from tril.settings import Settings

log = logging.getLogger(__name__)

COPIES = "checkpoints"
"""The artifact store's folder of copies: ``checkpoints/<run>/<epoch>.tar``."""

COPY_EVERY_S = 15.0
"""How often changed checkpoints are copied. They change every 30 to 45 s."""

MAX_COPY_BYTES = 256 * 1024 * 1024
"""Checkpoints that are larger together are not copied; those of the recipes have 15 MB."""

_ATTEMPTS = 5


def scratch_folder(settings: Settings, run_id: str) -> Path:
    """Return the folder of a run's checkpoints on this machine."""
    return settings.data / "runs" / run_id


def own_scratch_folder(root: Path, epoch: int) -> Path:
    """Return the scratch folder of a lease, with what the lease before left in its own.

    The earlier folder is renamed, so that a worker which has lost the run without knowing finds
    its folder gone and can't replace the checkpoints of the one that has it now.
    """
    root.mkdir(parents=True, exist_ok=True)
    folder = root / str(epoch)
    if folder.exists():
        return folder
    earlier = _epochs(root)
    if earlier:
        (root / str(earlier[-1])).rename(folder)
    else:
        folder.mkdir()
    for number in earlier[:-1]:
        shutil.rmtree(root / str(number), ignore_errors=True)
    return folder


def fetch_newer_copy(store: ArtifactStore, run_id: str, root: Path) -> None:
    """Put the newest copy of a run's checkpoints beside those here, unless these are as new.

    Args:
        store: The artifact store.
        run_id: The run.
        root: The run's scratch folder on this machine.
    """
    root.mkdir(parents=True, exist_ok=True)
    copied = _copied_epochs(store, run_id)
    if not copied or copied[-1] <= max(_epochs(root), default=-1):
        return
    epoch = copied[-1]
    try:
        content = store.get(_copy_path(run_id, epoch))
    except NotFound:
        # The worker that has the run meanwhile has replaced it.
        return
    with tempfile.TemporaryDirectory(dir=root, prefix=".copy-") as folder:
        unpacked = Path(folder) / str(epoch)
        with tarfile.open(fileobj=io.BytesIO(content)) as archive:
            archive.extractall(unpacked, filter="data")
        unpacked.rename(root / str(epoch))
    log.info("Run %s: goes on from the checkpoints of another machine.", run_id)


def _epochs(root: Path) -> list[int]:
    return sorted(int(path.name) for path in root.iterdir() if path.name.isdigit())


def _copied_epochs(store: ArtifactStore, run_id: str) -> list[int]:
    names = [Path(name) for name in store.names(f"{COPIES}/{run_id}")]
    return sorted(int(path.stem) for path in names if path.suffix == ".tar" and path.stem.isdigit())


def _copy_path(run_id: str, epoch: int) -> str:
    return f"{COPIES}/{run_id}/{epoch}.tar"


class CheckpointCopies:
    """Copies a run's checkpoints to the artifact store whenever they have changed.

    A copy is named by the epoch of its lease, so a worker that has lost the run without knowing
    replaces none of the one that has it now. Use it as a context manager.

    Args:
        store: The artifact store.
        run_id: The run.
        folder: The scratch folder of a lease, named by its epoch; see own_scratch_folder.
        finished_stages: Called for the stages whose checkpoints are not needed any more.
        every_s: Seconds between looks at the checkpoints.
    """

    def __init__(
        self,
        store: ArtifactStore,
        run_id: str,
        folder: Path,
        finished_stages: Callable[[], Collection[str]],
        every_s: float = COPY_EVERY_S,
    ) -> None:
        self._store = store
        self._run_id = run_id
        self._folder = folder
        self._finished_stages = finished_stages
        self._every_s = every_s
        self._copied: _Files = {}
        self._lock = threading.Lock()
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, name="checkpoint-copies", daemon=True)

    def copy(self) -> None:
        """Copy the checkpoints if they have changed; whatever fails is logged and tried again."""
        with self._lock:
            try:
                self._copy()
            except Exception:
                log.exception("The checkpoints of run %s could not be copied.", self._run_id)

    def _copy(self) -> None:
        for _ in range(_ATTEMPTS):
            files = self._files()
            if not files or files == self._copied:
                return
            if sum(size for _, size in files.values()) > MAX_COPY_BYTES:
                log.warning("The checkpoints of run %s are too large to copy.", self._run_id)
                self._copied = files
                return
            content = self._archive(files)
            # Of one moment: training may have replaced one of the files meanwhile.
            if content is not None and self._files() == files:
                epoch = int(self._folder.name)
                self._store.put(_copy_path(self._run_id, epoch), content)
                self._copied = files
                for earlier in _copied_epochs(self._store, self._run_id):
                    if earlier < epoch:
                        self._store.remove(_copy_path(self._run_id, earlier))
                return

    def _files(self) -> _Files:
        """Return time of change and size of every checkpoint that is still needed."""
        finished = self._finished_stages()
        files: _Files = {}
        for path in sorted(self._folder.glob("*/*")):
            stage = path.parent.name
            # What begins with a dot is about to be written.
            if stage in finished or path.name.startswith("."):
                continue
            try:
                status = path.stat()
            except FileNotFoundError:
                continue
            files[f"{stage}/{path.name}"] = (status.st_mtime_ns, status.st_size)
        return files

    def _archive(self, files: _Files) -> bytes | None:
        """Return the files as one; None if one of them is gone."""
        content = io.BytesIO()
        try:
            with tarfile.open(fileobj=content, mode="w") as archive:
                for name in files:
                    archive.add(self._folder / name, name)
        except FileNotFoundError:
            return None
        return content.getvalue()

    def _run(self) -> None:
        while not self._ended.wait(self._every_s):
            self.copy()

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *_exception: object) -> None:
        self._ended.set()
        self._thread.join()


_Files = dict[str, tuple[int, int]]
