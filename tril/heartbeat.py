"""A process's heartbeat in the database."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable
from typing import Any, Self

from sqlalchemy.exc import SQLAlchemyError
from sqlalchemy.orm import Session

from tril.store import processes
from tril.store.database import Database

log = logging.getLogger(__name__)

INTERVAL_S = 5.0


class Heartbeat:
    """Writes every few seconds, from a thread of its own, that this process is alive.

    Use it as a context manager, or call ``start`` and ``stop``.

    Args:
        database: The application's database.
        name: Unique name of the process.
        kind: "server", "worker" or "inference".
        details: Called at each beat for what the process says about itself.
        also: Called in each beat's transaction.
        interval_s: Seconds between beats.
    """

    def __init__(
        self,
        database: Database,
        name: str,
        kind: str,
        details: Callable[[], dict[str, Any]] = dict,
        also: Callable[[Session], None] | None = None,
        interval_s: float = INTERVAL_S,
    ) -> None:
        self._database = database
        self._name = name
        self._kind = kind
        self._details = details
        self._also = also
        self._interval_s = interval_s
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, name="heartbeat", daemon=True)

    def start(self) -> None:
        """Write the first beat and start the thread."""
        self._write(self._beat)
        self._thread.start()

    def stop(self) -> None:
        """Stop beating and take the process off the list."""
        self._ended.set()
        if self._thread.is_alive():
            self._thread.join()
        self._write(lambda session: processes.leave(session, self._name))

    def _run(self) -> None:
        while not self._ended.wait(self._interval_s):
            self._write(self._beat)

    def _beat(self, session: Session) -> None:
        processes.beat(session, self._name, self._kind, self._details())
        if self._also is not None:
            self._also(session)

    def _write(self, write: Callable[[Session], None]) -> None:
        """Write in a transaction; whatever fails is logged, and the next beat tries again."""
        try:
            with self._database.writing() as session:
                write(session)
        except SQLAlchemyError as problem:
            # E.g. the disk is full: said every few seconds, and so in one line.
            log.warning("The heartbeat of %s could not be written: %s", self._name, problem)
        except Exception:
            log.exception("The heartbeat of %s could not be written.", self._name)

    def __enter__(self) -> Self:
        self.start()
        return self

    def __exit__(self, *_exception: object) -> None:
        self.stop()
