"""What is asked of the process that makes a clip, and how it travels there."""

from __future__ import annotations

import json
from enum import StrEnum

from tril.exchange.formats.recording_file import dump_recording, load_recording
from tril.recording import Recording


class ClipKind(StrEnum):
    """What a recording can be made into."""

    GIF = "gif"
    WEBP = "webp"
    MP4 = "mp4"


MEDIA_TYPES = {
    ClipKind.GIF: "image/gif",
    ClipKind.WEBP: "image/webp",
    ClipKind.MP4: "video/mp4",
}


def write_request(recording: Recording, kind: ClipKind) -> bytes:
    """Return what `read_request` reads: the recording in the exchange format, and the kind."""
    return json.dumps({"kind": kind, "recording": dump_recording(recording)}).encode()


def read_request(content: bytes) -> tuple[Recording, ClipKind]:
    """Return the recording, verified by a replay, and what to make of it.

    Raises:
        RecordingRefused: Its replay differs from what was recorded.
    """
    given = json.loads(content)
    return load_recording(given["recording"]).recording, ClipKind(given["kind"])
