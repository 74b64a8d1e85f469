"""The C library's heap, which grows for days if each thread has a part of it of its own."""

from __future__ import annotations

import ctypes
import os

_M_TRIM_THRESHOLD, _M_MMAP_THRESHOLD, _M_ARENA_MAX = -1, -3, -8
"""Number of the parameter in malloc.h."""

_LARGE_BYTES = 128 * 1024
"""glibc's defaults, which it raises up to 32 MiB as soon as something large is freed."""


def keep_heap_small() -> None:
    """Have all threads share one heap, and give freed memory back; call it before there are any.

    glibc gives up to eight heaps for each core to threads, of which those that were freed in stay
    taken: what is in use is flat, while what is free and held grows (docs/benchmarks.md). Python's
    lock lets one thread at a time allocate most of it anyway. Elsewhere nothing happens.
    """
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None) if os.name == "posix" else None
    if mallopt is not None:
        mallopt(_M_ARENA_MAX, 1)
        mallopt(_M_MMAP_THRESHOLD, _LARGE_BYTES)
        mallopt(_M_TRIM_THRESHOLD, _LARGE_BYTES)
