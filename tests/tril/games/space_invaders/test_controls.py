import pytest

from testsupport.space_invaders import Keys, action_for
from tril.games.space_invaders import SPACE_INVADERS
from tril.games.space_invaders.memory import Action


@pytest.mark.parametrize(
    ("keys", "action"),
    [
        (Keys(0), Action.NOOP),
        (Keys.FIRE, Action.FIRE),
        (Keys.LEFT, Action.LEFT),
        (Keys.RIGHT, Action.RIGHT),
        (Keys.LEFT | Keys.FIRE, Action.LEFTFIRE),
        (Keys.RIGHT | Keys.FIRE, Action.RIGHTFIRE),
        (Keys.LEFT | Keys.RIGHT, Action.NOOP),
        (Keys.LEFT | Keys.RIGHT | Keys.FIRE, Action.FIRE),
    ],
)
def test_every_set_of_held_keys_has_its_action(keys: Keys, action: Action) -> None:
    assert action_for(keys) is action


def test_every_key_can_be_held_from_the_keyboard() -> None:
    controls = SPACE_INVADERS.controls
    assert set(controls.default_keys.values()) == set(controls.buttons)


@pytest.mark.parametrize("action", Action)
def test_the_keys_of_an_action_stand_for_it(action: Action) -> None:
    controls = SPACE_INVADERS.controls
    assert controls.action_for(controls.held[action]) == action
