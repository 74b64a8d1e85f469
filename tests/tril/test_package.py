"""What the package says of itself."""

from __future__ import annotations

import subprocess
import sys


def test_importing_tril_loads_neither_torch_nor_the_web() -> None:
    program = "import sys, tril\nprint({'torch', 'fastapi', 'starlette'} & set(sys.modules))"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, check=True)
    assert done.stdout == b"set()\n"
