"""Draw the pictures of all games: ``python -m scripts.draw_pictures``."""

from __future__ import annotations

import sys
import zipfile

from server.play.replays.products import thumbnail_png
from tril.errors import Invalid
from tril.games import game_named, game_titles
from tril.play.pictures import PICTURES, picture_name
from tril.sample import sample

_EPOCH = (2026, 1, 1, 0, 0, 0)
"""The time of each, so that equal pictures make an equal file."""


def main() -> None:
    """Write the pictures of all games that can be taught."""
    with zipfile.ZipFile(PICTURES, "w") as archive:
        for name in sorted(game_titles()):
            try:
                game = game_named(name)
            except Invalid as error:
                sys.stderr.write(f"{name}: {error}\n")
                continue
            info = zipfile.ZipInfo(picture_name(name), _EPOCH)
            archive.writestr(info, thumbnail_png(sample(game)))


if __name__ == "__main__":
    main()
