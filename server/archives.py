"""Runs as files, each made by ``tril runs export`` or ``share`` in a process of its own."""

from __future__ import annotations

import hashlib
import io
import logging
import sys
import tempfile
import zipfile
from collections.abc import Callable, Sequence
from enum import StrEnum
from pathlib import Path

from server.turns import Turns, run_program
from tril import __version__
from tril.errors import Unavailable
from tril.files.cache import Cache
from tril.games import game_of
from tril.settings import Settings
from tril.store.behaviours import as_behaviour
from tril.store.models import BehaviourRow, RunRow
from tril.vocabulary.making import pictures_path

_LOG = logging.getLogger(__name__)

TIMEOUT_S = 300.0
"""An archive takes about 15 s on an idle core: PyTorch is loaded, and two clips are made."""
PAGE_SHARE = 0.8
"""Time limit of `tril runs share --within`, as a fraction of the timeout, 0 to 1.

Chosen, not measured. The rest is for starting the process, whose imports the limit does not count.
"""
NICENESS = "10"
"""Somebody waits for it: before trainings (19), after play (0)."""
MAX_WAITING = 4
"""One person has at most four requests under way (Services.replay_limit), so that one is left."""


class PagePart(StrEnum):
    """A part of a page that is sent, by its ending."""

    PAGE = "html"
    POSTER = "png"


class ArchiveMaker:
    """Makes archives and pages, one at a time, and keeps them in the cache; thread-safe.

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
        self._data = settings.data
        self._cache = cache
        self._timeout_s = timeout_s
        self._turns = Turns("archives", MAX_WAITING)

    def archive(self, run: RunRow, behaviour: BehaviourRow, version: object) -> bytes:
        """Return a finished run's archive.

        Args:
            run: The run.
            behaviour: Its behaviour.
            version: What else it depends on.

        Raises:
            Unavailable: Too many requests wait, or this one failed or took too long.
        """
        words = (run.name, run.notes, behaviour.name, behaviour.description, version)
        name = f"{_digest(run, *words)}.run.zip"

        def make(folder: Path) -> bytes:
            path = folder / "run.zip"
            self._run("archive", ["export", run.id, "-o", str(path), "--unlogged"])
            return path.read_bytes()

        return self._cache.get(name, lambda: self._made(make))

    def page(self, run: RunRow, behaviour: BehaviourRow, version: object, part: PagePart) -> bytes:
        """Return a finished run as a page that needs no server, or the page's poster.

        Args:
            run: The run.
            behaviour: Its behaviour.
            version: What else it depends on.
            part: The page or its poster.

        Raises:
            Unavailable: Too many requests wait, or this one failed or took too long.
        """
        pictures = pictures_path(self._data, game_of(as_behaviour(behaviour)))
        words = (run.name, behaviour.name, behaviour.description)
        what = (behaviour.measures, behaviour.target, pictures.exists(), version)
        name = f"{_digest(run, *words, *what)}.page.zip"

        def make(folder: Path) -> bytes:
            path = folder / "page.html"
            within = f"{PAGE_SHARE * self._timeout_s:.0f}"
            self._run("page", ["share", run.id, "-o", str(path), "--within", within, "--unlogged"])
            both = io.BytesIO()
            with zipfile.ZipFile(both, "w") as pages:
                pages.write(path, PagePart.PAGE)
                pages.write(path.with_suffix(".png"), PagePart.POSTER)
            return both.getvalue()

        content = self._cache.get(name, lambda: self._made(make))
        with zipfile.ZipFile(io.BytesIO(content)) as pages:
            return pages.read(part)

    def _made(self, make: Callable[[Path], bytes]) -> bytes:
        with (
            self._turns.turn(),
            tempfile.TemporaryDirectory(prefix="tril-archive-") as folder,
        ):
            return make(Path(folder))

    def _run(self, product: str, arguments: Sequence[str]) -> None:
        """Run ``tril runs``; whoever asked for it is in the audit log."""
        command = [sys.executable, "-m", "cli", "runs", *arguments]
        # Games come first.
        result = run_program(
            ["nice", "-n", NICENESS, *command], self._timeout_s, product, environ=self._environ
        )
        if result.returncode != 0:
            _LOG.error("The %s failed: %s", product, result.stderr.decode(errors="replace"))
            raise Unavailable(f"The {product} could not be made; the server's log says why.")


def _digest(run: RunRow, *others: object) -> str:
    """Return a name for what is made of a run.

    What it learned from and what came out do not change; what people call it and say of it may.

    Args:
        run: The run.
        others: What else it depends on.
    """
    version = (__version__, run.id, run.finished_at, *others)
    return hashlib.blake2b(repr(version).encode(), digest_size=10).hexdigest()
