"""Situations that the person has to know about. The domain knows no HTTP; edges map these."""

from __future__ import annotations


class TrilError(Exception):
    """Something the person can understand and act on; the message says what to do."""


class NotFound(TrilError):
    """A thing that was named does not exist (any more)."""


class Conflict(TrilError):
    """The request contradicts what has happened since; reload and decide again."""


class Invalid(TrilError):
    """What was given cannot be accepted; the message says why."""


class Unavailable(TrilError):
    """A part of Tril that is needed is not running or out of room."""
