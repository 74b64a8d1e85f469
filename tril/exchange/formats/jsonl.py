"""Files of recordings: one object, or JSON Lines, read within limits."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from io import BytesIO
from typing import BinaryIO

from tril.exchange.formats.recording_object import shortened

MAX_OBJECT_BYTES = 64 * 1024
"""Longest recording in the exchange format, as UTF-8: one line, or one file with one object."""
MAX_OBJECTS = 10_000
"""Most recordings in one file."""


@dataclass(frozen=True)
class Line:
    """One object of a file.

    Attributes:
        number: The line it begins in, counted from 1.
        content: The parsed JSON, for from_exchange; None if it was refused.
        refusal: Why it was refused, None if it wasn't.
    """

    number: int
    content: object | None
    refusal: str | None = None


def read_lines(
    file: BinaryIO | bytes | str,
    max_object_bytes: int = MAX_OBJECT_BYTES,
    max_objects: int = MAX_OBJECTS,
) -> Iterator[Line]:
    """Read a file with one recording, or with one in each line (JSON Lines).

    Args:
        file: A file opened for reading bytes, or its content.
        max_object_bytes: Lines that are longer are refused, unread.
        max_objects: What follows so many recordings is refused, unread.

    Yields:
        Each object with its line, or why that line was refused; blank lines are passed over.
    """
    if isinstance(file, str):
        file = file.encode()
    stream = BytesIO(file) if isinstance(file, bytes) else file
    head = stream.read(max_object_bytes + 1)
    if len(head) <= max_object_bytes and (whole := _one_object(head)):
        yield whole
        return
    found = 0
    for number, text in _lines(head, stream, max_object_bytes):
        if text is not None and not text.strip():
            continue
        if found == max_objects:
            yield Line(number, None, f"More than {max_objects} recordings; split the file.")
            return
        found += 1
        if text is None:
            yield Line(number, None, f"Longer than {max_object_bytes} bytes.")
        else:
            yield _parsed(number, text)
    if not found:
        yield Line(1, None, "There is no recording in it.")


def _one_object(head: bytes) -> Line | None:
    """The object of a file that holds a single one, which may span lines; None otherwise."""
    first = len(head) - len(head.lstrip())
    whole = _parsed(1 + head[:first].count(b"\n"), head)
    if whole.refusal is None:
        return whole
    lines = [line for line in head.splitlines() if line.strip()]
    looks_like_one = head.lstrip().startswith(b"{") and len(lines) > 1
    if looks_like_one and all(_parsed(1, line).refusal for line in lines):
        return whole
    return None


def _lines(head: bytes, stream: BinaryIO, limit: int) -> Iterator[tuple[int, bytes | None]]:
    """Number and content of each line of head and what follows it; None for one that's too long."""
    number, rest, too_long = 1, head, False
    while True:
        *whole, rest = rest.split(b"\n")
        for line in whole:
            yield number, None if too_long or len(line) > limit else line
            number, too_long = number + 1, False
        if len(rest) > limit:
            too_long, rest = True, b""
        more = stream.read(limit + 1)
        if not more:
            if rest or too_long:
                yield number, None if too_long else rest
            return
        rest += more


def _parsed(number: int, text: bytes) -> Line:
    try:
        content = json.loads(text.decode("utf-8-sig"), parse_constant=_refuse_constant)
    except UnicodeDecodeError as error:
        return Line(number, None, f"Not UTF-8: {error.reason} at byte {error.start}.")
    except json.JSONDecodeError as error:
        line = number + error.lineno - 1
        return Line(line, None, f"Not JSON: {error.msg} at character {error.colno}.")
    except RecursionError:
        return Line(number, None, "Not a recording: nested too deeply.")
    except ValueError as error:
        return Line(number, None, f"Not JSON: {error}.")
    if not isinstance(content, dict):
        got = shortened(repr(content))
        return Line(number, None, f"Expected one JSON object per line, got {got}.")
    return Line(number, content)


def _refuse_constant(name: str) -> object:
    raise ValueError(f"{name} is no JSON number")
