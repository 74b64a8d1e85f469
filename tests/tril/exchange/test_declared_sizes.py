"""What a file declares takes no memory: small files that would unpack to gigabytes."""

from __future__ import annotations

import io
import struct
import subprocess
import sys
import zipfile
import zlib
from collections.abc import Callable
from pathlib import Path

import pytest

from tril.exchange import run_archive
from tril.exchange.formats.jsonl import MAX_LINE_BYTES
from tril.exchange.formats.run_file import RunRefused
from tril.exchange.run_archive import NETWORKS, RUN_FILE

MAX_MB = 600
"""Of the process with numpy and Pillow loaded, which take 60 MB. Zeroes took 2,460 MB before."""

READ = """
import re, sys, time
from pathlib import Path
from tril.errors import Invalid
{imports}
path = Path(sys.argv[1])
began = time.process_time()
try:
    {call}
except Invalid as error:
    print(str(error)[:300])
else:
    print("accepted")
print(time.process_time() - began)
# Not ru_maxrss, which begins with what the process that started this one took.
print(int(re.search(r"VmHWM:\\s+(\\d+)", Path("/proc/self/status").read_text())[1]) // 1024)
"""
KINDS = {
    "run": ("from tril.exchange.run_archive import read_archive", "read_archive(path)"),
    "behaviour": (
        "from tril.exchange.formats.behaviour_file import parse_behaviour",
        "parse_behaviour(path.read_bytes())",
    ),
    "recordings": (
        "from tril.exchange.formats.jsonl import read_lines",
        "raise Invalid(next(read_lines(path.open('rb'))).refusal)",
    ),
}


def read_apart(kind: str, path: Path) -> tuple[str, float, int]:
    """Read a file in a process of its own; return what is said, seconds of processor, and MB."""
    imports, call = KINDS[kind]
    program = READ.format(imports=imports, call=call)
    done = subprocess.run(
        [sys.executable, "-c", program, str(path)], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr[-2000:]
    said, seconds, megabytes = done.stdout.splitlines()
    return said, float(seconds), int(megabytes)


def _zip(*members: tuple[str, bytes]) -> bytearray:
    target = io.BytesIO()
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in members:
            archive.writestr(name, content)
    return bytearray(target.getvalue())


def understated() -> bytes:
    """A member of a gigabyte that says it has 100 bytes, in both of its headers."""
    packer = zlib.compressobj(9, zlib.DEFLATED, -15)
    packed = b"".join(packer.compress(bytes(1 << 24)) for _ in range(64)) + packer.flush()
    content = _zip((RUN_FILE, b""))
    local = struct.pack("<4sHHHHHLLLHH", b"PK\x03\x04", 20, 0, 8, 0, 33, 0, len(packed), 100, 8, 0)
    begin = content.index(b"PK\x01\x02")
    content[begin + 10 : begin + 12] = struct.pack("<H", 8)
    content[begin + 20 : begin + 28] = struct.pack("<LL", len(packed), 100)
    end = content.index(b"PK\x05\x06")
    before = local + RUN_FILE.encode() + packed
    content[end + 16 : end + 20] = struct.pack("<L", len(before))
    return before + bytes(content[begin:])


def many_members() -> bytes:
    """A list of a million members, and an end that counts three."""
    entry = struct.pack("<4s6H3L5H2L", b"PK\x01\x02", 20, 20, 0, 0, 0, 33, *[0] * 10)
    content = bytearray(b"PK\x03\x04" + bytes(26) + entry * 1_000_000)
    end = struct.pack("<4s4H2LH", b"PK\x05\x06", 0, 0, 3, 3, len(entry) * 1_000_000, 30, 0)
    return bytes(content + end)


def large_end_record() -> bytes:
    """The same behind the second record of a large zip, with an end that is modest."""
    entry = struct.pack("<4s6H3L5H2L", b"PK\x01\x02", 20, 20, 0, 0, 0, 33, *[0] * 10)
    listed = b"PK\x03\x04" + bytes(26) + entry * 1_000_000
    record = struct.pack(
        "<4sQ2H2L4Q", b"PK\x06\x06", 44, 45, 45, 0, 0, 10**6, 10**6, len(entry) * 10**6, 30
    )
    locator = struct.pack("<4sLQL", b"PK\x06\x07", 0, len(listed), 1)
    return (
        listed + record + locator + struct.pack("<4s4H2LH", b"PK\x05\x06", 0, 0, 3, 3, 138, 30, 0)
    )


def many_values() -> bytes:
    return bytes(_zip((RUN_FILE, b'{"format": "tril-run", "a": [' + b"[]," * 5_500_000 + b"[]]}")))


ARCHIVES: dict[str, tuple[Callable[[], bytes], str]] = {
    "a member longer than it says": (understated, "not a run that Tril exported|can't be read"),
    "many members": (many_members, "too many members"),
    "a second end record": (large_end_record, "too many members"),
    "many values": (many_values, "values"),
}


@pytest.mark.parametrize("what", ARCHIVES)
def test_an_archive_takes_no_more_than_its_bound(what: str, tmp_path: Path) -> None:
    make, refusal = ARCHIVES[what]
    path = tmp_path / "run.zip"
    path.write_bytes(make())
    said, seconds, megabytes = read_apart("run", path)
    assert any(words in said for words in refusal.split("|")), said
    assert megabytes < MAX_MB
    assert seconds < 2


@pytest.mark.parametrize(
    "content",
    [
        b'{"format": "tril-behaviour", "recordings": [' + b"[]," * 20_000_000,
        b'{"format": "tril-behaviour", "name": ' + b"[" * 1_000_000,
        b'{"format": "tril-behaviour", "version": ' + b"9" * 1_000_000 + b"}",
    ],
    ids=["values", "depth", "digits"],
)
def test_a_behaviour_file_takes_no_more_than_its_bound(content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "a.tril.json"
    path.write_bytes(content)
    said, seconds, megabytes = read_apart("behaviour", path)
    assert "can't be read" in said
    assert megabytes < MAX_MB
    assert seconds < 2


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16"])
def test_a_line_without_an_end_takes_no_more_than_its_bound(encoding: str, tmp_path: Path) -> None:
    path = tmp_path / "a.jsonl"
    path.write_bytes(("{" + "x" * 30_000_000).encode(encoding))
    said, _, megabytes = read_apart("recordings", path)
    assert said == f"The line is longer than {MAX_LINE_BYTES} bytes."
    assert megabytes < 200


def test_a_header_of_weights_takes_no_more_than_its_bound() -> None:
    header = b"{" + b" " * (run_archive.MAX_WEIGHTS_HEADER_BYTES + 1) + b"}"
    content = len(header).to_bytes(8, "little") + header
    with pytest.raises(RunRefused, match="header is too large"):
        run_archive._network(NETWORKS["clone"], content)


@pytest.mark.parametrize("side", [1_025, 10_000, 100_000])
def test_a_picture_of_huge_size_is_refused_undecoded(side: int) -> None:
    def chunk(name: bytes, content: bytes) -> bytes:
        checksum = zlib.crc32(name + content)
        return struct.pack(">L", len(content)) + name + content + struct.pack(">L", checksum)

    head = struct.pack(">LLBBBBB", side, side, 8, 2, 0, 0, 0)
    content = b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(b""))
    with pytest.raises(RunRefused, match="too large"):
        run_archive._picture("attention.png", content)
