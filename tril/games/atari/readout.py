"""What is read of an episode of any Atari game: the count of lives, and whether it is over."""

from __future__ import annotations

from tril.games.base import Console, End, EndKind, EndRule, JsonObject
from tril.games.plain_readout import PlainReadout

LIFE = EndRule("life", "when a life is lost")
OVER = EndRule("over", "when the game is over")

ENDS = (
    End("life", EndKind.DEATH, "a life was lost"),
    End("over", EndKind.FAILED, "the game was over"),
    End("steps", EndKind.TIME, "the time was over"),
)


class AtariReadout(PlainReadout):
    """Follows one episode and its count of lives."""

    def __init__(self, console: Console, end_rule: str) -> None:
        """Begin at a start."""
        super().__init__(console, end_rule)
        self._ends_at_life = end_rule == LIFE.name
        self._lives = console.lives

    def update(self, console: Console, frame: int) -> str | None:
        """Read a frame that was executed; return the name of the end that it brought, if any."""
        lives, before = console.lives, self._lives
        self._lives = lives
        if self._ends_at_life and lives < before:
            return "life"
        return super().update(console, frame)

    def save(self) -> JsonObject:
        """Return the state."""
        return {"lives": self._lives}

    def restore(self, state: JsonObject) -> None:
        """Restore a saved state."""
        self._lives = state["lives"]
