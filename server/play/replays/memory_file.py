"""The console's memory at every frame of a recording, for those who look into a game."""

from __future__ import annotations

import numpy as np

from tril.game import space_invaders as game
from tril.game.console import Console
from tril.game.episode import Episode
from tril.recording import Recording, replay


def memory_file(recording: Recording, console: Console | None = None) -> bytes:
    """Return the RAM at the start and after every frame: uint8 (n_frames + 1, 128), row by row.

    Args:
        recording: What to replay.
        console: The console to replay on; None loads one.
    """
    memory = np.zeros((recording.n_frames + 1, game.RAM_SIZE), np.uint8)

    def look(episode: Episode) -> None:
        memory[episode.frame] = np.frombuffer(episode.console.ram_bytes(), np.uint8)

    played = replay(recording, console, look)
    return memory[: played.n_frames + 1].tobytes()
