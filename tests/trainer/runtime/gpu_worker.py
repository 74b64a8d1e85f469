"""A worker that says it has a GPU and learns on the CPU; for tests of who takes which runs."""

from __future__ import annotations

import sys
from pathlib import Path

from testsupport.databases import settings_on
from trainer.runtime import worker

if __name__ == "__main__":
    worker._gpu_name = lambda settings: "Pretended GPU"
    settings = settings_on(
        Path(sys.argv[1]), learning_threads=1, learning_niceness=0, learning_device="cpu"
    )
    worker.run_worker(settings, until_empty=True)
