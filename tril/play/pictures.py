"""Pictures of games that were drawn beforehand: a page of a hundred games shows them at once.

``python -m scripts.draw_pictures`` draws them anew. A game that is missing is played for its
picture when it is asked for.
"""

from __future__ import annotations

import zipfile
from functools import cache
from pathlib import Path

PICTURES = Path(__file__).with_name("pictures.zip")


def picture_name(game: str) -> str:
    """Return the name of a game's picture among them."""
    return f"{game}.png"


def drawn_picture(game: str) -> bytes | None:
    """Return a PNG of a game by its name, some seconds after its start; None if none was drawn.

    The game is not made for it, which takes seconds where a package has to be imported first.
    """
    return _pictures().get(picture_name(game))


@cache
def _pictures() -> dict[str, bytes]:
    with zipfile.ZipFile(PICTURES) as archive:
        return {name: archive.read(name) for name in archive.namelist()}
