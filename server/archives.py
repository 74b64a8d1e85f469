"""Runs as zip files, each made by ``tril runs export`` in a process of its own."""

from __future__ import annotations

import hashlib
import logging
import sys
import tempfile
from pathlib import Path

from server.turns import Turns, run_program
from tril import __version__
from tril.errors import Unavailable
from tril.files.cache import Cache
from tril.settings import Settings
from tril.store.models import BehaviourRow, RunRow

_LOG = logging.getLogger(__name__)

TIMEOUT_S = 300.0
"""An archive takes about 15 s on an idle core: PyTorch is loaded, and two clips are made."""
NICENESS = "10"
"""Somebody waits for it: before trainings (19), after play (0)."""
MAX_WAITING = 4
"""One person has at most four requests under way (Services.replay_limit), so that one is left."""


class ArchiveMaker:
    """Makes archives, one at a time, and keeps them in the cache; thread-safe.

    Args:
        settings: Settings of the server.
        cache: Where archives are kept.
        timeout_s: Timeout of an archive.
    """

    def __init__(self, settings: Settings, cache: Cache, timeout_s: float = TIMEOUT_S) -> None:
        self._environ = {
            "TRIL_DATA": str(settings.data),
            "TRIL_DATABASE_URL": settings.database_url,
            "TRIL_JOBS_DATABASE_URL": settings.jobs_database_url,
            "TRIL_ARTIFACTS_URL": settings.artifacts_url,
        }
        self._cache = cache
        self._timeout_s = timeout_s
        self._turns = Turns("archives", MAX_WAITING)

    def archive(self, run: RunRow, behaviour: BehaviourRow) -> bytes:
        """Return a finished run's archive.

        Raises:
            Unavailable: Too many requests wait, or this one failed or took too long.
        """
        # What a run is learned from and what came out do not change; what people call it may.
        words = (run.name, run.notes, behaviour.name, behaviour.description)
        version = (__version__, run.id, run.finished_at, *words)
        digest = hashlib.blake2b(repr(version).encode(), digest_size=10).hexdigest()

        def make() -> bytes:
            with self._turns.turn():
                return self._make(run.id)

        return self._cache.get(f"{digest}.run.zip", make)

    def _make(self, run_id: str) -> bytes:
        with tempfile.TemporaryDirectory(prefix="tril-archive-") as folder:
            path = Path(folder) / "run.zip"
            export = [sys.executable, "-m", "cli", "runs", "export", run_id, "-o", str(path)]
            # Whoever asked for it is in the audit log.
            export.append("--unlogged")
            # Games come first.
            result = run_program(
                ["nice", "-n", NICENESS, *export], self._timeout_s, "archive", environ=self._environ
            )
            if result.returncode != 0:
                _LOG.error(
                    "An archive could not be made: %s", result.stderr.decode(errors="replace")
                )
                raise Unavailable("The archive could not be made; the server's log says why.")
            return path.read_bytes()
