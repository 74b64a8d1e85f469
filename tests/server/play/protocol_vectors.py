"""Writes tests/data/protocol-vectors.json: one game's messages, which both ends' tests decode.

``python -m tests.server.play.protocol_vectors`` writes it anew; a test holds it against the code.
"""

from __future__ import annotations

import base64
import hashlib
import json
from pathlib import Path
from typing import Any

from server.play.replays.products import frames_file
from server.play.wire.codec import FrameEncoder, palette_json
from server.play.wire.messages import overlay_layout
from server.play.wire.protocol import (
    AckMessage,
    Alive,
    Countdown,
    Ended,
    FrameMessage,
    Hello,
    HitAt,
    HitMessage,
    InputMessage,
    Paused,
    Rewound,
    ServerMessage,
    TakenOver,
    frame_bytes,
)
from testsupport.protocol import client_bytes
from testsupport.space_invaders import Keys, action_for
from tril.games.atari.starts import AtariStart
from tril.games.space_invaders import SPACE_INVADERS
from tril.games.space_invaders.memory import SCREEN_SHAPE
from tril.play.episode import Episode
from tril.recording import Recorder

PATH = Path(__file__).resolve().parents[2] / "data" / "protocol-vectors.json"
SHOWN_FRAMES = (0, 1, 2, 3, 20, 21, 61)
N_FRAMES = 61


def vectors() -> dict[str, Any]:
    """Build the vectors from the code."""
    recorder = Recorder(Episode(SPACE_INVADERS.make_console(), AtariStart(5)))
    encoder = FrameEncoder(SCREEN_SHAPE)
    frames: list[dict[str, Any]] = []
    shots = 0
    console = recorder.episode.console
    for frame in range(N_FRAMES + 1):
        if frame:
            keys = Keys.RIGHT | Keys.FIRE if frame < 30 else Keys.LEFT
            recorder.advance(action_for(keys))
        if frame in SHOWN_FRAMES:
            sequence = len(frames) + 1
            screen = console.screen()
            marks = recorder.episode.readout.marks(recorder.episode.console)
            is_shot, shots = (
                recorder.episode.counters["shots"] > shots,
                recorder.episode.counters["shots"],
            )
            encoded = encoder.encode(screen)
            message = FrameMessage(sequence, frame, 100 + frame, encoded, marks, is_shot)
            frames.append(
                {
                    "base64": _base64(frame_bytes(message)),
                    "key": message.encoded.is_key,
                    "sequence": sequence,
                    "frame": frame,
                    "input_sequence": 100 + frame,
                    "formation": {"left": marks[0] - 96, "top": marks[1]},
                    "shot": is_shot,
                    "screen_sha256": hashlib.sha256(screen.tobytes()).hexdigest(),
                }
            )
    file = frames_file(recorder.recording(), console)
    return {
        "about": "Written by python -m tests.server.play.protocol_vectors; see docs/protocol.md.",
        "palette": palette_json(SPACE_INVADERS.screen),
        "frames": frames,
        "client": [
            {
                "message": {"type": "input", "keys": int(keys), "sequence": sequence},
                "base64": _base64(client_bytes(InputMessage(int(keys), sequence))),
            }
            for sequence, keys in enumerate(
                (Keys(0), Keys.LEFT, Keys.RIGHT, Keys.FIRE, Keys.LEFT | Keys.FIRE), start=1
            )
        ]
        + [
            {
                "message": {"type": "ack", "sequence": sequence},
                "base64": _base64(client_bytes(AckMessage(sequence))),
            }
            for sequence in (1, 65_536, 2**32 - 1)
        ]
        + [
            {
                "message": {"type": "ack", "sequence": 8, "latency_ms": latency_ms},
                "base64": _base64(client_bytes(AckMessage(8, latency_ms))),
            }
            for latency_ms in (0.1, 31.5, 6553.5)
        ],
        "server": [json.loads(message.to_json()) for message in _server_messages()],
        "frames_file": {
            "base64": _base64(file),
            "n_frames": N_FRAMES,
            "screen_sha256": {str(shown["frame"]): shown["screen_sha256"] for shown in frames},
        },
    }


def _server_messages() -> list[ServerMessage]:
    hit = HitAt(row=0, column=4, frame=95, on_target=True)
    stray = HitAt(row=1, column=0, frame=130, on_target=False)
    return [
        Hello(
            palette=[[0, 0, 0]] * 256,
            width=160,
            height=210,
            frame_rate_hz=60,
            max_frames=1200,
            frame=96,
            epoch=2,
            resumed=True,
            hits=[hit],
            speed_percent=50,
            game="space_invaders",
            overlay=overlay_layout(SPACE_INVADERS),
        ),
        Countdown(seconds=3),
        Countdown(seconds=0),
        HitMessage(**stray.model_dump(), targets=1, strays=1),
        Paused(why="You paused the game."),
        Rewound(frame=100, hits=[hit], recording_id=6),
        Ended(
            reason="hit",
            frame=140,
            hits=[hit, stray],
            targets=1,
            strays=1,
            order_errors=0,
            recording_id=7,
            verification="verified",
            verification_note="",
        ),
        TakenOver(),
        Alive(),
    ]


def _base64(data: bytes) -> str:
    return base64.b64encode(data).decode("ascii")


if __name__ == "__main__":
    PATH.parent.mkdir(exist_ok=True)
    PATH.write_text(json.dumps(vectors(), separators=(",", ":")) + "\n")
