import pytest

from tril.games.space_invaders.controls import DEFAULT_KEY_CODES, Keys, action_for, keys_for
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
    assert set(DEFAULT_KEY_CODES.values()) == set(Keys)


@pytest.mark.parametrize("action", Action)
def test_the_keys_of_an_action_stand_for_it(action: Action) -> None:
    assert action_for(keys_for(action)) is action
