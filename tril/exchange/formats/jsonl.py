"""Read files of recordings, one object or JSON Lines, within limits."""

from __future__ import annotations

import codecs
import json
from collections.abc import Iterator
from dataclasses import dataclass
from io import BytesIO
from typing import BinaryIO

from tril.exchange.formats import action_list
from tril.exchange.formats.json_text import decode_json, describe_foreign, parse_json
from tril.exchange.formats.recording_object import FORMAT, truncated

MAX_OBJECT_BYTES = 64 * 1024
"""Maximum size of a recording that Tril wrote, as UTF-8."""
MAX_LINE_BYTES = 2 * 2**20
"""Maximum size of a recording in a file: an action list with names takes 20 bytes a frame."""
MAX_OBJECTS = 10_000
"""Maximum number of recordings in a file."""
EXPECTED = "Tril imports recordings as JSON, one object or one per line (docs/exchange-format.md)."


@dataclass(frozen=True)
class JsonLine:
    """One object of a file.

    Attributes:
        number: First line of the object, counted from 1.
        content: The parsed JSON, None if refused.
        refusal: The reason for a refusal, None otherwise.
    """

    number: int
    content: object | None
    refusal: str | None = None


def read_lines(
    file: BinaryIO | bytes | str,
    max_object_bytes: int = MAX_LINE_BYTES,
    max_objects: int = MAX_OBJECTS,
) -> Iterator[JsonLine]:
    """Read a file with one recording, or with one in each line (JSON Lines).

    Args:
        file: A file opened for reading bytes, or its content.
        max_object_bytes: Longer lines are refused unread.
        max_objects: Further recordings are refused unread.

    Yields:
        Each object or refused line; blank lines are skipped. A file of another kind is one refusal.
    """
    if isinstance(file, str):
        file = file.encode()
    stream = BytesIO(file) if isinstance(file, bytes) else file
    head = stream.read(max_object_bytes + 1)
    if (foreign := describe_foreign(head, FORMAT, action_list.FORMAT)) is not None:
        yield JsonLine(1, None, f"The file is {foreign}. {EXPECTED}")
        return
    try:
        yield from _read(head, stream, max_object_bytes, max_objects)
    except UnicodeError as error:
        yield JsonLine(1, None, f"The file is damaged: {error}.")


def _read(
    head: bytes, stream: BinaryIO, max_object_bytes: int, max_objects: int
) -> Iterator[JsonLine]:
    pieces = _pieces(head, stream, max_object_bytes + 1)
    head = b""
    while len(head) <= max_object_bytes and (piece := next(pieces, b"")):
        head += piece
    if len(head) <= max_object_bytes and (json_object := _one_object(head)):
        yield json_object
        return
    n_objects = 0
    for number, text in _lines(head, pieces, max_object_bytes):
        if text is not None and not text.strip():
            continue
        if n_objects == max_objects:
            yield JsonLine(
                number, None, f"The file has more than {max_objects} recordings. Split it."
            )
            return
        n_objects += 1
        if text is None:
            yield JsonLine(number, None, f"The line is longer than {max_object_bytes} bytes.")
        else:
            yield _parsed(number, text)
    if not n_objects:
        yield JsonLine(1, None, "The file has no recordings.")


def _one_object(head: bytes) -> JsonLine | None:
    """Return the only object of a file, which may span lines, None if there are several."""
    first = len(head) - len(head.lstrip())
    line = _parsed(1 + head[:first].count(b"\n"), head)
    if line.refusal is None:
        return line
    lines = [line for line in head.splitlines() if line.strip()]
    looks_like_one = head.lstrip().startswith(b"{") and len(lines) > 1
    if looks_like_one and all(_parsed(1, line).refusal for line in lines):
        return line
    return None


def _pieces(head: bytes, stream: BinaryIO, size: int) -> Iterator[bytes]:
    """Yield a stream in pieces of UTF-8, whatever its encoding; raises UnicodeError."""
    encoding = json.detect_encoding(head)
    # A mark of UTF-8 may stand before any line: files are joined.
    is_utf8 = encoding.startswith("utf-8")
    decoder = None if is_utf8 else codecs.getincrementaldecoder(encoding)()
    while head:
        if piece := head if decoder is None else decoder.decode(head).encode():
            yield piece
        head = stream.read(size)
    if decoder is not None:
        decoder.decode(b"", final=True)


def _lines(head: bytes, pieces: Iterator[bytes], limit: int) -> Iterator[tuple[int, bytes | None]]:
    """Yield the number and content of each line; None for a line that is too long."""
    number, remainder, too_long = 1, head, False
    while True:
        *complete_lines, remainder = remainder.split(b"\n")
        for line in complete_lines:
            yield number, None if too_long or len(line) > limit else line
            number, too_long = number + 1, False
        if len(remainder) > limit:
            too_long, remainder = True, b""
        piece = next(pieces, b"")
        if not piece:
            if remainder or too_long:
                yield number, None if too_long else remainder
            return
        remainder += piece


def _parsed(number: int, text: bytes) -> JsonLine:
    try:
        content = parse_json(decode_json(text))
    except json.JSONDecodeError as error:
        line = number + error.lineno - 1
        return JsonLine(line, None, f"Not JSON: {error.msg} at character {error.colno}.")
    except ValueError as error:
        return JsonLine(number, None, f"The recording can't be read: {error}.")
    if not isinstance(content, dict):
        value = truncated(repr(content))
        return JsonLine(number, None, f"Expected one JSON object per line, got {value}.")
    return JsonLine(number, content)
