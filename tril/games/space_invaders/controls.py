"""The mapping between held keys and actions."""

from collections.abc import Mapping
from enum import IntFlag
from types import MappingProxyType

from tril.games.space_invaders.memory import Action


class Keys(IntFlag):
    """The held keys; the value is the byte in the play protocol."""

    LEFT = 1
    RIGHT = 2
    FIRE = 4


_MOVES = {Keys(0): 0, Keys.LEFT: -1, Keys.RIGHT: 1, Keys.LEFT | Keys.RIGHT: 0}

_ACTIONS = {
    (0, False): Action.NOOP,
    (0, True): Action.FIRE,
    (1, False): Action.RIGHT,
    (1, True): Action.RIGHTFIRE,
    (-1, False): Action.LEFT,
    (-1, True): Action.LEFTFIRE,
}


def action_for(keys: Keys) -> Action:
    """Return the action of the held keys.

    Left and right cancel out, as on a joystick. While fire is held, the game shoots again as soon
    as its one missile is gone.
    """
    return _ACTIONS[_MOVES[keys & (Keys.LEFT | Keys.RIGHT)], bool(keys & Keys.FIRE)]


_KEYS = {action_for(keys): keys for keys in map(Keys, (0, 1, 2, 4, 5, 6))}


def keys_for(action: int) -> Keys:
    """Return the held keys of an action, never both left and right."""
    return _KEYS[Action(action)]


DEFAULT_KEY_CODES: Mapping[str, Keys] = MappingProxyType(
    {
        "ArrowLeft": Keys.LEFT,
        "KeyA": Keys.LEFT,
        "ArrowRight": Keys.RIGHT,
        "KeyD": Keys.RIGHT,
        "Space": Keys.FIRE,
        "ArrowUp": Keys.FIRE,
        "KeyW": Keys.FIRE,
    }
)
"""Keys by `KeyboardEvent.code`, the physical key independent of the layout."""
