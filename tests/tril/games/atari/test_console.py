import numpy as np
import pytest

from tests.tril.conftest import random_actions
from testsupport.space_invaders import grayscale, new_console, ram, rgb
from tril.games.atari.catalogue import rom_md5
from tril.games.atari.console import AtariConsole
from tril.games.atari.starts import AtariStart
from tril.games.space_invaders.memory import INTRO_FRAMES, RAM_PHASE, Action

FRAMES = 300


def play(console: AtariConsole, actions: list[int]) -> list[tuple[bytes, bytes]]:
    """Return RAM and screen after every frame."""
    seen = []
    for action in actions:
        console.act(action)
        seen.append((console.ram_bytes(), console.screen().tobytes()))
    return seen


def test_a_start_is_the_intro_and_the_idle_frames_unseen() -> None:
    console = new_console()
    console.start(AtariStart(0))
    for _ in range(13):
        console.act(0)
    played = play(console, random_actions(seed=2, frames=FRAMES))
    console.start(AtariStart(13))
    assert play(console, random_actions(seed=2, frames=FRAMES)) == played


def test_nothing_moves_before_the_start_and_keys_work_after_it() -> None:
    console = new_console()
    ale = console._ale
    ale.reset_game()
    for _ in range(INTRO_FRAMES):
        assert ale.getRAM()[RAM_PHASE] == 1
        ale.act(1)
    console.start(AtariStart(0))
    x = ram(console)[28]
    for _ in range(8):
        console.act(2)
    assert ram(console)[28] > x


def test_a_start_without_its_intro_is_right_after_the_reset() -> None:
    emulator = new_console()
    emulator._ale.reset_game()
    actions = random_actions(seed=2, frames=FRAMES)
    console = new_console({})
    console.start(AtariStart(3))  # a start in the cache that must not be gone on from
    console.start(AtariStart(5, intro=False))
    assert play(console, actions) == play(emulator, [0] * 5 + actions)[5:]


def test_starts_are_the_same_in_whatever_order_they_are_reached() -> None:
    starts = [
        AtariStart(90),
        AtariStart(4),
        AtariStart(91),
        AtariStart(4, difficulty=1),
        AtariStart(50),
        AtariStart(50, intro=False),
        AtariStart(91),
        AtariStart(51, intro=False),
    ]
    shared = new_console({})
    for start in starts:
        shared.start(start)
        alone = new_console()
        alone.start(start)
        actions = random_actions(seed=3, frames=60)
        assert play(shared, actions) == play(alone, actions)


def test_different_starts_give_different_games(console: AtariConsole) -> None:
    games = set()
    for idle_frames in range(128):
        console.start(AtariStart(idle_frames))
        for _ in range(80):
            console.act(1)
        games.add(console.state_hash())
    assert len(games) == 128


def test_the_difficulty_makes_another_game(console: AtariConsole) -> None:
    console.start(AtariStart(9))
    easy = play(console, random_actions(seed=4, frames=60))
    console.start(AtariStart(9, difficulty=1))
    assert play(console, random_actions(seed=4, frames=60)) != easy


def test_a_restored_console_goes_on_as_it_did(console: AtariConsole) -> None:
    console.start(AtariStart(20))
    play(console, random_actions(seed=5, frames=200))
    state = console.save()
    screen = console.screen().tobytes()
    after = play(console, random_actions(seed=6, frames=FRAMES))
    for restored in (console, new_console()):
        restored.restore(new_console().state_from_bytes(state.to_bytes()))
        assert restored.screen().tobytes() == screen
        assert play(restored, random_actions(seed=6, frames=FRAMES)) == after


def test_a_game_can_begin_after_one_that_was_lost(console: AtariConsole) -> None:
    console.start(AtariStart(6))
    expected = play(console, random_actions(seed=9, frames=60))
    while not console._ale.game_over():
        console.act(0)
    console.start(AtariStart(6))
    assert console.lives == 3
    assert play(console, random_actions(seed=9, frames=60)) == expected


def test_a_state_of_another_version_is_refused(console: AtariConsole) -> None:
    console.start(AtariStart(0))
    data = bytearray(console.save().to_bytes())
    data[0] = 99
    with pytest.raises(ValueError, match="version 2, got 99"):
        new_console().state_from_bytes(bytes(data))


def test_grayscale_and_colours_are_the_emulators_own(console: AtariConsole) -> None:
    ale = console._ale
    console.start(AtariStart(30))
    for action in random_actions(seed=7, frames=FRAMES):
        console.act(action)
        gray = ale.getScreenGrayscale()
        np.testing.assert_array_equal(grayscale(console), gray)
        np.testing.assert_array_equal(rgb(console), ale.getScreenRGB())


def test_the_palette_is_right_for_every_colour_that_the_game_can_be_made_to_show() -> None:
    console = new_console()
    console.start(AtariStart(0))
    state = console.save()
    seen: set[int] = set()
    for mask in range(0, 256, 2):
        console.restore(state)
        # The byte that the game inverts its colours with when nobody plays.
        console._ale.setRAM(71, mask)
        console.act(0)
        seen |= set(np.unique(console.screen()).tolist())
        np.testing.assert_array_equal(rgb(console), console._ale.getScreenRGB())
        np.testing.assert_array_equal(grayscale(console), console._ale.getScreenGrayscale())
    assert len(seen) > 50
    assert all(value % 2 == 0 for value in seen)


def test_the_ram_hash_tells_states_apart_and_is_short(console: AtariConsole) -> None:
    console.start(AtariStart(0))
    hashes = {console.state_hash()}
    for action in range(len(Action)):
        console.act(action)
        hashes.add(console.state_hash())
    assert len(hashes) == len(Action) + 1
    assert {len(one) for one in hashes} == {16}


def test_the_rom_is_the_one_that_recordings_name() -> None:
    assert rom_md5("space_invaders") == "72ffbef6504b75e69ee1045af9075f66"
