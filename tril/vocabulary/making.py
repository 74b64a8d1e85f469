"""Making the vocabulary of a game from varied play, once, and keeping it in the data folder."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path

import numpy as np

from tril.demonstrators.random_play import play_randomly
from tril.errors import Invalid
from tril.files.artifact_store import write_whole
from tril.games.base import Game
from tril.recording import Recording
from tril.vocabulary.blobs import Background
from tril.vocabulary.facts import FORMAT_VERSION, Vocabulary
from tril.vocabulary.trace import count_background, trace

N_GAMES = 40
SEED = 20_261_128
FOLDER = "vocabularies"
SHIPPED = Path(__file__).with_name("shipped")
"""Vocabularies of games as they are without settings, made by `tril games prepare`."""

Progress = Callable[[int, int], None]
"""Called with what is done and the total."""


def varied_games(game: Game, n_games: int, progress: Progress | None = None) -> list[Recording]:
    """Play the games that a vocabulary is made of, the same ones every time.

    Args:
        game: The game.
        n_games: How many; the first ones of more.
        progress: Told after each.
    """
    console = game.make_console()
    recordings = []
    for number in range(n_games):
        rng = np.random.default_rng([SEED, number])
        recordings.append(play_randomly(rng, console).recording)
        if progress:
            progress(number + 1, n_games)
    console.close()
    return recordings


def make_vocabulary(game: Game, progress: Progress | None = None) -> Vocabulary:
    """Make the vocabulary of a game from random play.

    Args:
        game: The game, as its behaviour sets it.
        progress: Told after each of the games was played or looked at.
    """
    n_games = N_GAMES
    total = 3 * n_games

    def report(done: int, _total: int) -> None:
        if progress:
            progress(done, total)

    recordings = varied_games(game, n_games, report)
    console = game.make_console()
    background = Background((game.screen.height, game.screen.width))
    for number, recording in enumerate(recordings, 1):
        count_background(recording, console, background)
        report(n_games + number, total)
    mode = background.mode()
    traces = []
    for number, recording in enumerate(recordings, 1):
        traces.append(trace(recording, console, mode))
        report(2 * n_games + number, total)
    console.close()
    return Vocabulary.of_games(traces, mode, len(game.controls.buttons), game.clock.max_steps)


def vocabulary_of(data: Path, game: Game, progress: Progress | None = None) -> Vocabulary:
    """Return the vocabulary of a game: the one that ships with Tril, or the data folder's.

    It is made where there is none.

    Args:
        data: The data folder.
        game: The game, as its behaviour sets it.
        progress: See `make_vocabulary`.
    """
    name = f"{vocabulary_key(game)}.npz"
    shipped, path = SHIPPED / name, data / FOLDER / name
    if shipped.exists():
        return Vocabulary.load(shipped)
    if path.exists():
        try:
            return Vocabulary.load(path)
        except Invalid:
            # Damaged, or of another version: it is made anew.
            pass
    words = make_vocabulary(game, progress)
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_suffix(".part")
    words.save(part)
    write_whole(path, part.read_bytes())
    part.unlink()
    return words


def vocabulary_key(game: Game) -> str:
    """Return what names a game's vocabulary: 16 hexadecimal digits of BLAKE2b."""
    content = {
        "format": FORMAT_VERSION,
        "game": game.name,
        "version": game.version,
        "settings": asdict(game.settings),
        "games": [SEED, N_GAMES],
    }
    encoded = json.dumps(content, sort_keys=True, default=str).encode()
    return hashlib.blake2b(encoded, digest_size=8).hexdigest()
