"""How well a game is played, as data: flawlessly, or as a person plays."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any


@dataclass(frozen=True)
class Manner:
    """What keeps a player from playing flawlessly; with every number 0, nothing does.

    Attributes:
        name: What recordings call it in their conditions.
        reaction_frames: What it does answers the screen of so many frames ago.
        aim_error_px: Standard deviation, in pixels, of where it aims from where it should.
        key_error_frames: Standard deviation of how much too long or short it holds a key.
        slip_share: Share of its walks to an alien, 0 to 1, on which it shoots too early.
        missed_bomb_share: Share of the bombs, 0 to 1, that it doesn't notice.
        cut_short_share: Share of its games, 0 to 1, that it leaves before their time is over, once
            it has hit what it wanted to.
    """

    name: str
    reaction_frames: int = 0
    aim_error_px: float = 0.0
    key_error_frames: float = 0.0
    slip_share: float = 0.0
    missed_bomb_share: float = 0.0
    cut_short_share: float = 0.0

    def to_dict(self) -> dict[str, Any]:
        """The manner as data for a recording's conditions."""
        return asdict(self)


PERFECT = Manner("perfect")
"""Looks ahead on the saved game and is never wrong."""

HUMAN = Manner(
    name="human",
    reaction_frames=15,
    aim_error_px=1.5,
    key_error_frames=2.0,
    slip_share=0.06,
    missed_bomb_share=0.12,
    cut_short_share=0.5,
)
"""As a person plays: 250 ms from screen to key, the lower end of what was measured of people who
play Atari games (Zhang et al. 2020, Atari-HEAD). The rest was chosen so that such games come near
what was planned and about one ranked game in seven ends by a hit."""
