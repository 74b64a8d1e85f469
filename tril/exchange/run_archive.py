"""Reading a run's archive: a zip file that may come from anybody.

Only members of known names are read, each within its size, and nothing is unpacked to a path that
the file names. Networks are safetensors; the pickles that an archive also holds, for
stable-baselines3, are never opened.
"""

from __future__ import annotations

import io
import struct
import warnings
import zipfile
import zlib
from collections.abc import Iterator
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np
from PIL import Image
from safetensors import SafetensorError
from safetensors.numpy import load

from tril.analysis.outcome import AttentionState
from tril.exchange.formats.json_text import decode_json, describe_foreign, parse_json
from tril.exchange.formats.jsonl import MAX_OBJECT_BYTES
from tril.exchange.formats.recording_object import RecordingObject, parse_recording
from tril.exchange.formats.run_file import (
    RUN_FORMAT,
    EvaluationGame,
    PlayedGame,
    RunObject,
    RunRefused,
    parse_run,
)
from tril.recording import RecordingRefused

RUN_FILE = "run.json"
RANKED = "recordings/ranked.jsonl"
UNRANKED = "recordings/perfect.jsonl"
EVALUATION = "recordings/evaluation.jsonl"
NETWORKS = {
    "reward_model": "reward/reward-model.safetensors",
    "imitator": "policy/imitator.safetensors",
    "clone": "policy/clone.safetensors",
}
"""Members that hold networks, by kind of artifact."""

PICTURES = {"attention_map": "", "attention_red_blue": "-red-blue", "attention_frame": "-frame"}
"""Endings of the names of an attention map's pictures, by kind of artifact."""

MAX_MEMBERS = 500
MAX_DIRECTORY_BYTES = 1024 * MAX_MEMBERS
_MB = 2**20
MAX_ARCHIVE_BYTES = 128 * _MB
MAX_JSON_BYTES = 16 * _MB
MAX_NETWORK_BYTES = 32 * _MB
MAX_WEIGHTS_HEADER_BYTES = _MB
MAX_PICTURE_BYTES = _MB
MAX_PICTURE_SIZE = 1024

_UNREADABLE = (
    zipfile.BadZipFile,
    zlib.error,
    struct.error,
    NotImplementedError,
    EOFError,
    OSError,
    ValueError,
)
_END, _END_64 = b"PK\x05\x06", b"PK\x06\x07"
_END_RECORD = struct.Struct("<10xHL6x")
"""The end of a zip: how many members its list has, and the length of the list."""
_MAX_END_BYTES = _END_RECORD.size + 0xFFFF


@dataclass(frozen=True)
class RunArchive:
    """A validated archive; its recordings are not replayed yet.

    Attributes:
        run: All but the following.
        ranked: The recordings of ``run.ranked``, in that order.
        unranked: Those of ``run.unranked``.
        evaluation: Those of ``run.evaluation``.
        networks: Files of networks by kind of artifact.
        pictures: Pictures of attention maps, PNG, by name.
    """

    run: RunObject
    ranked: list[RecordingObject]
    unranked: list[RecordingObject]
    evaluation: list[RecordingObject]
    networks: dict[str, bytes]
    pictures: dict[str, bytes]

    @property
    def demonstrations(self) -> Iterator[tuple[PlayedGame, RecordingObject]]:
        """The recordings that the run was learned from."""
        yield from zip(self.run.ranked, self.ranked, strict=True)
        yield from zip(self.run.unranked, self.unranked, strict=True)

    @property
    def games(self) -> Iterator[tuple[EvaluationGame, RecordingObject]]:
        """The evaluation games."""
        yield from zip(self.run.evaluation, self.evaluation, strict=True)


def picture_name(state: AttentionState, kind: str) -> str:
    """Return the name of an attention map's picture."""
    return f"attention-{state.replace(' ', '-')}{PICTURES[kind]}.png"


def read_archive(file: Path | BinaryIO) -> RunArchive:
    """Read and validate a run's archive.

    Raises:
        RunRefused: It is not one, or something in it is wrong or too large.
    """
    try:
        with file.open("rb") if isinstance(file, Path) else nullcontext(file) as stream:
            if stream.seek(0, io.SEEK_END) > MAX_ARCHIVE_BYTES:
                raise RunRefused(f"The file is too large: at most {MAX_ARCHIVE_BYTES // _MB} MiB.")
            _check_directory(stream)
            with zipfile.ZipFile(stream) as archive:
                return _read(_members(archive), archive)
    except _UNREADABLE as error:
        raise RunRefused(f"The file is not a run that Tril exported: {error}.") from None


