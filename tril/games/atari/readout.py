"""What is read of an episode of any Atari game: the count of lives, and whether it is over."""

from __future__ import annotations

from tril.games.base import Console, End, EndKind, EndRule, JsonObject, Taken

LIFE = EndRule("life", "when a life is lost")
OVER = EndRule("over", "when the game is over")

ENDS = (
    End("life", EndKind.DEATH, "a life was lost"),
    End("over", EndKind.FAILED, "the game was over"),
    End("steps", EndKind.TIME, "the time was over"),
)


class AtariReadout:
    """Follows one episode.

    Attributes:
        taken: Nothing: what can be taken is known to a game's own module.
        counters: Nothing.
    """

    def __init__(self, console: Console, end_rule: str) -> None:
        """Begin at a start."""
        self.taken: list[Taken] = []
        self.counters: dict[str, int] = {}
        self._ends_at_life = end_rule == LIFE.name
        self._lives = console.lives

    def update(self, console: Console, frame: int) -> str | None:
        """Read a frame that was executed; return the name of the end that it brought, if any."""
        lives, before = console.lives, self._lives
        self._lives = lives
        if self._ends_at_life and lives < before:
            return "life"
        return "over" if console.over else None

    def marks(self, console: Console) -> bytes:
        """Return nothing: there is no overlay."""
        return b""

    def save(self) -> JsonObject:
        """Return the state."""
        return {"lives": self._lives}

    def restore(self, state: JsonObject) -> None:
        """Restore a saved state."""
        self._lives = state["lives"]
