"""A whole Tril (``tril up``) with a data folder of its own."""

from __future__ import annotations

import os
import queue
import re
import signal
import subprocess
import sys
import threading
from dataclasses import dataclass, field
from pathlib import Path

BROWSER_ARGUMENTS = [
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
]
ADDRESS = re.compile(r"http://\S+\?token=\S+")
START_TIMEOUT_S = 90


@dataclass
class RunningTril:
    """A started ``tril up``: its address with the token and everything it printed."""

    process: subprocess.Popen[str]
    data: Path
    address: str = ""
    output: list[str] = field(default_factory=list)

    def stop(self) -> int:
        """Press Ctrl-C and wait; returns the exit status."""
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
        return self.process.wait(30)


def start_tril(data: Path, *arguments: str) -> RunningTril:
    """Start ``tril up`` on a free port and wait until it prints its address."""
    environment = {k: v for k, v in os.environ.items() if not k.startswith("TRIL_")}
    process = subprocess.Popen(
        [sys.executable, "-m", "cli.main", "up", "--port", "0", "--no-browser", *arguments],
        env={**environment, "TRIL_DATA": str(data), "COLUMNS": "200", "PYTHONUNBUFFERED": "1"},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,
    )
    running = RunningTril(process, data)
    addresses: queue.Queue[str] = queue.Queue()

    def _read() -> None:
        assert process.stdout is not None
        with process.stdout:
            for line in process.stdout:
                running.output.append(line)
                if found := ADDRESS.search(line):
                    addresses.put(found.group())

    threading.Thread(target=_read, daemon=True).start()
    try:
        running.address = addresses.get(timeout=START_TIMEOUT_S)
    except queue.Empty:
        running.stop()
        raise AssertionError("tril up printed no address:\n" + "".join(running.output)) from None
    return running
