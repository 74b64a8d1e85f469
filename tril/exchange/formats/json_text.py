"""JSON of files from anybody: its encoding, its bounds, and what a file is that has none."""

from __future__ import annotations

import json
import re
from typing import Any

MAX_VALUES = 2_000_000
"""Most values in a file. Each takes about 100 bytes of memory, twice while it is validated."""

MAX_DIGITS = 309
"""Digits of the largest number that JSON's other readers know, a double."""

_FORMATS = {
    "tril-recording": "recordings; import them into a behaviour with `tril recordings import`",
    "tril-actions": "a list of actions; import it with `tril recordings import`",
    "tril-behaviour": "a whole behaviour; import it with `tril behaviours import`",
    "tril-run": "the run.json of a run's archive; import the zip with `tril runs import`",
    "tril-backup": "the manifest of a backup; work on its folder with `TRIL_DATA=FOLDER tril up`",
}
_MAGIC = {
    b"PK\x03\x04": "a zip file; a run that Tril exported is imported with `tril runs import`",
    b"SQLite format 3\0": "an SQLite database; work on a backup with `TRIL_DATA=FOLDER tril up`",
    b"\x1f\x8b": "compressed with gzip; unpack it first",
    b"BZh": "compressed with bzip2; unpack it first",
    b"\xfd7zXZ": "compressed with xz; unpack it first",
    b"\x28\xb5\x2f\xfd": "compressed with Zstandard; unpack it first",
    b"7z\xbc\xaf\x27\x1c": "a 7-Zip archive",
    b"Rar!": "a RAR archive",
    b"\x89PNG": "a PNG picture",
    b"\xff\xd8\xff": "a JPEG picture",
    b"GIF8": "a GIF picture",
    b"RIFF": "a picture, a sound or a film",
    b"%PDF": "a PDF",
    b"\x93NUMPY": "an array of NumPy",
    b"\x89HDF": "an HDF5 file",
    b"\x7fELF": "a program",
    b"\x80\x02": "a pickle of Python",
    b"\x80\x03": "a pickle of Python",
    b"\x80\x04": "a pickle of Python",
    b"\x80\x05": "a pickle of Python",
}
_FORMAT = re.compile(r'"format"\s*:\s*"([a-z-]+)"')
_HEAD_BYTES = 4096


def decode_json(content: bytes) -> str:
    """Return a file's text: UTF-8, UTF-16 or UTF-32, with a byte order mark or without.

    Raises:
        ValueError: It is not text in the encoding that it begins with.
    """
    encoding = json.detect_encoding(content)
    try:
        return content.decode(encoding)
    except UnicodeDecodeError as error:
        name = encoding.removesuffix("-sig").upper()
        raise ValueError(f"not {name}: {error.reason} at byte {error.start}") from None


def parse_json(text: str) -> Any:
    """Parse JSON that anybody may have written.

    Raises:
        JSONDecodeError: It is not JSON.
        ValueError: A member is repeated, a number is too large, there are too many values, or they
            are nested too deeply.
    """
    if sum(map(text.count, ",[{")) > MAX_VALUES:
        raise ValueError(f"it has more than {MAX_VALUES:,} values")
    try:
        return json.loads(
            text,
            parse_int=_integer,
            parse_constant=_refuse_constant,
            object_pairs_hook=_members,
        )
    except RecursionError:
        raise ValueError("it is nested too deeply") from None


def describe_foreign(head: bytes, *expected: str) -> str | None:
    """Describe a file by its beginning, if it is not JSON in an expected format.

    Args:
        head: The file's beginning.
        *expected: The formats, such as ``tril-recording``.

    Returns:
        The rest of the sentence that begins with "The file is"; None if it may be in the format.
    """
    head = head[:_HEAD_BYTES]
    for magic, description in _MAGIC.items():
        if head.startswith(magic):
            return description
    text = head.decode(json.detect_encoding(head), errors="replace").lstrip("\ufeff \t\r\n")
    if not text or text.startswith("{"):
        match = _FORMAT.search(text)
        return None if match is None or match[1] in expected else _FORMATS.get(match[1])
    if "\0" in text or text.count("\ufffd") > 1:
        return "not text"
    if text.startswith("["):
        return "a JSON list"
    if text.startswith("<"):
        return "a web page or XML"
    if any(line.count(",") > 1 or line.count("\t") > 1 for line in text.splitlines()[:3]):
        return "a table (CSV)"
    return "not JSON"


def _members(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    members = dict(pairs)
    if len(members) < len(pairs):
        names = [name for name, _ in pairs]
        twice = next(name for name in names if names.count(name) > 1)
        raise ValueError(f"the member {twice[:40]!r} is repeated")
    return members


def _integer(digits: str) -> int:
    if len(digits) > MAX_DIGITS:
        raise ValueError("a number is too large")
    return int(digits)


def _refuse_constant(name: str) -> object:
    raise ValueError(f"{name} is not a JSON number")
