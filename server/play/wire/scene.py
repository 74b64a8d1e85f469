"""What a page is shown of a game after a frame."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

from tril.games.base import Screen
from tril.play.episode import Episode


@dataclass(frozen=True)
class Scene:
    """A game after one of its frames.

    Attributes:
        frame: Executed frames; 0 is the start.
        screen: The screen.
        marks: Overlay data of the frame; two bytes.
        counted: Sum of the game's counters so far.
    """

    frame: int
    screen: Screen
    marks: bytes
    counted: int

    @classmethod
    def of(cls, episode: Episode) -> Self:
        """Return an episode's current scene."""
        console = episode.console
        return cls(
            episode.frame,
            console.screen(),
            episode.readout.marks(console),
            sum(episode.readout.counters.values()),
        )
