"""The pictures, read back."""

from __future__ import annotations

from io import BytesIO
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from PIL import Image

from tests.trainer.reporting.entries import entry
from trainer.reporting.figures import (
    COLOURS,
    MAP_SCALE,
    PRINT,
    SCREEN,
    VECTOR,
    AliensRow,
    ColourMap,
    PictureForm,
    aliens_figure,
    attention_figure,
    attention_picture,
    curves_figure,
    extrapolation_figure,
    frame_picture,
    returns_figure,
)
from tril.analysis.extrapolation import JudgedGame, JudgedGames, PlayerKind
from tril.games.base import Cell
from tril.games.space_invaders.behaviours import BUILT_IN


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

    def has_stray_colour(*hits: Cell) -> bool:
        row = AliensRow("start 0", column_1, (hits,))
        return _count(aliens_figure([row], [("imitator", "Imitator")]), "#b3261e") > 0

    assert has_stray_colour((0, 3))
    assert not has_stray_colour(*(column_1.target or ()))


def _judged(player: PlayerKind, demonstrated: bool) -> JudgedGames:
    games = tuple(JudgedGame(worth, 10.0 * worth, worth) for worth in range(4))
    return JudgedGames(player, demonstrated, "final_level", games)


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
        _judged("varied", demonstrated=True),
        _judged("imitator", demonstrated=False),
        _judged("clone", demonstrated=False),
    ]
    figure = extrapolation_figure(groups, "worth")
    assert all(_count(figure, COLOURS[one.player]) > 20 for one in groups)
    assert _count(figure, COLOURS["demonstrator"]) == 0


def test_figures_with_missing_parts_are_drawn() -> None:
    rows = [AliensRow("start 0", BUILT_IN[6], (None, ()))]
    columns = [("imitator", "Imitator"), ("clone", "Clone")]
    assert _pixels(aliens_figure(rows, columns)).ndim == 3
    assert _pixels(returns_figure([("Column 2", entry(check={}))])).ndim == 3
    assert _pixels(returns_figure([("Row 1", entry(demonstrations=()))] * 5)).ndim == 3
    assert _pixels(curves_figure([("return", COLOURS["imitator"], [])], "steps")).ndim == 3


def test_attention_maps_stand_above_their_screens_pixel_by_pixel(tmp_path: Path) -> None:
    attention = np.random.default_rng(0).random((84, 84), np.float32)
    screen = np.random.default_rng(1).integers(0, 256, (210, 160, 3), dtype=np.uint8)
    (tmp_path / "map.png").write_bytes(attention_picture(attention, "perceptual"))
    (tmp_path / "screen.png").write_bytes(frame_picture(screen))
    state = ("maximum", tmp_path / "map.png", tmp_path / "screen.png")
    figure = _pixels(attention_figure("Column 1", [state, state]))
    np.testing.assert_array_equal(figure[56:392, 8:344], _pixels(state[1].read_bytes()))
    np.testing.assert_array_equal(figure[400:820, 352:672], _pixels(state[2].read_bytes()))


def test_a_figure_for_print_is_larger_and_one_in_vectors_is_the_same_each_time() -> None:
    def drawn(form: PictureForm) -> bytes:
        curve = ("return", COLOURS["imitator"], [(0, 1.0), (10, 2.0)])
        return curves_figure([curve], "steps", form)

    assert _pixels(drawn(PRINT)).shape[0] > 1.8 * _pixels(drawn(SCREEN)).shape[0]
    assert drawn(VECTOR) == drawn(VECTOR)
    root = ElementTree.fromstring(drawn(VECTOR).decode())
    assert root.tag.endswith("svg")
    assert not [one for one in root.iter() if one.tag.endswith("text")]
