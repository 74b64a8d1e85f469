"""Transactions of a process's games, in a thread beside the event loop."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

from sqlalchemy.exc import DBAPIError, SQLAlchemyError
from sqlalchemy.orm import Session

from server.web.problems import explain_database_error
from tril.errors import Unavailable
from tril.store.database import Database

_LOG = logging.getLogger(__name__)
_T = TypeVar("_T")


class Committer:
    """Runs transactions one after the other in a thread, so that the event loop never waits."""

    def __init__(self, database: Database) -> None:
        self._database = database
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="commits")

    async def run(self, work: Callable[[Session], _T]) -> _T:
        """Run a function in a transaction.

        Callers resume in the order of their transactions.

        Raises:
            Unavailable: It could not be committed, and was rolled back; says what to do.
        """
        loop = asyncio.get_running_loop()
        return await loop.run_in_executor(self._thread, self._transact, work)

    def close(self) -> None:
        """Wait for the current transaction and end the thread."""
        self._thread.shutdown()

    def _transact(self, work: Callable[[Session], _T]) -> _T:
        try:
            with self._database.writing() as session:
                return work(session)
        except DBAPIError as error:
            explained = explain_database_error(error)
            _LOG.error("Games could not be saved: %s", error.orig)
            raise explained or _not_saved(error) from error
        except SQLAlchemyError as error:
            _LOG.exception("Games could not be saved.")
            raise _not_saved(error) from error


def _not_saved(error: SQLAlchemyError) -> Unavailable:
    return Unavailable(
        f"The game could not be saved ({type(error).__name__}); the server's log says more. It is "
        "tried again every second, and nothing is lost while the server runs."
    )
