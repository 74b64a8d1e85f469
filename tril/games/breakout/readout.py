"""What is read of an episode of Breakout: bricks broken, and how it ends."""

from __future__ import annotations

from tril.games.atari.readout import ENDS as ATARI_ENDS
from tril.games.atari.readout import AtariReadout
from tril.games.base import Console, End, EndKind, JsonObject, Taken
from tril.games.breakout.wall import BRICKS, standing

CLEARED = End("cleared", EndKind.WON, "no brick was left")
ENDS = (*ATARI_ENDS, CLEARED)


class BreakoutReadout(AtariReadout):
    """Follows one episode of one wall; a second wall would be another game."""

    def __init__(self, console: Console, end_rule: str) -> None:
        """Begin at a start."""
        super().__init__(console, end_rule)
        self._standing = standing(console.ram_bytes())
        self._wall = b""

    def update(self, console: Console, frame: int) -> str | None:
        """Read a frame that was executed; return the name of the end that it brought, if any."""
        wall = console.ram_bytes()[: max(address for address, _ in BRICKS.values()) + 1]
        if wall != self._wall:
            self._wall = wall
            bricks = standing(wall) & self._standing
            self.taken += [Taken(*brick, frame) for brick in sorted(self._standing - bricks)]
            self._standing = bricks
        end = super().update(console, frame)
        return end or (None if self._standing else CLEARED.name)

    def save(self) -> JsonObject:
        """Return the state, besides what was taken."""
        return super().save() | {"standing": sorted(map(list, self._standing))}

    def restore(self, state: JsonObject) -> None:
        """Restore a saved state."""
        super().restore(state)
        self._standing = frozenset((row, column) for row, column in state["standing"])
        self._wall = b""
