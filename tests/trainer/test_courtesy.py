"""Training gives way to whoever plays on the same machine."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

LOWER = (
    "import os; from pathlib import Path; from trainer import courtesy;"
    "courtesy.AUTOGROUP = Path(os.environ['GROUP']);"
    "courtesy.lower_priority(); courtesy.lower_priority(); print(os.nice(0))"
)


@pytest.mark.parametrize("leads", [True, False])
def test_the_process_and_a_session_of_its_own_are_lowered(tmp_path: Path, leads: bool) -> None:
    group = tmp_path / "autogroup"
    group.write_text("0")
    done = subprocess.run(
        [sys.executable, "-c", LOWER],
        env={"GROUP": str(group), "OMP_NUM_THREADS": "1"},
        cwd=Path(__file__).parents[2],
        capture_output=True,
        text=True,
        check=True,
        start_new_session=leads,
    )
    assert int(done.stdout) >= 10
    assert group.read_text() == ("10" if leads else "0")


def test_a_kernel_without_sessions_groups_is_no_problem(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-c", LOWER],
        env={"GROUP": str(tmp_path), "OMP_NUM_THREADS": "1"},
        cwd=Path(__file__).parents[2],
        capture_output=True,
        text=True,
        check=True,
        start_new_session=True,
    )
    assert int(done.stdout) >= 10
