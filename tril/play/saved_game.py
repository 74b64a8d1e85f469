"""Serialisation of a saved AgentGame without pickle."""

import json
import struct
import zlib
from typing import Any

from tril.games.base import Console, Taken
from tril.play.agent import AgentGameState
from tril.play.episode import EpisodeState
from tril.play.observation import AgentViewState

_VERSION = 2
_FIRST_VERSION = 1
"""Of Space Invaders alone; trainings that began before have it in their checkpoints."""

_HEADER = struct.Struct("<B5I")


def pack_game(state: AgentGameState) -> bytes:
    """Return the state as bytes, 10 to 15 kB."""
    episode, view = state.episode, state.view
    small = {
        "start": episode.start.to_json(),
        "taken": [[item.row, item.column, item.frame] for item in episode.taken],
        "end": episode.end,
        "counters": episode.counters,
        "readout": episode.readout,
    }
    parts = (
        json.dumps(small).encode(),
        episode.actions,
        episode.console.to_bytes(),
        zlib.compress(view.observation, 1),
        b"" if view.first is None else zlib.compress(view.first, 1),
    )
    return _HEADER.pack(_VERSION, *map(len, parts)) + b"".join(parts)


def unpack_game(data: bytes, console: Console) -> AgentGameState:
    """Read a state that `pack_game` wrote, of the console's game.

    Raises:
        ValueError: the bytes are of another format version.
    """
    version, *sizes = _HEADER.unpack_from(data)
    if version not in {_FIRST_VERSION, _VERSION}:
        raise ValueError(f"Expected saved game version {_VERSION}, got {version}.")
    parts = []
    begin = _HEADER.size
    for size in sizes:
        parts.append(data[begin : begin + size])
        begin += size
    text, actions, machine, observation, first = parts
    small = json.loads(text)
    if version == _FIRST_VERSION:
        small = _upgraded(small)
    episode = EpisodeState(
        console=console.state_from_bytes(machine),
        start=console.game.starts.parse(small["start"]),
        actions=actions,
        taken=tuple(Taken(*item) for item in small["taken"]),
        end=small["end"],
        counters=small["counters"],
        readout=small["readout"],
    )
    view = AgentViewState(zlib.decompress(observation), zlib.decompress(first) if first else None)
    return AgentGameState(episode, view)


def _upgraded(small: dict[str, Any]) -> dict[str, Any]:
    readout = ("lives", "missile_in_air", "alien_rows", "shifts", "alien_x")
    return {
        "start": dict(zip(("idle_frames", "mode", "difficulty"), small["start"], strict=True)),
        "taken": small["hits"],
        "end": small["end"],
        "counters": {"shots": small["shots"]},
        "readout": {name: small[name] for name in readout},
    }
