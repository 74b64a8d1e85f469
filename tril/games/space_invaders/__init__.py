"""Space Invaders, the published case."""

from tril.games.space_invaders.game import SPACE_INVADERS

__all__ = ["SPACE_INVADERS"]
