"""What threads free goes back to the system."""

from __future__ import annotations

import subprocess
import sys

import pytest

PROGRAM = """
import ctypes, re, sys, threading
from pathlib import Path
from server.heap import keep_heap_small
if sys.argv[1] == "small":
    keep_heap_small()
libc = ctypes.CDLL(None)
libc.malloc.restype = ctypes.c_void_p
libc.free.argtypes = [ctypes.c_void_p]
barrier = threading.Barrier(12)

def work():
    # Of a size that glibc takes from a heap, all freed while every thread lives.
    held = [libc.malloc(100_000) for _ in range(40)]
    for place in held:
        ctypes.memset(place, 1, 100_000)
    barrier.wait()
    for place in held[:-1]:
        libc.free(place)
    barrier.wait()

threads = [threading.Thread(target=work) for _ in range(12)]
for thread in threads:
    thread.start()
for thread in threads:
    thread.join()
libc.malloc_info.argtypes = [ctypes.c_int, ctypes.c_void_p]
libc.fopen.restype = ctypes.c_void_p
file = libc.fopen(sys.argv[2].encode(), b"w")
libc.malloc_info(0, file)
libc.fclose.argtypes = [ctypes.c_void_p]
libc.fclose(file)
print(len(re.findall("<heap nr", Path(sys.argv[2]).read_text())))
"""


def _n_heaps(how: str, file: str) -> int:
    command = [sys.executable, "-c", PROGRAM, how, file]
    return int(subprocess.run(command, capture_output=True, check=True, text=True).stdout)


@pytest.mark.skipif(sys.platform != "linux", reason="glibc's heaps")
def test_all_threads_share_one_heap(tmp_path: object) -> None:
    assert _n_heaps("as it is", f"{tmp_path}/before.xml") > 1
    assert _n_heaps("small", f"{tmp_path}/after.xml") == 1
