"""Buttons and keys of an environment, by what it calls its actions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from enum import EnumType
from typing import Any

from tril.games.base import Controls

NEUTRAL = frozenset({"noop", "no op", "idle", "none", "nothing", "stay"})
"""Names of the action that is executed while no button is held."""

_NAMES: Mapping[str, tuple[str, ...]] = {
    "AcrobotEnv": ("left", "idle", "right"),
    "BlackjackEnv": ("stick", "hit"),
    "CartPoleEnv": ("left", "right"),
    "CliffWalkingEnv": ("up", "right", "down", "left"),
    "FrozenLakeEnv": ("left", "down", "right", "up"),
    "LunarLander": ("idle", "left", "up", "right"),
    "MountainCarEnv": ("left", "idle", "right"),
    "TaxiEnv": ("down", "up", "right", "left", "pickup", "drop"),
}
"""Of Gymnasium's own environments, which do not tell, by class.

The main engine of LunarLander, which lifts, is "up".
"""

_KEYS: Mapping[str, tuple[str, ...]] = {
    "left": ("ArrowLeft", "KeyA"),
    "right": ("ArrowRight", "KeyD"),
    "up": ("ArrowUp", "KeyW"),
    "down": ("ArrowDown", "KeyS"),
    "forward": ("ArrowUp", "KeyW"),
    "back": ("ArrowDown", "KeyS"),
    "backward": ("ArrowDown", "KeyS"),
    "lane left": ("ArrowUp", "KeyW"),  # roads are drawn from left to right
    "lane right": ("ArrowDown", "KeyS"),
    "slower": ("ArrowLeft", "KeyA"),
    "faster": ("ArrowRight", "KeyD"),
}
_SPARE_KEYS = (
    "Space",
    *(f"Digit{n}" for n in range(1, 10)),
    *(f"Key{c}" for c in "QERFTGYHZXCVBNM"),
)
"""For what has no direction, in this order: one for each button that there may be."""


def action_names(environment: Any, n_actions: int) -> tuple[str, ...]:
    """Return the names of an environment's actions, in small letters.

    They are those that the environment tells in one of the ways in use, else "action 0" and so on.

    Args:
        environment: Without wrappers.
        n_actions: Number of its actions.
    """
    given_names = _NAMES.get(type(environment).__name__) or _declared_names(environment)
    names = tuple(str(name).lower().replace("_", " ").strip() for name in given_names)
    if len(names) != n_actions or len(set(names)) != n_actions or not all(names):
        return tuple(f"action {number}" for number in range(n_actions))
    return names


def _declared_names(environment: Any) -> Sequence[str]:
    meanings = getattr(environment, "get_action_meanings", None)
    if callable(meanings):
        return list(meanings())
    actions = getattr(environment, "actions", None)
    if isinstance(actions, EnumType):
        members: Mapping[str, Any] = actions.__members__
        return _in_order({member.value: name for name, member in members.items()})
    names = getattr(environment, "action_names", None)
    if isinstance(names, Sequence):
        return names
    # As highway-env does.
    by_number = getattr(getattr(environment, "action_type", None), "actions", None)
    return _in_order(by_number) if isinstance(by_number, Mapping) else ()


def _in_order(names: Mapping[Any, Any]) -> list[str]:
    """Return names by action, none if the actions do not count from 0."""
    if set(names) != set(range(len(names))):
        return []
    return [str(names[number]) for number in range(len(names))]


def controls_of(names: Sequence[str]) -> Controls:
    """Return the controls of actions with these names: a button for each but the neutral one.

    Without a neutral action, the game waits until a button is held.
    """
    neutral = next((number for number, name in enumerate(names) if name in NEUTRAL), None)
    buttons = [name for number, name in enumerate(names) if number != neutral]
    held = []
    for number, name in enumerate(names):
        held.append(0 if number == neutral else 1 << buttons.index(name))
    return Controls(
        actions=tuple(names),
        buttons=tuple(buttons),
        held=tuple(held),
        default_keys=_default_keys(buttons),
        waits=neutral is None,
    )


def _default_keys(buttons: Sequence[str]) -> dict[str, str]:
    keys: dict[str, str] = {}
    for button in buttons:
        for key in _KEYS.get(button, ()):
            keys.setdefault(key, button)
    spare = iter(key for key in _SPARE_KEYS if key not in keys)
    for button in buttons:
        if button not in keys.values():
            keys[next(spare)] = button
    return keys
