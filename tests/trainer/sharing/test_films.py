"""Games as films: what a page decodes is what the console showed."""

from __future__ import annotations

import zlib
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from trainer.sharing.films import FilmEncoder, film_of
from tril.games import game_named
from tril.games.base import Screen
from tril.play.screens import brightest
from tril.recording import Recording, RecordingRefused, replay
from tril.sample import sample

LENGTH = 300


def decoded(content: bytes, shape: tuple[int, ...]) -> list[Screen]:
    """Decode a film as docs/protocol.md describes it."""
    data, at = zlib.decompress(content), 0

    def number() -> int:
        nonlocal at
        value = shift = 0
        while True:
            byte = data[at]
            at += 1
            value |= (byte & 127) << shift
            shift += 7
            if byte < 128:
                return value

    pixels = np.zeros(int(np.prod(shape)), np.uint8)
    pictures = []
    while at < len(data):
        place = 0
        for _ in range(number()):
            place += number()
            length = number()
            pixels[place : place + length] ^= np.frombuffer(data[at : at + length], np.uint8)
            at, place = at + length, place + length
        pictures.append(pixels.reshape(shape).copy())
    return pictures


def screens_of(recording: Recording) -> list[Screen]:
    screens: list[Screen] = []
    replay(recording, None, lambda episode: screens.append(episode.console.screen().copy()))
    return screens


@given(st.lists(st.binary(min_size=LENGTH, max_size=LENGTH), max_size=5), st.integers(0, 255))
def test_any_screens_are_decoded_as_they_were(contents: list[bytes], mask: int) -> None:
    # Masked, so that there are unchanged bytes of all lengths in between.
    screens = [np.frombuffer(content, np.uint8) & np.uint8(mask) for content in contents]
    encoder = FilmEncoder((LENGTH,))
    for screen in screens:
        encoder.add(screen)
    assert np.array_equal(decoded(encoder.finish(), (LENGTH,)), screens)


@pytest.mark.parametrize("name", ["space_invaders", "pong", "gym:CartPole-v1"])
def test_a_film_has_every_frame_of_a_game(name: str) -> None:
    recording = sample(game_named(name))
    screens = screens_of(recording)
    film = film_of(recording, still_frame=3)
    assert film.last == len(screens) - 1
    assert np.array_equal(decoded(film.content, screens[0].shape), screens)
    assert len(film.content) < sum(screen.nbytes for screen in screens) / 50


def test_fewer_pictures_are_the_brightest_of_their_frames() -> None:
    recording = sample(game_named("space_invaders"))
    screens, gray = screens_of(recording), recording.game.screen.grayscale
    assert gray is not None
    film = film_of(recording, 3, frames_per_picture=3, longest=100)
    pictures = decoded(film.content, screens[0].shape)
    assert (film.last, len(pictures)) == (100, 34)
    assert np.array_equal(pictures[1], brightest(np.array(screens[3:6]), gray))
    assert np.array_equal(film.still, brightest(np.array(screens[2:4]), gray))


def test_a_game_that_goes_otherwise_than_it_was_recorded_is_refused() -> None:
    game = game_named("space_invaders")
    recording = replace(sample(game), hashes=("0" * 32,) * 4)
    with pytest.raises(RecordingRefused, match="differs from what was recorded"):
        film_of(recording, 3)
