"""The joystick: buttons and keys of a game by the names of its actions."""

from __future__ import annotations

from collections.abc import Sequence

from tril.games.base import Controls

BUTTONS = ("left", "right", "up", "down", "fire")
"""In the order of their bits; a game has those that its actions need."""

_KEYS = {
    "left": ("ArrowLeft", "KeyA"),
    "right": ("ArrowRight", "KeyD"),
    "up": ("ArrowUp", "KeyW"),
    "down": ("ArrowDown", "KeyS"),
    "fire": ("Space",),
}


def joystick(actions: Sequence[str]) -> Controls:
    """Return the controls of actions named as the emulator does, e.g. "UPRIGHTFIRE".

    Where nothing is above, the keys for up fire, too.
    """
    needed = [button for button in BUTTONS if any(button.upper() in name for name in actions)]
    bits = {button: 1 << place for place, button in enumerate(needed)}
    keys = {key: button for button in needed for key in _KEYS[button]}
    if "fire" in needed and "up" not in needed:
        keys |= dict.fromkeys(_KEYS["up"], "fire")
    return Controls(
        actions=tuple(actions),
        buttons=tuple(needed),
        held=tuple(
            sum(bit for button, bit in bits.items() if button.upper() in name) for name in actions
        ),
        default_keys=keys,
    )
