"""What a page is shown of a game after a frame."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

from server.play.wire.codec import Screen
from tril.games.space_invaders.grid import Formation
from tril.play.episode import Episode


@dataclass(frozen=True)
class Scene:
    """A game after one of its frames.

    Attributes:
        frame: Executed frames; 0 is the start.
        screen: uint8 (210, 160) of palette values.
        formation: Position of the grid of aliens on the screen.
        shots: Missiles fired so far.
    """

    frame: int
    screen: Screen
    formation: Formation
    shots: int

    @classmethod
    def of(cls, episode: Episode) -> Self:
        """Return an episode's current scene."""
        return cls(
            episode.frame, episode.console.screen_palette(), episode.formation, episode.shots
        )
