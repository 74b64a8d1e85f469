import numpy as np
import pytest

from tests.tril.conftest import random_actions
from tril.games.atari.console import Console, ConsoleState
from tril.games.space_invaders.memory import ACTION_COUNT, INTRO_FRAMES, RAM_PHASE, rom_md5
from tril.play.episode import Start

FRAMES = 300


def play(console: Console, actions: list[int]) -> list[tuple[bytes, bytes]]:
    """Return RAM and screen after every frame."""
    seen = []
    for action in actions:
        console.act(action)
        seen.append((console.ram_bytes(), console.screen_palette().tobytes()))
    return seen


def test_a_start_is_the_intro_and_the_idle_frames_unseen() -> None:
    console = Console()
    console.start(Start(0))
    for _ in range(13):
        console.act(0)
    played = play(console, random_actions(seed=2, frames=FRAMES))
    console.start(Start(13))
    assert play(console, random_actions(seed=2, frames=FRAMES)) == played


def test_nothing_moves_before_the_start_and_keys_work_after_it() -> None:
    console = Console()
    ale = console._ale
    ale.reset_game()
    for _ in range(INTRO_FRAMES):
        assert ale.getRAM()[RAM_PHASE] == 1
        ale.act(1)
    console.start(Start(0))
    x = console.ram[28]
    for _ in range(8):
        console.act(2)
    assert console.ram[28] > x


def test_starts_are_the_same_in_whatever_order_they_are_reached() -> None:
    starts = [Start(90), Start(4), Start(91), Start(4, difficulty=1), Start(50), Start(91)]
    shared = Console({})
    for start in starts:
        shared.start(start)
        alone = Console()
        alone.start(start)
        actions = random_actions(seed=3, frames=60)
        assert play(shared, actions) == play(alone, actions)


def test_different_starts_give_different_games(console: Console) -> None:
    games = set()
    for idle_frames in range(128):
        console.start(Start(idle_frames))
        for _ in range(80):
            console.act(1)
        games.add(console.ram_hash())
    assert len(games) == 128


def test_the_difficulty_makes_another_game(console: Console) -> None:
    console.start(Start(9))
    easy = play(console, random_actions(seed=4, frames=60))
    console.start(Start(9, difficulty=1))
    assert play(console, random_actions(seed=4, frames=60)) != easy


def test_a_restored_console_goes_on_as_it_did(console: Console) -> None:
    console.start(Start(20))
    play(console, random_actions(seed=5, frames=200))
    state = console.save()
    screen = console.screen_palette().tobytes()
    after = play(console, random_actions(seed=6, frames=FRAMES))
    for restored in (console, Console()):
        restored.restore(ConsoleState.from_bytes(state.to_bytes()))
        assert restored.screen_palette().tobytes() == screen
        assert play(restored, random_actions(seed=6, frames=FRAMES)) == after


def test_a_game_can_begin_after_one_that_was_lost(console: Console) -> None:
    console.start(Start(6))
    expected = play(console, random_actions(seed=9, frames=60))
    while not console._ale.game_over():
        console.act(0)
    console.start(Start(6))
    assert console.lives == 3
    assert play(console, random_actions(seed=9, frames=60)) == expected


def test_a_state_of_another_version_is_refused(console: Console) -> None:
    console.start(Start(0))
    data = bytearray(console.save().to_bytes())
    data[0] = 99
    with pytest.raises(ValueError, match="version 1, got 99"):
        ConsoleState.from_bytes(bytes(data))


def test_grayscale_and_colours_are_the_emulators_own(console: Console) -> None:
    ale = console._ale
    console.start(Start(30))
    out = np.empty((210, 160), np.uint8)
    for action in random_actions(seed=7, frames=FRAMES):
        console.act(action)
        gray = ale.getScreenGrayscale()
        np.testing.assert_array_equal(console.screen_grayscale(), gray)
        assert console.screen_grayscale(out) is out
        np.testing.assert_array_equal(out, gray)
        np.testing.assert_array_equal(console.screen_rgb(), ale.getScreenRGB())


def test_the_palette_is_right_for_every_colour_that_the_game_can_be_made_to_show() -> None:
    console = Console()
    console.start(Start(0))
    state = console.save()
    seen: set[int] = set()
    for mask in range(0, 256, 2):
        console.restore(state)
        # The byte that the game inverts its colours with when nobody plays.
        console._ale.setRAM(71, mask)
        console.act(0)
        seen |= set(np.unique(console.screen_palette()).tolist())
        np.testing.assert_array_equal(console.screen_rgb(), console._ale.getScreenRGB())
        np.testing.assert_array_equal(console.screen_grayscale(), console._ale.getScreenGrayscale())
    assert len(seen) > 50
    assert all(value % 2 == 0 for value in seen)


def test_the_ram_hash_tells_states_apart_and_is_short(console: Console) -> None:
    console.start(Start(0))
    hashes = {console.ram_hash()}
    for action in range(ACTION_COUNT):
        console.act(action)
        hashes.add(console.ram_hash())
    assert len(hashes) == ACTION_COUNT + 1
    assert {len(one) for one in hashes} == {16}


def test_the_rom_is_the_one_that_recordings_name() -> None:
    assert rom_md5() == "72ffbef6504b75e69ee1045af9075f66"
