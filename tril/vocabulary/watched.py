"""What a vocabulary sees of a game: its facts in sum and by the second, and where things are."""

from __future__ import annotations

import struct
import zlib
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Self

import numpy as np
import numpy.typing as npt

from tril.games.base import Console
from tril.recording import Recording
from tril.vocabulary.blobs import box_of
from tril.vocabulary.facts import Vocabulary
from tril.vocabulary.formations import FORMATION
from tril.vocabulary.kinds import Array
from tril.vocabulary.moments import Seconds, seconds_of
from tril.vocabulary.pieces import PIECES, Areas, gone_pieces
from tril.vocabulary.trace import Trace, trace

THING_DTYPE = np.dtype(
    [
        ("step", "<i4"),
        ("kind", "u1"),
        ("left", "<i2"),
        ("top", "<i2"),
        ("width", "<i2"),
        ("height", "<i2"),
    ]
)
"""A thing in a step: the index of its kind, PIECES or FORMATION, and its box in pixels."""

Things = npt.NDArray[np.void]
"""Things in order of time, THING_DTYPE (n,)."""

_SIZES = struct.Struct("<II")


@dataclass(frozen=True, eq=False)
class Watched:
    """A game as a vocabulary sees it.

    Attributes:
        summary: Its facts, float32 (n_facts,), as `Vocabulary.summary` returns them.
        packed_seconds: Compressed facts of its seconds.
        packed_things: Compressed things of its steps.
    """

    summary: Array
    packed_seconds: bytes
    packed_things: bytes

    @classmethod
    def of(cls, recording: Recording, console: Console, words: Vocabulary) -> Self:
        """Replay a recording and extract its facts and things.

        Raises:
            RecordingRefused: It was played on another version of the game, or the replay differs.
        """
        played = trace(recording, console, words.scene)
        facts = words.facts(played)
        return cls(
            words.summary(facts),
            zlib.compress(seconds_of(facts, recording.game.clock).tobytes(), 1),
            zlib.compress(things_of(played, words).tobytes(), 1),
        )

    @cached_property
    def seconds(self) -> Seconds:
        """Facts of the game's whole seconds."""
        seconds = np.frombuffer(zlib.decompress(self.packed_seconds), np.float16)
        return seconds.reshape(-1, len(self.summary))

    def things(self, step: int) -> Things:
        """Return the things of a step; none after the game's end."""
        things = np.frombuffer(zlib.decompress(self.packed_things), THING_DTYPE)
        begin, end = np.searchsorted(things["step"], [step, step + 1])
        return things[begin:end]

    def without_things(self) -> Self:
        """Return the game without its things, which take most of the room."""
        return replace(self, packed_things=zlib.compress(b""))

    def pack(self) -> bytes:
        """Return the game as bytes that `unpack` reads."""
        sizes = _SIZES.pack(len(self.summary), len(self.packed_seconds))
        return b"".join([sizes, self.summary.tobytes(), self.packed_seconds, self.packed_things])

    @classmethod
    def unpack(cls, content: bytes) -> Self:
        """Read what `pack` returned."""
        n_facts, n_bytes = _SIZES.unpack_from(content)
        summary = np.frombuffer(content, np.float32, n_facts, _SIZES.size)
        begin = _SIZES.size + summary.nbytes
        return cls(summary, content[begin : begin + n_bytes], content[begin + n_bytes :])


def things_of(played: Trace, words: Vocabulary) -> Things:
    """Return what a game shows in each step: things of kinds, pieces, items of a formation."""
    parts = [np.empty(0, THING_DTYPE)]
    for index, kind in enumerate(words.kinds):
        members = played.blobs[kind.members(played.blobs)]
        part = np.zeros(len(members), THING_DTYPE)
        part["step"], part["kind"] = members["step"], index
        part["left"], part["top"] = box_of(members)
        part["width"], part["height"] = members["width"], members["height"]
        parts.append(part)
    if words.pieces is not None:
        areas = Areas.of(words.pieces)
        gone = gone_pieces(played, words.pieces)
        steps, shown = np.nonzero(areas.are_there(gone.is_gone))
        part = np.zeros(len(steps), THING_DTYPE)
        part["step"], part["kind"] = steps, PIECES
        for column, name in enumerate(("left", "top", "width", "height")):
            part[name] = areas.boxes[shown, column]
        parts.append(part)
    if played.followed is not None:
        followed = played.followed
        steps, shown = np.nonzero(followed.are_there)
        part = np.zeros(len(steps), THING_DTYPE)
        part["step"], part["kind"] = steps, FORMATION
        boxes = followed.formation.boxes[shown]
        part["left"], part["top"] = (boxes[:, :2] + followed.shifts[steps]).T
        part["width"], part["height"] = (boxes[:, 2:] - boxes[:, :2]).T
        parts.append(part)
    things = np.concatenate(parts)
    return things[np.argsort(things["step"], kind="stable")]
