"""The poster of a run: a picture for previews of links and for the gallery."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from functools import cache
from pathlib import Path

import matplotlib
from PIL import Image, ImageDraw, ImageFont

from trainer.sharing.contents import Contents
from trainer.sharing.films import picture_of, png
from tril.games.base import Game, Screen

WIDTH, HEIGHT = 1200, 630
"""What previews of links are made for."""
MARGIN = 40
GAP = 24
PICTURES_HEIGHT = 396
N_COLOURS = 128
LONGEST_NAME = 46
"""Characters of a behaviour's name that fit."""

MARK = "Poster made by Tril"
"""Comment in the file."""

PAPER, INK, FAINT, ACCENT = "#131312", "#ecebe4", "#b5b1a6", "#c6d44a"
"""Those of the pages in the dark (frontend/src/styles/tokens.css)."""


def poster_of(contents: Contents, stills: Sequence[tuple[str, Screen]]) -> bytes:
    """Return a PNG with a run's games and its verdict.

    Args:
        contents: What the run's page shows.
        stills: Name of each game with one of its screens, at most two.
    """
    poster = Image.new("RGB", (WIDTH, HEIGHT), PAPER)
    draw = ImageDraw.Draw(poster)
    left = MARGIN
    for name, still in stills:
        picture = _scaled(still, contents.game, (WIDTH - 2 * MARGIN - GAP) // 2, PICTURES_HEIGHT)
        poster.paste(picture, (left, MARGIN))
        draw.text((left, MARGIN + picture.height + 8), name, FAINT, _font("DejaVuSans", 20))
        left += picture.width + GAP
    top = MARGIN + PICTURES_HEIGHT + 52 if stills else HEIGHT // 3
    draw.rectangle((MARGIN, top, MARGIN + 6, top + 108), ACCENT)
    text = MARGIN + 24
    name = contents.behaviour.name
    if len(name) > LONGEST_NAME:
        name = name[: LONGEST_NAME - 1].rstrip() + "\u2026"
    draw.text((text, top - 8), name, INK, _font("DejaVuSans-Bold", 36))
    words = contents.verdict.sentence if contents.verdict else contents.behaviour.description
    lines = textwrap.wrap(words, 86, max_lines=2, placeholder=" \u2026")
    draw.multiline_text((text, top + 46), "\n".join(lines), FAINT, _font("DejaVuSans", 22))
    return png(poster.quantize(N_COLOURS, dither=Image.Dither.NONE), MARK)


def is_poster(content: bytes) -> bool:
    """Return whether a file is a poster, which a newer one may replace."""
    return MARK.encode("latin-1") in content


def _scaled(still: Screen, game: Game, width: int, height: int) -> Image.Image:
    """Return a screen with the shape that it is shown in, as large as fits."""
    picture = picture_of(still, game).convert("RGB")
    shown_width = picture.width * game.screen.pixel_aspect
    scale = min(width / shown_width, height / picture.height)
    size = round(shown_width * scale), round(picture.height * scale)
    return picture.resize(size, Image.Resampling.NEAREST)


@cache
def _font(name: str, size: int) -> ImageFont.FreeTypeFont:
    """Return a font that comes with Matplotlib."""
    path = Path(matplotlib.get_data_path()) / "fonts" / "ttf" / f"{name}.ttf"
    return ImageFont.truetype(str(path), size)
