"""A small vocabulary of a game in a data folder, made in seconds."""

from __future__ import annotations

from pathlib import Path

import pytest

from tril.games.base import Game
from tril.vocabulary import making
from tril.vocabulary.facts import Vocabulary
from tril.vocabulary.pictures import pictures_of, write_pictures

N_GAMES = 3


def make_small_vocabulary(data: Path, game: Game, patch: pytest.MonkeyPatch) -> Vocabulary:
    """Have this process take vocabularies of few games, and make a game's.

    Args:
        data: The data folder.
        game: The game.
        patch: Keeps the number of games for as long as the vocabulary is used.
    """
    patch.setattr(making, "N_GAMES", N_GAMES)
    words = making.vocabulary_of(data, game)
    console = game.make_console()
    recordings = making.varied_games(game, N_GAMES)
    write_pictures(making.pictures_path(data, game), pictures_of(words, recordings, console))
    console.close()
    return words
