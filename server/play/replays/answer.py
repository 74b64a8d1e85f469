"""What comes back from the process that replays. Pure."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Answer:
    """How a replay came out.

    Attributes:
        content: What was wanted.
        refusal: Why the recording does not replay; None if it does.
        failure: A traceback, if something else went wrong.
    """

    content: bytes = b""
    refusal: str | None = None
    failure: str | None = None
