"""Film strips of recordings."""

from __future__ import annotations

import io
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from server.play.replays.strip import N_MOMENTS, StripFormat, choose_moments, strip_webp
from testsupport.workplace import Workplace
from tril.games import game_named
from tril.games.base import ScreenSpec
from tril.games.space_invaders import SPACE_INVADERS
from tril.recording import replay
from tril.sample import sample
from tril.store import recordings

SPEC = SPACE_INVADERS.screen
assert SPEC.palette is not None


@given(st.lists(st.integers(0, 3), min_size=1, max_size=40), st.integers(1, 500))
def test_the_moments_are_in_order_of_time_from_the_first_to_the_last(
    shades: list[int], apart: int
) -> None:
    looks = np.array(shades, np.float32)[:, None]
    chosen = choose_moments(looks, apart * np.arange(len(shades)))
    assert chosen == sorted(chosen)
    assert (len(chosen), chosen[0], chosen[-1]) == (N_MOMENTS, 0, len(shades) - 1)
    assert len(set(chosen)) == min(N_MOMENTS, len(shades))


def test_a_game_in_which_nothing_changes_is_shown_at_even_intervals() -> None:
    chosen = choose_moments(np.zeros((64, 5), np.float32), np.arange(64))
    assert max(np.diff(chosen)) <= 2 * min(np.diff(chosen))


def test_each_thing_that_happens_once_is_shown_however_close_to_another() -> None:
    looks = np.zeros((64, 5), np.float32)
    events = [30, 31, 32, 50]
    looks[events, range(4)] = 255
    assert set(events) < set(choose_moments(looks, np.arange(64)))


@pytest.mark.parametrize(
    ("screen", "sizes"),
    [
        (SPEC, (160, 210, 80, 52)),
        (ScreenSpec(400, 600, None, None), (300, 200, 75, 50)),
        (ScreenSpec(96, 96, None, None), (96, 96, 48, 48)),
    ],
)
def test_moments_of_large_screens_are_reduced_and_small_ones_are_at_most_so_wide(
    screen: ScreenSpec, sizes: tuple[int, ...]
) -> None:
    assert StripFormat.of(screen) == StripFormat(*sizes)


def test_a_strip_shows_screens_of_the_game_from_its_start_to_its_end_in_exact_colours(
    workplace: Workplace,
) -> None:
    with workplace.database.reading() as session:
        recording = recordings.as_recording(recordings.get(session, workplace.ranked[0]))
    screens: list[bytes] = []
    assert SPEC.palette is not None
    palette = SPEC.palette
    replay(
        recording,
        None,
        lambda episode: screens.append(palette[episode.console.screen()].tobytes()),
    )
    with Image.open(io.BytesIO(strip_webp(recording))) as picture:
        strip = np.asarray(picture.convert("RGB"))
    assert strip.shape == (4 * 210 + 2 * 52, 320, 3)
    moments = strip[: 4 * 210].reshape(4, 210, 2, 160, 3).swapaxes(1, 2).reshape(8, 210, 160, 3)
    frames = [screens.index(moment.tobytes()) for moment in moments]
    assert frames == sorted(frames)
    assert moments[-1].tobytes() == screens[-1]
    assert frames[0] == 0
    # A reduced pixel has the colour of one of those that it stands for.
    small, whole = strip[840:892, :80], moments[0][:208].reshape(52, 4, 80, 2, 3)
    same = (whole == small[:, None, :, None]).all(axis=4).any(axis=(1, 3))
    assert same.all()


def test_a_shot_that_is_a_pixel_wide_is_seen_in_the_reduced_moments() -> None:
    from server.play.replays.strip import _small

    screen = np.zeros(SPEC.shape, np.uint8)
    screen[100:103, 51] = 0x36
    shot = _small(SPEC, screen)[25, 25]
    assert SPEC.palette is not None
    np.testing.assert_array_equal(shot, SPEC.palette[0x36])


@pytest.mark.parametrize("name", ["gym:CartPole-v1", "gym:FrozenLake-v1", "pacman"])
def test_any_game_has_a_strip_of_the_sizes_that_the_page_is_told(name: str) -> None:
    recording = sample(game_named(name))
    recording = replace(recording, actions=recording.actions[:40], hashes=())
    size = StripFormat.of(recording.game.screen)
    with Image.open(io.BytesIO(strip_webp(recording))) as picture:
        assert picture.height == 4 * size.height + 2 * size.small_height
        assert picture.width == max(2 * size.width, 4 * size.small_width)
