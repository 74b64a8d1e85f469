"""How games of Space Invaders end."""

from enum import StrEnum

from tril.games.base import End, EndKind, EndRule


class Ending(StrEnum):
    """When the player's death ends an episode.

    HIT: at the frame of the hit. LIFE_COUNTER: when the emulator's count of lives drops, 128 to 131
    frames later, as in the published work.
    """

    HIT = "hit"
    LIFE_COUNTER = "life_counter"


class EndReason(StrEnum):
    """Why an episode ended; the first in this order if several apply."""

    HIT = "hit"
    LIVES = "lives"
    LANDED = "landed"
    CLEARED = "cleared"
    STEPS = "steps"


DEATHS = frozenset({EndReason.HIT, EndReason.LIVES})
"""The ends that the player's death brings, by either rule."""

END_RULES = (
    EndRule(Ending.HIT.value, "when the cannon is hit"),
    EndRule(Ending.LIFE_COUNTER.value, "when the count of lives drops"),
)

ENDS = (
    End(EndReason.HIT.value, EndKind.DEATH, "the player was hit"),
    End(EndReason.LIVES.value, EndKind.DEATH, "the player lost a life"),
    End(EndReason.LANDED.value, EndKind.FAILED, "the aliens landed"),
    End(EndReason.CLEARED.value, EndKind.WON, "no alien was left"),
    End(EndReason.STEPS.value, EndKind.TIME, "300 steps were over"),
)
