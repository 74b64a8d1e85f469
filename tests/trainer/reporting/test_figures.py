"""The pictures, read back."""

from __future__ import annotations

from io import BytesIO

import numpy as np
import pytest
from PIL import Image

from trainer.reporting.figures import (
    COLOURS,
    MAP_SCALE,
    ColourMap,
    PlayedColumn,
    attention_picture,
    comparison_figure,
    curves_figure,
    extrapolation_figure,
    frame_picture,
    returns_figure,
)
from tril.analysis.extrapolation import JudgedGame, JudgedGames, Player
from tril.behaviours import BUILT_IN


def _pixels(png: bytes) -> np.ndarray[tuple[int, ...], np.dtype[np.uint8]]:
    return np.asarray(Image.open(BytesIO(png)).convert("RGB"))


@pytest.mark.parametrize("colour_map", ["perceptual", "red-blue"])
def test_attention_is_enlarged_without_smoothing_and_its_peak_stands_out(
    colour_map: ColourMap,
) -> None:
    attention = np.zeros((84, 84), np.float32)
    attention[10, 20] = 3.0
    pixels = _pixels(attention_picture(attention, colour_map))
    assert pixels.shape == (84 * MAP_SCALE, 84 * MAP_SCALE, 3)
    colours = {tuple(colour) for colour in pixels.reshape(-1, 3).tolist()}
    assert len(colours) == 2
    peak = pixels[10 * MAP_SCALE : 11 * MAP_SCALE, 20 * MAP_SCALE : 21 * MAP_SCALE]
    assert (peak == peak[0, 0]).all()
    assert int(peak[0, 0, 0]) > int(peak[0, 0, 2])


def test_a_map_without_attention_is_one_colour() -> None:
    pixels = _pixels(attention_picture(np.zeros((84, 84), np.float32), "perceptual"))
    assert len(np.unique(pixels.reshape(-1, 3), axis=0)) == 1


def test_a_frame_keeps_its_pixels() -> None:
    screen = np.random.default_rng(0).integers(0, 256, (210, 160, 3), dtype=np.uint8)
    pixels = _pixels(frame_picture(screen))
    np.testing.assert_array_equal(pixels[::2, ::2], screen)
    np.testing.assert_array_equal(pixels[1::2, 1::2], screen)


def test_strays_are_drawn_in_a_colour_of_their_own() -> None:
    column_1 = BUILT_IN[0]
    clean = PlayedColumn("imitator", "Imitator", (tuple(column_1.target or ()),))
    stray = PlayedColumn("imitator", "Imitator", (((0, 3),),))

    def has_stray_colour(column: PlayedColumn) -> bool:
        pixels = _pixels(comparison_figure(column_1, ["start 0"], [column]))
        return bool((np.abs(pixels.astype(int) - [0xB3, 0x26, 0x1E]).sum(axis=2) < 12).any())

    assert has_stray_colour(stray)
    assert not has_stray_colour(clean)


def _judged(player: Player, demonstrated: bool) -> JudgedGames:
    games = tuple(JudgedGame(worth, 10.0 * worth, worth) for worth in range(4))
    return JudgedGames(player, demonstrated, games)


def _count(png: bytes, colour: str) -> int:
    wanted = [int(colour[i : i + 2], 16) for i in (1, 3, 5)]
    return int((np.abs(_pixels(png).astype(int) - wanted).sum(axis=2) < 3).sum())


def test_demonstrations_are_filled_and_unseen_games_are_hollow() -> None:
    filled = extrapolation_figure([_judged("demonstrator", demonstrated=True)], "worth")
    hollow = extrapolation_figure([_judged("demonstrator", demonstrated=False)], "worth")
    colour = COLOURS["demonstrator"]
    assert _count(filled, colour) > 2 * _count(hollow, colour) > 0
    # Only demonstrations have a range that there is something beyond.
    assert _count(filled, "#f2f0ea") > 1000 > _count(hollow, "#f2f0ea")


def test_all_who_played_are_in_the_figure_in_their_colours() -> None:
    groups = [
        _judged("person", demonstrated=True),
        _judged("imitator", demonstrated=False),
        _judged("clone", demonstrated=False),
    ]
    figure = extrapolation_figure(groups, "worth")
    assert all(_count(figure, COLOURS[one.player]) > 20 for one in groups)
    assert _count(figure, COLOURS["demonstrator"]) == 0


def test_figures_with_missing_parts_are_drawn() -> None:
    column = PlayedColumn("clone", "Clone", (None, ()))
    assert _pixels(comparison_figure(BUILT_IN[6], ["0", "1"], [column])).ndim == 3
    assert _pixels(returns_figure([1, 2, 2], [3.0, 1.0, -2.0], 0.8)).ndim == 3
    assert _pixels(curves_figure([("return", COLOURS["imitator"], [])], "steps")).ndim == 3
