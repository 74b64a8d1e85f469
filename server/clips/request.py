"""The request to the process that makes a clip."""

from __future__ import annotations

import json
from enum import StrEnum

from tril.exchange.formats.recording_file import dump_recording, load_recording
from tril.recording import Recording


class ClipKind(StrEnum):
    """The formats of clips."""

    GIF = "gif"
    WEBP = "webp"
    MP4 = "mp4"


MEDIA_TYPES = {
    ClipKind.GIF: "image/gif",
    ClipKind.WEBP: "image/webp",
    ClipKind.MP4: "video/mp4",
}


def write_request(recording: Recording, kind: ClipKind) -> bytes:
    """Encode a request: the recording in the exchange format, and the kind."""
    return json.dumps({"kind": kind, "recording": dump_recording(recording)}).encode()


def read_request(content: bytes) -> tuple[Recording, ClipKind]:
    """Decode a request and verify its recording by a replay.

    Raises:
        RecordingRefused: The replay differs from what was recorded.
    """
    request = json.loads(content)
    return load_recording(request["recording"]).recording, ClipKind(request["kind"])
