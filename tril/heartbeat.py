"""A process's sign of life, every few seconds."""

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


def _nothing(_session: Session) -> None:
    return


class Heartbeat:
    """Notes in the database that this process lives, from a thread of its own.

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
        also: Callable[[Session], None] = _nothing,
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
        """Beat once and go on beating."""
        self.beat()
        self._thread.start()

    def beat(self) -> None:
        """Beat now; a database that can't be written is logged and tried again next time."""
        try:
            with self._database.writing() as session:
                processes.beat(session, self._name, self._kind, self._details())
                self._also(session)
        except SQLAlchemyError as problem:
            log.warning("The sign of life of %s could not be written: %s", self._name, problem)

    def stop(self) -> None:
        """Stop beating and take the process off the list."""
        self._ended.set()
        if self._thread.is_alive():
            self._thread.join()
        try:
            with self._database.writing() as session:
                processes.leave(session, self._name)
        except SQLAlchemyError as problem:
            log.warning("The end of %s could not be written: %s", self._name, problem)

    def _run(self) -> None:
        while not self._ended.wait(self._interval_s):
            self.beat()

    def __enter__(self) -> Self:
        self.start()
        return self

    def __exit__(self, *_exception: object) -> None:
        self.stop()
