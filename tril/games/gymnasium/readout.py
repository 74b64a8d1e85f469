"""What is read of an episode of any environment: whether it is over."""

from __future__ import annotations

from tril.games.base import Console, End, EndKind, EndRule, JsonObject, Taken
from tril.games.gymnasium.console import GymnasiumConsole

OVER = EndRule("over", "when the game is over")

_OVER_END = End("over", EndKind.FAILED, "the game was over")
_TIME_END = End("steps", EndKind.TIME, "the time was over")
ENDS = (_OVER_END, _TIME_END)
"""Whether the game was won is not known: environments do not tell."""


class GymnasiumReadout:
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
        if console.over:
            return _OVER_END.name
        is_truncated = isinstance(console, GymnasiumConsole) and console.truncated
        return _TIME_END.name if is_truncated else None

    def marks(self, console: Console) -> bytes:
        """Return nothing: there is no overlay."""
        return b""

    def save(self) -> JsonObject:
        """Return nothing: the console has it all."""
        return {}

    def restore(self, state: JsonObject) -> None:
        """Restore nothing."""
