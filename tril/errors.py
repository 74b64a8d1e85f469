"""Errors reported to the user; the server and the command line map them to responses."""

from __future__ import annotations


class TrilError(Exception):
    """An error that the user can act on; the message says how.

    Attributes:
        field: The field of the form that has to be changed; None if it is not about one.
    """

    field: str | None = None


class NotFound(TrilError):
    """The requested object does not exist."""


class Forbidden(TrilError):
    """The role of the person or key does not allow this."""


class Conflict(TrilError):
    """The request conflicts with the current state; reload and try again."""


class NameTaken(Conflict):
    """Another object has the name."""

    field = "name"


class Invalid(TrilError):
    """The input is not acceptable."""


class Unavailable(TrilError):
    """A required service or resource is not available."""