def _check_directory(stream: BinaryIO) -> None:
    """Refuse a file that is no zip, or whose list of members takes too much memory.

    zipfile reads all of the list before it tells how long it is.
    """
    stream.seek(0)
    head = stream.read(4096)
    if not head.startswith(b"PK"):
        foreign = describe_foreign(head, RUN_FORMAT) or "no zip file"
        raise RunRefused(
            f"The file is {foreign}. It is not a run that Tril exported (`tril runs export`)."
        )
    size = stream.seek(0, io.SEEK_END)
    stream.seek(max(0, size - _MAX_END_BYTES))
    tail = stream.read(_MAX_END_BYTES)
    end = tail.rfind(_END)
    if end < 0 or len(tail) - end < _END_RECORD.size:
        raise RunRefused("The file is not a run that Tril exported: it is a zip without its end.")
    n_members, directory_bytes = _END_RECORD.unpack_from(tail, end)
    # A zip of 4 GiB or 65,535 members, which Tril does not write, has a second record before it.
    if (
        n_members > MAX_MEMBERS
        or directory_bytes > MAX_DIRECTORY_BYTES
        or tail[:end][-20:].startswith(_END_64)
    ):
        raise RunRefused("The archive has too many members.")


def _members(archive: zipfile.ZipFile) -> dict[str, zipfile.ZipInfo]:
    entries = archive.infolist()
    members = {entry.filename: entry for entry in entries}
    if len(entries) > MAX_MEMBERS or len(members) < len(entries):
        raise RunRefused("The archive has too many members, or several of one name.")
    return members


def _read(members: dict[str, zipfile.ZipInfo], archive: zipfile.ZipFile) -> RunArchive:
    def content(name: str, max_bytes: int) -> bytes:
        entry = members.get(name)
        if entry is None:
            raise RunRefused(f"The archive has no {name}.")
        plain = entry.compress_type in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
        if entry.flag_bits & 0x1 or not plain:
            raise RunRefused(f"{name} is encrypted or compressed in another way than by Tril.")
        if entry.file_size > max_bytes:
            raise RunRefused(f"{name} is too large: at most {max_bytes // _MB} MiB are accepted.")
        with archive.open(entry) as member:
            # Without a number of bytes, all is unpacked before it is cut to the declared size.
            content = member.read(max_bytes)
        if len(content) != entry.file_size:
            raise RunRefused(f"{name} is not as long as it is said to be.")
        return content

    run = parse_run(content(RUN_FILE, MAX_JSON_BYTES))
    networks = {
        kind: _network(name, content(name, MAX_NETWORK_BYTES)) for kind, name in NETWORKS.items()
    }
    names = [
        picture_name(attention_map.state, kind)
        for attention_map in run.attention
        for kind in PICTURES
    ]
    return RunArchive(
        run=run,
        ranked=_recordings(RANKED, content(RANKED, MAX_JSON_BYTES), run.ranked),
        unranked=_recordings(UNRANKED, content(UNRANKED, MAX_JSON_BYTES), run.unranked),
        evaluation=_recordings(EVALUATION, content(EVALUATION, MAX_JSON_BYTES), run.evaluation),
        networks=networks,
        pictures={
            name: _picture(name, content(f"attention/{name}", MAX_PICTURE_BYTES)) for name in names
        },
    )


def _recordings(
    name: str, content: bytes, games: list[PlayedGame] | list[EvaluationGame]
) -> list[RecordingObject]:
    lines = content.splitlines()
    if len(lines) != len(games):
        raise RunRefused(f"{name} has {len(lines)} lines, but {len(games)} recordings are listed.")
    recordings = []
    for line, game in zip(lines, games, strict=True):
        try:
            if len(line) > MAX_OBJECT_BYTES:
                raise RecordingRefused(f"It is longer than {MAX_OBJECT_BYTES} bytes.")
            recording = parse_recording(parse_json(decode_json(line)))
        except (RecordingRefused, ValueError) as error:
            raise RunRefused(f"Recording {game.number} in {name}: {error}") from None
        if len(recording.taken or ()) != len(game.taken_frames):
            raise RunRefused(f"Recording {game.number} in {name} has other items than are listed.")
        recordings.append(recording)
    return recordings


def _network(name: str, content: bytes) -> bytes:
    """Return a file of weights as it is, if all of them are finite numbers."""
    if int.from_bytes(content[:8], "little") > MAX_WEIGHTS_HEADER_BYTES:
        raise RunRefused(f"{name} can't be read as safetensors: its header is too large.")
    try:
        tensors = load(content)
    except (SafetensorError, KeyError, ValueError, AttributeError) as error:
        raise RunRefused(f"{name} can't be read as safetensors: {error}.") from None
    for tensor in tensors.values():
        if tensor.dtype not in (np.float32, np.float16) or not np.isfinite(tensor).all():
            raise RunRefused(f"{name} has weights that are no finite float32 or float16.")
    return content


def _picture(name: str, content: bytes) -> bytes:
    """Return a picture encoded anew, so that nothing but its pixels is kept."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", Image.DecompressionBombWarning)
            picture = Image.open(io.BytesIO(content), formats=["PNG"])
        with picture:
            if max(picture.size) > MAX_PICTURE_SIZE:
                raise RunRefused(f"{name} is too large: {picture.size} pixels.")
            target = io.BytesIO()
            picture.convert("RGB").save(target, format="png", optimize=True)
    except (Image.DecompressionBombError, Image.DecompressionBombWarning):
        raise RunRefused(f"{name} is too large.") from None
    except (OSError, ValueError, SyntaxError) as error:
        raise RunRefused(f"{name} is no picture: {error}.") from None
    return target.getvalue()
