"""Which pieces of its still picture each game has: dots, bricks, shields, tiles.

    python -m benchmarks.learning.behaviours.pieces FOLDER --games ms_pacman qbert --picture FILE

Makes each game's vocabulary from random play, and prints how many areas its pieces have, their
share of the screen, and which share of them random play clears. The picture shows the games side
by side as they begin, with their pieces lit.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from PIL import Image

from tril.games import game_named
from tril.games.base import Game
from tril.vocabulary.facts import Vocabulary
from tril.vocabulary.making import vocabulary_of
from tril.vocabulary.pictures import lit
from tril.vocabulary.pieces import Areas

SCALE = 2
GAP_PX = 8


def picture_of(words: Vocabulary, game: Game) -> Image.Image:
    """Return the beginning of a game with its pieces lit, enlarged."""
    pieces = words.pieces
    none = np.zeros(words.scene.beginning.shape, np.bool_)
    picture = Image.fromarray(lit(words.scene.beginning, none if pieces is None else pieces, game))
    return picture.resize((SCALE * picture.width, SCALE * picture.height), Image.Resampling.NEAREST)


def side_by_side(pictures: list[Image.Image]) -> Image.Image:
    """Return pictures in a row."""
    width = sum(picture.width + GAP_PX for picture in pictures) - GAP_PX
    row = Image.new("RGB", (width, max(picture.height for picture in pictures)), "white")
    left = 0
    for picture in pictures:
        row.paste(picture, (left, 0))
        left += picture.width + GAP_PX
    return row


def main() -> None:
    """Print the table and write the picture."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--games", nargs="+", required=True)
    parser.add_argument("--picture", type=Path)
    arguments = parser.parse_args()
    print("game             areas  of the screen  cleared by random play")
    pictures: list[Image.Image] = []
    for name in arguments.games:
        game = game_named(name)
        words = vocabulary_of(arguments.folder, game)
        pictures.append(picture_of(words, game))
        if words.pieces is None:
            print(f"{name:15} none", flush=True)
            continue
        group = next(i for i, one in enumerate(words.groups) if one.aspect == "gone")
        # Mean over a game's steps, as facts of games are.
        cleared = words.pool[:, words.columns[group][0]].mean()
        n_areas = len(Areas.of(words.pieces).boxes)
        print(f"{name:15} {n_areas:5} {words.pieces.mean():14.1%} {cleared:8.1%}", flush=True)
    if arguments.picture:
        side_by_side(pictures).save(arguments.picture)


if __name__ == "__main__":
    main()
