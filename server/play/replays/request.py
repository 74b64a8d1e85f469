"""Requests to the replay process and their answers. Pure."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from server.play.replays.products import (
    frames_file,
    memory_file,
    observations_file,
    thumbnail_png,
)
from tril.demonstrators.varied import play_varied
from tril.exchange.formats.recording_file import ImportedRecording, load_recording
from tril.games import game_named
from tril.games.base import Cell, Console
from tril.games.measures import Measure
from tril.games.measuring import Values
from tril.play.consoles import Consoles
from tril.recording import Recording, Verified, verify


class ReplayTask(StrEnum):
    """What to replay a recording for; the value is a product's file name extension."""

    CHECK = "check"
    FRAMES = "frames"
    THUMBNAIL = "png"
    MEMORY = "ram"
    OBSERVATIONS = "obs"


@dataclass(frozen=True)
class Request:
    """A request for a replay.

    Attributes:
        task: What to replay the recording for.
        recording: The recording.
        taken: For a check, the items that it is said to take, in order of time.
    """

    task: ReplayTask
    recording: Recording
    taken: tuple[Cell, ...] = ()


@dataclass(frozen=True)
class VariedPlayRequest:
    """A request for a game of varied play.

    Attributes:
        game: Name of the game.
        seed: Seed of all that is drawn for it.
    """

    game: str
    seed: int


@dataclass(frozen=True)
class LoadRequest:
    """A request to load a recording from the exchange format and verify it.

    Attributes:
        content: Parsed JSON.
    """

    content: object


@dataclass(frozen=True)
class MeasureRequest:
    """A request to measure a recording in a replay.

    Attributes:
        recording: The recording.
        measures: What to measure.
    """

    recording: Recording
    measures: tuple[Measure, ...]


AnyRequest = Request | VariedPlayRequest | LoadRequest | MeasureRequest
Content = bytes | Verified | ImportedRecording | Values


@dataclass(frozen=True)
class Answer:
    """The answer to a request.

    Attributes:
        content: The product, empty for a check; or the game that was played, or loaded; or values
            of measures.
        refusal: Why the recording does not replay; None if it does.
        unknown_game: That its game is not installed; None if it is.
        failure: A traceback, if something else went wrong.
    """

    content: Content = b""
    refusal: str | None = None
    unknown_game: str | None = None
    failure: str | None = None


_PRODUCTS: Mapping[ReplayTask, Callable[[Recording, Console], bytes]] = {
    ReplayTask.FRAMES: frames_file,
    ReplayTask.THUMBNAIL: thumbnail_png,
    ReplayTask.MEMORY: memory_file,
    ReplayTask.OBSERVATIONS: observations_file,
}


def execute(request: AnyRequest, consoles: Consoles) -> Content:
    """Replay a recording and return the product, nothing for a passed check; or play or load one.

    Values are returned for a request to measure.

    Raises:
        RecordingRefused: The replay differs from what was recorded.
    """
    if isinstance(request, VariedPlayRequest):
        return play_varied(
            np.random.default_rng(request.seed), consoles.of(game_named(request.game))
        )
    if isinstance(request, LoadRequest):
        return load_recording(request.content, consoles)
    console = consoles.of(request.recording.game)
    if isinstance(request, MeasureRequest):
        verified = verify(request.recording, console=console, measures=request.measures)
        return verified.replay.measured
    if request.task is ReplayTask.CHECK:
        verify(request.recording, request.taken, console)
        return b""
    return _PRODUCTS[request.task](request.recording, console)
