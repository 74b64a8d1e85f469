"""What can be made of a recording by replaying it. Pure."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import StrEnum

from server.play.replays.memory_file import memory_file
from server.play.wire.frames_file import frames_file, thumbnail_png
from tril.game.console import Console
from tril.recording import Recording, verify


class Wanted(StrEnum):
    """What a replay is for."""

    CHECK = "check"
    FRAMES = "frames"
    THUMBNAIL = "png"
    MEMORY = "ram"


@dataclass(frozen=True)
class Request:
    """A replay that is asked for.

    Attributes:
        wanted: What it is for.
        recording: What to replay.
        hits: For a check, the (row, column) of the aliens that it is said to hit, in order of time.
    """

    wanted: Wanted
    recording: Recording
    hits: tuple[tuple[int, int], ...] = ()


_MADE: Mapping[Wanted, Callable[[Recording, Console], bytes]] = {
    Wanted.FRAMES: frames_file,
    Wanted.THUMBNAIL: thumbnail_png,
    Wanted.MEMORY: memory_file,
}


def carry_out(request: Request, console: Console) -> bytes:
    """Replay a recording and return what is wanted; nothing for a check that is passed.

    Raises:
        RecordingRefused: It does not replay to what was recorded.
    """
    if request.wanted is Wanted.CHECK:
        verify(request.recording, request.hits, console)
        return b""
    return _MADE[request.wanted](request.recording, console)
