"""What a behaviour sets of its game: length, end, options of its start, and what stays hidden."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from tril.errors import Invalid

MIN_STEPS = 25
"""Shortest game that can be set: the length of a level in the check of a ranking."""
MAX_STEPS = 6000
"""Longest game that can be set: 400 s of a game with 60 frames a second and 4 frames a step."""
MAX_HIDDEN = 16
"""Most areas that can be hidden."""


@dataclass(frozen=True, order=True)
class Rectangle:
    """An area of the screen in pixels, from the left and the top; right and bottom are outside."""

    left: int
    top: int
    right: int
    bottom: int

    def __post_init__(self) -> None:
        if not (0 <= self.left < self.right and 0 <= self.top < self.bottom):
            raise Invalid(
                "Expected a rectangle with left < right and top < bottom, got"
                f" {self.left}, {self.top}, {self.right}, {self.bottom}."
            )


@dataclass(frozen=True)
class GameSettings:
    """What a behaviour sets of its game; None leaves it as the game has it.

    Attributes:
        hidden: Areas of the screen that learning does not see.
        max_steps: Steps after which an episode ends.
        end_rule: Name of the rule by which a loss ends an episode.
        options: Options of the start by name, such as the mode of an Atari game, sorted.
    """

    hidden: tuple[Rectangle, ...] | None = None
    max_steps: int | None = None
    end_rule: str | None = None
    options: tuple[tuple[str, int], ...] = ()

    @classmethod
    def from_json(cls, data: dict[str, Any]) -> GameSettings:
        """Read what `to_json` returned.

        Raises:
            Invalid: It is something else.
        """
        hidden, max_steps, end_rule = (data.get(n) for n in ("hidden", "max_steps", "end_rule"))
        options = data.get("options") or {}
        try:
            if not all(_is_whole(value) for value in (max_steps, *options.values())):
                raise TypeError
            return cls(
                hidden=None if hidden is None else tuple(Rectangle(*area) for area in hidden),
                max_steps=max_steps,
                end_rule=None if end_rule is None else str(end_rule),
                options=tuple(sorted(options.items())),
            )
        except (TypeError, AttributeError):
            raise Invalid(
                "The settings of a game are hidden areas [left, top, right, bottom], max_steps,"
                " end_rule and options with whole numbers."
            ) from None

    def to_json(self) -> dict[str, Any]:
        """Return the values set; areas as [left, top, right, bottom]."""
        data: dict[str, Any] = {}
        if self.hidden is not None:
            data["hidden"] = [[a.left, a.top, a.right, a.bottom] for a in self.hidden]
        if self.max_steps is not None:
            data["max_steps"] = self.max_steps
        if self.end_rule is not None:
            data["end_rule"] = self.end_rule
        if self.options:
            data["options"] = dict(self.options)
        return data


UNSET = GameSettings()


def _is_whole(value: object) -> bool:
    return value is None or (isinstance(value, int) and not isinstance(value, bool))
