"""What a page is shown of a game after a frame."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

from server.play.wire.codec import Screen
from tril.game.aliens import Formation
from tril.game.episode import Episode


@dataclass(frozen=True)
class Scene:
    """A game after one of its frames.

    Attributes:
        frame: How many frames were executed; 0 is the start.
        screen: uint8 (210, 160) of palette values.
        formation: Where the grid of aliens stands on the screen.
        shots: Missiles that have left the cannon so far.
    """

    frame: int
    screen: Screen
    formation: Formation
    shots: int

    @classmethod
    def of(cls, episode: Episode) -> Self:
        """Take the scene of an episode as it is now."""
        return cls(
            episode.frame, episode.console.screen_palette(), episode.formation, episode.shots
        )
