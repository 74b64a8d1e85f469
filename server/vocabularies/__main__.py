"""Makes one vocabulary and its pictures; ends when its standard input is closed.

Standard input has the pickled data folder and game, which is safe between a process and the one
that it started, and stays open while the server lives. Each line of standard output is the share
of what is done.
"""

from __future__ import annotations

import os
import pickle
import signal
import sys
import threading
from collections.abc import Callable
from pathlib import Path

# Before the heavy imports, so that games come first.
os.nice(19)

from tril.games.base import Game  # noqa: E402
from tril.vocabulary.making import (  # noqa: E402
    pictures_path,
    varied_games,
    vocabulary_of,
)
from tril.vocabulary.pictures import MOST_GAMES, pictures_of, write_pictures  # noqa: E402

VOCABULARY_SHARE = 0.9
"""The share of the time that the vocabulary takes; the pictures take the rest."""


def main() -> None:
    """Make what is asked for."""
    # Ctrl-C reaches all processes of a terminal; this one ends with the server.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    data, game = pickle.load(sys.stdin.buffer)
    threading.Thread(target=_end_with_server, daemon=True).start()
    lines = sys.stdout
    # Keep other output, the emulator's for one, out of the lines.
    sys.stdout = sys.stderr

    def report(share: float) -> None:
        print(f"{share:.3f}", file=lines, flush=True)

    make(data, game, report)


def make(data: Path, game: Game, report: Callable[[float], None]) -> None:
    """Make a game's vocabulary and pictures of its things, unless they are there.

    Args:
        data: The data folder.
        game: The game.
        report: Told the share of what is done.
    """
    words = vocabulary_of(data, game, lambda done, total: report(VOCABULARY_SHARE * done / total))
    path = pictures_path(data, game)
    if not path.exists():
        report(VOCABULARY_SHARE)
        console = game.make_console()
        write_pictures(path, pictures_of(words, varied_games(game, MOST_GAMES), console))
        console.close()
    report(1.0)


def _end_with_server() -> None:
    # Nothing more is written to it: reading ends when the server closes it, or is killed. Not by
    # sys.stdin, whose lock this thread would hold while the interpreter ends.
    while os.read(0, 1):
        pass
    os._exit(1)


if __name__ == "__main__":
    main()
