"""Clocks of processes that can be set wrong while they run; needs a C compiler."""

from __future__ import annotations

import mmap
import shutil
import struct
import subprocess
from dataclasses import dataclass
from pathlib import Path

SOURCE = Path(__file__).with_name("skewed_clock.c")
_SECONDS = struct.Struct("=q")


@dataclass(frozen=True)
class Clock:
    """The real-time clock of a process and of what it starts.

    Attributes:
        library: What ``build`` made.
        place: File by which it is set.
    """

    library: Path
    place: Path

    def __post_init__(self) -> None:
        """Begin with the right time."""
        self.place.write_bytes(_SECONDS.pack(0))

    def environment(self) -> dict[str, str]:
        """Return the environment variables of a process that has this clock."""
        return {"LD_PRELOAD": str(self.library), "SKEW_FILE": str(self.place)}

    def set_wrong(self, seconds: int) -> None:
        """Let the clock be fast by so many seconds from now on, slow if they are negative."""
        with self.place.open("r+b") as file, mmap.mmap(file.fileno(), _SECONDS.size) as mapped:
            mapped[:] = _SECONDS.pack(seconds)


def build(folder: Path) -> Path | None:
    """Compile the library of wrong clocks into a folder; None without a compiler."""
    if (compiler := shutil.which("cc")) is None:
        return None
    library = folder / "skewed_clock.so"
    subprocess.run([compiler, "-shared", "-fPIC", "-O2", "-o", library, SOURCE, "-ldl"], check=True)
    return library
