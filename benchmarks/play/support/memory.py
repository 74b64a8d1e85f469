"""Memory of this process, in figures that tell a leak from a fragmented heap."""

from __future__ import annotations

import asyncio
import ctypes
import gc
import sys
import threading
import tracemalloc
from collections import Counter
from typing import Any

N_TYPES = 60
N_LINES = 40


class _Mallinfo(ctypes.Structure):
    """Statistics of glibc's allocator, see mallinfo2(3)."""

    _fields_ = [
        (name, ctypes.c_size_t)
        for name in (
            "arena",
            "ordblks",
            "smblks",
            "hblks",
            "hblkhd",
            "usmblks",
            "fsmblks",
            "uordblks",
            "fordblks",
            "keepcost",
        )
    ]


def memory_use() -> dict[str, Any]:
    """Return what this process holds.

    Returns:
        ``blocks``: objects of Python's allocator; ``objects``: containers that the garbage
        collector knows, by type; ``tasks`` and ``threads``; ``heap_used_bytes`` and
        ``heap_free_bytes`` of glibc; ``lines``: bytes by the line that allocated them, if traced.
    """
    used = {
        "blocks": sys.getallocatedblocks(),
        "objects": dict(Counter(map(_name_of, gc.get_objects())).most_common(N_TYPES)),
        "tasks": len(asyncio.all_tasks()),
        "threads": threading.active_count(),
        "lines": {},
    }
    info = _mallinfo()
    if info is not None:
        used["heap_used_bytes"] = info.uordblks + info.hblkhd
        used["heap_free_bytes"] = info.fordblks
    if tracemalloc.is_tracing():
        largest = tracemalloc.take_snapshot().statistics("lineno")[:N_LINES]
        used["lines"] = {str(line.traceback): line.size for line in largest}
    return used


def _name_of(thing: object) -> str:
    return f"{type(thing).__module__}.{type(thing).__qualname__}"


def _mallinfo() -> _Mallinfo | None:
    try:
        read = ctypes.CDLL(None).mallinfo2
    except AttributeError:
        return None
    read.restype = _Mallinfo
    found: _Mallinfo = read()
    return found
