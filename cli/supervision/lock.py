"""A lock against several ``tril up`` on one data folder."""

from __future__ import annotations

import fcntl
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tril.errors import Unavailable


@contextmanager
def lock_data_folder(folder: Path, url: str) -> Iterator[None]:
    """Hold a data folder's lock, which the kernel releases when this process ends.

    Args:
        folder: The existing data folder.
        url: The page's URL, for the error message of other processes.

    Raises:
        Unavailable: Another process holds the lock.
    """
    with (folder / "up.lock").open("a+") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            file.seek(0)
            raise Unavailable(
                f"Tril already runs on {folder}, at {file.read().strip()}. Open its page, or choose"
                " another data folder with TRIL_DATA."
            ) from None
        file.truncate(0)
        file.write(f"{url}\n")
        file.flush()
        yield
