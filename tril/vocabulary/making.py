"""Making the vocabulary of a game from varied play, once, and keeping it in the data folder."""

from __future__ import annotations

import errno
import fcntl
import hashlib
import json
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path

import numpy as np

from tril.demonstrators.random_play import play_randomly
from tril.errors import Invalid
from tril.files.artifact_store import write_whole
from tril.games.base import Console, Game, Screen
from tril.recording import Recording
from tril.vocabulary.blobs import Background
from tril.vocabulary.facts import FORMAT_VERSION, Vocabulary
from tril.vocabulary.formations import alike_things, moving_formation, without_formation
from tril.vocabulary.trace import Scene, count_background, follow, trace

N_GAMES = 40
N_FOLLOWED = 16
"""Games in which it is looked whether alike things move together."""
SEED = 20_261_128
FOLDER = "vocabularies"
SHIPPED = Path(__file__).with_name("shipped")
"""Vocabularies of games as they are without settings, made by `tril games prepare`."""
LOCK_POLL_S = 0.5

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
    n_games, n_followed = N_GAMES, min(N_FOLLOWED, N_GAMES)
    total = 3 * n_games + n_followed

    def report(done: int, _total: int) -> None:
        if progress:
            progress(done, total)

    recordings = varied_games(game, n_games, report)
    console = game.make_console()
    shape = (game.screen.height, game.screen.width)
    background, beginning = Background(shape), Background(shape)
    for number, recording in enumerate(recordings, 1):
        count_background(recording, console, background, beginning)
        report(n_games + number, total)
    scene = _scene(
        background.mode(),
        beginning.mode(),
        recordings[:n_followed],
        console,
        lambda done, _: report(2 * n_games + done, total),
    )
    traces = []
    for number, recording in enumerate(recordings, 1):
        traces.append(trace(recording, console, scene))
        report(total - n_games + number, total)
    console.close()
    return Vocabulary.of_games(
        traces, scene, game.controls.buttons, game.clock.max_steps, game.things
    )


def _scene(
    background: Screen,
    beginning: Screen,
    recordings: Sequence[Recording],
    console: Console,
    progress: Progress,
) -> Scene:
    """Return what screens have in common, with the formation that some games show, if any."""
    candidate = alike_things(beginning)
    if candidate is None:
        return Scene(background, beginning)
    games = []
    for number, recording in enumerate(recordings, 1):
        games.append(follow(recording, console, candidate))
        progress(number, len(recordings))
    formation = moving_formation(candidate, games)
    if formation is None:
        return Scene(background, beginning)
    return Scene(without_formation(background, beginning, formation, games), beginning, formation)


def vocabulary_of(data: Path, game: Game, progress: Progress | None = None) -> Vocabulary:
    """Return the vocabulary of a game: the one that ships with Tril, or the data folder's.

    It is made where there is none.

    Args:
        data: The data folder.
        game: The game, as its behaviour sets it.
        progress: See `make_vocabulary`.
    """
    path = vocabulary_path(data, game)
    if (kept := _kept(path)) is not None:
        return kept
    with _made_alone(path.parent, progress):
        # Another process may have made it meanwhile.
        if (kept := _kept(path)) is not None:
            return kept
        words = make_vocabulary(game, progress)
        part = path.with_suffix(".part")
        words.save(part)
        write_whole(path, part.read_bytes())
        part.unlink()
    return words


def vocabulary_path(data: Path, game: Game) -> Path:
    """Return the file of a game's vocabulary: the one that ships with Tril, or where it is kept."""
    name = f"{vocabulary_key(game)}.npz"
    shipped = SHIPPED / name
    return shipped if shipped.exists() else data / FOLDER / name


def pictures_path(data: Path, game: Game) -> Path:
    """Return the file in the data folder that has the pictures of a game's things."""
    return data / FOLDER / f"{vocabulary_key(game)}.pictures.zip"


def _kept(path: Path) -> Vocabulary | None:
    """Return a vocabulary that was made before; None if it is damaged, or there is none."""
    try:
        return Vocabulary.load(path)
    except Invalid:
        return None


@contextmanager
def _made_alone(folder: Path, progress: Progress | None) -> Iterator[None]:
    """Hold the folder's lock for the block: each vocabulary takes a core for a minute."""
    folder.mkdir(parents=True, exist_ok=True)
    with (folder / "making.lock").open("a") as lock:
        while True:
            try:
                # Not flock: its lock would pass on to processes that inherit the descriptor.
                fcntl.lockf(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
                break
            except OSError as problem:
                if problem.errno not in {errno.EAGAIN, errno.EACCES}:
                    raise
            if progress:
                progress(0, 1)
            time.sleep(LOCK_POLL_S)
        yield


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
