"""The readout of a game in which nothing can be taken or counted."""

from __future__ import annotations

from tril.games.base import Console, JsonObject, Taken


class PlainReadout:
    """Follows one episode.

    Attributes:
        taken: Nothing: what can be taken is known to a game's own module.
        counters: Nothing.
    """

    def __init__(self, console: Console, end_rule: str) -> None:
        """Begin at a start."""
        self.taken: list[Taken] = []
        self.counters: dict[str, int] = {}

    def update(self, console: Console, frame: int) -> str | None:
        """Read a frame that was executed; return the name of the end that it brought, if any."""
        return "over" if console.over else None

    def marks(self, console: Console) -> bytes:
        """Return nothing: there is no overlay."""
        return b""

    def save(self) -> JsonObject:
        """Return nothing: the console has it all."""
        return {}

    def restore(self, state: JsonObject) -> None:
        """Restore nothing."""
