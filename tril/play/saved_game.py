"""Serialisation of a saved AgentGame without pickle."""

import json
import struct
import zlib

from tril.games.atari.console import ConsoleState
from tril.games.space_invaders.grid import AlienGridState
from tril.play.agent import AgentGameState
from tril.play.episode import EndReason, EpisodeState, Hit, Start
from tril.play.observation import AgentViewState

_VERSION = 1
_HEADER = struct.Struct("<B5I")


def pack_game(state: AgentGameState) -> bytes:
    """Return the state as bytes, 10 to 15 kB."""
    episode, view = state.episode, state.view
    small = {
        "start": [episode.start.idle_frames, episode.start.mode, episode.start.difficulty],
        "hits": [[hit.row, hit.column, hit.frame] for hit in episode.hits],
        "end": episode.end,
        "shots": episode.shots,
        "lives": episode.lives,
        "missile_in_air": episode.missile_in_air,
        "alien_rows": episode.aliens.rows,
        "shifts": episode.aliens.shifts,
        "alien_x": episode.aliens.alien_x,
    }
    parts = (
        json.dumps(small).encode(),
        episode.actions,
        episode.console.to_bytes(),
        zlib.compress(view.observation, 1),
        b"" if view.first is None else zlib.compress(view.first, 1),
    )
    return _HEADER.pack(_VERSION, *map(len, parts)) + b"".join(parts)


def unpack_game(data: bytes) -> AgentGameState:
    """Read a state that `pack_game` wrote.

    Raises:
        ValueError: the bytes are of another format version.
    """
    version, *sizes = _HEADER.unpack_from(data)
    if version != _VERSION:
        raise ValueError(f"Expected saved game version {_VERSION}, got {version}.")
    parts = []
    begin = _HEADER.size
    for size in sizes:
        parts.append(data[begin : begin + size])
        begin += size
    text, actions, console, observation, first = parts
    small = json.loads(text)
    episode = EpisodeState(
        console=ConsoleState.from_bytes(console),
        start=Start(*small["start"]),
        actions=actions,
        hits=tuple(Hit(*hit) for hit in small["hits"]),
        end=None if small["end"] is None else EndReason(small["end"]),
        shots=small["shots"],
        lives=small["lives"],
        missile_in_air=small["missile_in_air"],
        aliens=AlienGridState(tuple(small["alien_rows"]), small["shifts"], small["alien_x"]),
    )
    view = AgentViewState(zlib.decompress(observation), zlib.decompress(first) if first else None)
    return AgentGameState(episode, view)
