"""Reading a run's archive: a zip file that may come from anybody.

Only members of known names are read, each within its size, and nothing is unpacked to a path that
the file names. Networks are safetensors; the pickles that an archive also holds, for
stable-baselines3, are never opened.
"""

from __future__ import annotations

import io
import json
import zipfile
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from PIL import Image
from safetensors import SafetensorError
from safetensors.numpy import load

from tril.analysis.outcome import AttentionState
from tril.exchange.formats.recording_object import RecordingObject, parse_recording
from tril.exchange.formats.run_file import (
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
_MB = 2**20
MAX_ARCHIVE_BYTES = 128 * _MB
MAX_JSON_BYTES = 16 * _MB
MAX_NETWORK_BYTES = 64 * _MB
MAX_PICTURE_BYTES = _MB
MAX_PICTURE_SIZE = 1024


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
        if isinstance(file, Path) and file.stat().st_size > MAX_ARCHIVE_BYTES:
            raise RunRefused(f"The file is too large: at most {MAX_ARCHIVE_BYTES // _MB} MiB.")
        with zipfile.ZipFile(file) as archive:
            return _read(_members(archive), archive)
    except (zipfile.BadZipFile, zlib.error, NotImplementedError, EOFError, OSError) as error:
        raise RunRefused(f"The file is not a run that Tril exported: {error}.") from None


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
        # Never more than the size that it declares.
        return archive.read(entry)

    run = parse_run(content(RUN_FILE, MAX_JSON_BYTES))
    networks = {
        kind: _network(name, content(name, MAX_NETWORK_BYTES)) for kind, name in NETWORKS.items()
    }
    names = [picture_name(one.state, kind) for one in run.attention for kind in PICTURES]
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
    found = []
    for line, game in zip(lines, games, strict=True):
        try:
            recording = parse_recording(_json(line))
        except (RecordingRefused, ValueError, RecursionError) as error:
            raise RunRefused(f"Recording {game.number} in {name}: {error}") from None
        if len(recording.hits or ()) != len(game.hit_frames):
            raise RunRefused(f"Recording {game.number} in {name} has other hits than are listed.")
        found.append(recording)
    return found


def _json(line: bytes) -> Any:
    return json.loads(line)


def _network(name: str, content: bytes) -> bytes:
    """Return a file of weights as it is, if all of them are finite numbers."""
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
        with Image.open(io.BytesIO(content), formats=["PNG"]) as picture:
            if max(picture.size) > MAX_PICTURE_SIZE:
                raise RunRefused(f"{name} is too large: {picture.size} pixels.")
            target = io.BytesIO()
            picture.convert("RGB").save(target, format="png", optimize=True)
    except (OSError, ValueError, SyntaxError, Image.DecompressionBombError) as error:
        raise RunRefused(f"{name} is no picture: {error}.") from None
    return target.getvalue()
