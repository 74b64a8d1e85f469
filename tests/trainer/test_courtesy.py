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


def niceness_after(group: Path, leads_a_session: bool) -> int:
    """Lower the priority of a new process twice; returns what it is then."""
    done = subprocess.run(
        [sys.executable, "-c", LOWER],
        env={"GROUP": str(group), "OMP_NUM_THREADS": "1"},
        cwd=Path(__file__).parents[2],
        capture_output=True,
        text=True,
        check=True,
        start_new_session=leads_a_session,
    )
    return int(done.stdout)


@pytest.mark.parametrize("leads", [True, False])
def test_the_process_and_a_session_of_its_own_are_lowered(tmp_path: Path, leads: bool) -> None:
    group = tmp_path / "autogroup"
    group.write_text("0")
    assert niceness_after(group, leads) >= 10
    assert group.read_text() == ("10" if leads else "0")


def test_a_kernel_that_does_not_group_sessions_is_no_problem(tmp_path: Path) -> None:
    not_writable = tmp_path
    assert niceness_after(not_writable, leads_a_session=True) >= 10
