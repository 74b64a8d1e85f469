"""The human errors that the scripted player simulates."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from typing import Any


@dataclass(frozen=True)
class ErrorModel:
    """How far a player falls short of flawless play; all zeros are flawless.

    Attributes:
        name: Name in recordings' conditions.
        reaction_frames: Frames between a screen and the response to it.
        aim_error_px: Standard deviation of the aim error, in pixels.
        key_error_frames: Standard deviation of how much too long or short a key is held.
        slip_share: Share of walks to an alien, 0 to 1, with a premature shot.
        missed_bomb_share: Share of bombs, 0 to 1, that go unnoticed.
        cut_short_share: Share of games, 0 to 1, that are quit early once all planned aliens are
            hit.
    """

    name: str
    reaction_frames: int = 0
    aim_error_px: float = 0.0
    key_error_frames: float = 0.0
    slip_share: float = 0.0
    missed_bomb_share: float = 0.0
    cut_short_share: float = 0.0

    def to_dict(self) -> dict[str, Any]:
        """Return the values for a recording's conditions."""
        return asdict(self)


PERFECT = ErrorModel("perfect")
"""Looks ahead on the saved game and makes no errors."""

HUMAN = ErrorModel(
    name="human",
    reaction_frames=15,
    aim_error_px=1.5,
    key_error_frames=2.0,
    slip_share=0.06,
    missed_bomb_share=0.12,
    cut_short_share=0.5,
)
"""250 ms from screen to key, the lower end of what was measured of people playing Atari games
(Zhang et al. 2020, Atari-HEAD). The other values are chosen so that games stay close to their plans
and about one ranked game in seven ends with a hit on the player."""


def person(reaction_ms: int) -> ErrorModel:
    """Return the errors of a person with this reaction time; slower ones err more throughout.

    At 250 ms they are those of HUMAN.

    Args:
        reaction_ms: Time between a screen and the response to it, in milliseconds.
    """
    factor = reaction_ms / 250
    return replace(
        HUMAN,
        name=f"person-{reaction_ms}",
        reaction_frames=round(HUMAN.reaction_frames * factor),
        aim_error_px=HUMAN.aim_error_px * factor,
        key_error_frames=HUMAN.key_error_frames * factor,
        slip_share=HUMAN.slip_share * factor,
        missed_bomb_share=HUMAN.missed_bomb_share * factor,
    )
