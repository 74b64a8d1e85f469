"""How log entries are written: one line each, on which nothing acts."""

from __future__ import annotations

import logging

from tril.text import printable


class PlainFormatter(logging.Formatter):
    """Escapes what a terminal would obey, and line breaks within a message.

    Log entries quote what others have written. Only tracebacks have several lines.
    """

    def formatMessage(self, record: logging.LogRecord) -> str:  # noqa: N802
        """Return an entry's first line."""
        return printable(super().formatMessage(record))

    def format(self, record: logging.LogRecord) -> str:
        """Return an entry, with its traceback if it has one."""
        return printable(super().format(record), keep="\n\t")
