"""Programs that the server runs in processes of their own, one at a time."""

from __future__ import annotations

import os
import subprocess
import threading
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager

from tril.errors import Unavailable

ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
"""A thread for each core would slow down games."""


class Turns:
    """Makes one file at a time; thread-safe.

    Args:
        products: Name of the products in the plural, for the message.
        max_waiting: How many requests may wait before further ones are refused: each holds a
            thread of the server.
    """

    def __init__(self, products: str, max_waiting: int) -> None:
        self._products = products
        self._lock = threading.Lock()
        self._places = threading.BoundedSemaphore(1 + max_waiting)

    @contextmanager
    def turn(self) -> Iterator[None]:
        """Wait for a turn and hold it for the block.

        Raises:
            Unavailable: Too many wait.
        """
        if not self._places.acquire(blocking=False):
            raise Unavailable(
                f"Several {self._products} are being made already. Try again in a minute."
            )
        try:
            with self._lock:
                yield
        finally:
            self._places.release()


def run_program(
    command: Sequence[str],
    timeout_s: float,
    product: str,
    request: bytes = b"",
    environ: Mapping[str, str] | None = None,
) -> subprocess.CompletedProcess[bytes]:
    """Run a program to its end, on one thread.

    Args:
        command: The program with its arguments.
        timeout_s: Timeout of the program.
        product: Name of the product, for the message.
        request: Standard input of the program.
        environ: Variables besides this process's.

    Raises:
        Unavailable: It took too long.
    """
    try:
        return subprocess.run(
            command,
            input=request,
            capture_output=True,
            timeout=timeout_s,
            check=False,
            env={**os.environ, **ONE_THREAD, **(environ or {})},
        )
    except subprocess.TimeoutExpired as error:
        raise Unavailable(
            f"Making the {product} took too long, because the machine is busy. Try again later."
        ) from error
