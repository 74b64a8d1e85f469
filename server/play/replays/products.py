"""What a replay of a recording yields: frames, a thumbnail, memory, observations, its end."""

from __future__ import annotations

import io
import json
import struct
import zlib

import numpy as np
from PIL import Image

from server.play.wire.codec import FLAG_KEY, FrameEncoder, palette_json
from tril.errors import NotFound
from tril.games.base import Console, Screen
from tril.play.episode import Episode
from tril.play.observation import SIZE, STACK, Observation, Observations
from tril.recording import Recording, replay, trajectory

MAGIC = b"TRILFRM1"
KEY_EVERY_FRAMES = 60
_LENGTH = struct.Struct("<I")
_FRAME = struct.Struct("<IB")


def frames_file(recording: Recording, console: Console | None = None) -> bytes:
    """Return every frame of a recording, the start's first, as docs/protocol.md describes."""
    game = recording.game
    encoder = FrameEncoder(game.screen.shape)
    parts: list[bytes] = []

    def add_frame(episode: Episode) -> None:
        frame = encoder.encode(episode.console.screen(), key=episode.frame % KEY_EVERY_FRAMES == 0)
        parts.append(_FRAME.pack(len(frame.payload), FLAG_KEY * frame.is_key) + frame.payload)

    played = replay(recording, console, add_frame)
    header = json.dumps(
        {
            "width": game.screen.width,
            "height": game.screen.height,
            "palette": palette_json(game.screen),
            "frame_rate_hz": game.clock.frame_rate_hz,
            "n_frames": played.n_frames,
            "key_every": KEY_EVERY_FRAMES,
        },
        separators=(",", ":"),
    ).encode()
    return b"".join([MAGIC, _LENGTH.pack(len(header)), header, *parts])


def thumbnail_png(recording: Recording, console: Console | None = None) -> bytes:
    """Return a PNG of the screen after the last item taken, or else of the last frame."""
    screen: Screen = np.zeros(recording.game.screen.shape, np.uint8)
    n_taken = 0

    def keep_screen(episode: Episode) -> None:
        nonlocal n_taken
        is_last = episode.frame == recording.n_frames or episode.end is not None
        if len(episode.taken) > n_taken or (is_last and not n_taken):
            n_taken = len(episode.taken)
            episode.console.screen(screen)

    replay(recording, console, keep_screen)
    file = io.BytesIO()
    palette = recording.game.screen.palette
    picture = screen if palette is None else palette[screen]
    image = Image.fromarray(picture).quantize(256, dither=Image.Dither.NONE)
    image.save(file, "PNG", optimize=True)
    return file.getvalue()


def memory_file(recording: Recording, console: Console | None = None) -> bytes:
    """Return the memory at the start and after every frame, as many bytes each."""
    memory: list[bytes] = []
    replay(recording, console, lambda episode: memory.append(episode.console.ram_bytes()))
    return b"".join(memory)


def observations_file(recording: Recording, console: Console | None = None) -> bytes:
    """Return a recording's observations: the newest screen of each, uint8 (T + 1, 84, 84), zlib."""
    newest = trajectory(recording, console).observations[:, -1]
    return zlib.compress(np.ascontiguousarray(newest).tobytes(), level=1)


def read_observations(content: bytes) -> Observations:
    """Return the observations, uint8 (T + 1, 4, 84, 84), of a file.

    The older screens of an observation are the newest ones of the observations before; those of the
    start are all alike.
    """
    newest = np.frombuffer(zlib.decompress(content), np.uint8).reshape(-1, SIZE, SIZE)
    steps = np.arange(len(newest))[:, None] + np.arange(1 - STACK, 1)
    return np.asarray(newest[np.maximum(steps, 0)], np.uint8)


def read_observation(content: bytes, step: int) -> Observation:
    """Return one of the observations of a file, uint8 (4, 84, 84); see ``read_observations``.

    Raises:
        NotFound: The recording ends before this step.
    """
    newest = np.frombuffer(zlib.decompress(content), np.uint8).reshape(-1, SIZE, SIZE)
    if step >= len(newest):
        raise NotFound(f"The recording ends at step {len(newest) - 1}.")
    return np.asarray(newest[np.maximum(step + np.arange(1 - STACK, 1), 0)], np.uint8)
