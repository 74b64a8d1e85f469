"""The joystick: buttons and keys of a game by the names of its actions."""

from __future__ import annotations

from collections.abc import Sequence

from tril.games.base import Controls

_DIAGONALS = ("UPRIGHT", "UPLEFT", "DOWNRIGHT", "DOWNLEFT")

BUTTONS = ("left", "right", "up", "down", "fire")
"""In the order of their bits; a game has those that its actions need."""

ALL_ACTIONS = tuple(
    move + fire
    for moves, fire in (
        (("NOOP", "FIRE", "UP", "RIGHT", "LEFT", "DOWN"), ""),
        (_DIAGONALS, ""),
        (("UP", "RIGHT", "LEFT", "DOWN"), "FIRE"),
        (_DIAGONALS, "FIRE"),
    )
    for move in moves
)
"""All actions of a joystick, in the order of the emulator's numbers."""

_KEYS = {
    "left": ("ArrowLeft", "KeyA"),
    "right": ("ArrowRight", "KeyD"),
    "up": ("ArrowUp", "KeyW"),
    "down": ("ArrowDown", "KeyS"),
    "fire": ("Space",),
}


_TURNED = {"left": "down", "right": "up"}
"""What left and right are where they move things down and up, as in Pong."""


def joystick(actions: Sequence[str], *, turned: bool = False) -> Controls:
    """Return the controls of actions named as the emulator does, e.g. "UPRIGHTFIRE".

    Where nothing is above, the keys for up fire, too.

    Args:
        actions: Names of the actions.
        turned: Whether left moves things down on the screen, and right up.
    """
    needed = _needed(actions)
    buttons = [_TURNED.get(button, button) for button in needed] if turned else needed
    keys = {key: button for button in buttons for key in _KEYS[button]}
    if "fire" in buttons and "up" not in buttons:
        keys |= dict.fromkeys(_KEYS["up"], "fire")
    return Controls(
        actions=tuple(actions),
        buttons=tuple(buttons),
        held=tuple(_held(needed, name) for name in actions),
        default_keys=keys,
    )


def reduced_action(controls: Controls, name: str) -> int:
    """Return the action of a game for any of a joystick's: its own, or what is left of it.

    What a game has no action for does nothing in it, such as the emulator's UP in Pong.
    """
    return controls.action_for(_held(_needed(controls.actions), name))


def _needed(actions: Sequence[str]) -> list[str]:
    return [button for button in BUTTONS if any(button.upper() in name for name in actions)]


def _held(buttons: Sequence[str], name: str) -> int:
    """Return the buttons held for an action, as bits, by the action's name."""
    return sum(1 << place for place, button in enumerate(buttons) if button.upper() in name)
