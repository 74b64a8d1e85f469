"""What is read of an episode of any environment: whether it is over."""

from __future__ import annotations

from tril.games.base import Console, End, EndKind, EndRule
from tril.games.gymnasium.console import GymnasiumConsole
from tril.games.plain_readout import PlainReadout

OVER = EndRule("over", "when the game is over")

_OVER_END = End("over", EndKind.FAILED, "the game was over")
_TIME_END = End("steps", EndKind.TIME, "the time was over")
ENDS = (_OVER_END, _TIME_END)
"""Whether the game was won is not known: environments do not tell."""


class GymnasiumReadout(PlainReadout):
    """Follows one episode, which the environment itself may cut short."""

    def update(self, console: Console, frame: int) -> str | None:
        """Read a frame that was executed; return the name of the end that it brought, if any."""
        end = super().update(console, frame)
        is_truncated = isinstance(console, GymnasiumConsole) and console.truncated
        return end or (_TIME_END.name if is_truncated else None)
