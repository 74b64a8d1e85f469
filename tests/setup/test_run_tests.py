"""``make test`` runs what failed once more, alone, and tells flaky tests from broken ones."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]

FLAKY = """
from pathlib import Path
def test_flaky():
    marker = Path("was-run")
    was_run = marker.exists()
    marker.touch()
    assert was_run
"""
SOUND = "def test_sound(): open('sound-runs', 'a').write('.')\n"
BROKEN = "def test_broken(): assert not 'a - b'\n"


def run_tests(folder: Path, *arguments: str, **files: str) -> subprocess.CompletedProcess[str]:
    (folder / "pytest.ini").write_text("[pytest]\naddopts = -ra")
    for name, text in files.items():
        (folder / f"{name}.py").write_text(text)
    options = ["--numprocesses", "2", "--dist", "worksteal", *arguments]
    return subprocess.run(
        [str(ROOT / "scripts/run_tests.sh"), sys.executable, *options],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )


def summed_up(log: str, folder: Path) -> str:
    """Return what .ci/run prints of pytest's closing lines."""
    (folder / "test").write_text(log)
    script = (ROOT / ".ci/run").read_text()
    summary = re.search(r"^awk .*?\| sort$", script, re.MULTILINE | re.DOTALL)
    assert summary is not None
    return subprocess.run(
        ["bash", "-c", f"logs={folder}\n{summary[0]}"], capture_output=True, text=True, check=True
    ).stdout


def test_a_test_that_passes_alone_is_named_and_fails_nothing(tmp_path: Path) -> None:
    done = run_tests(tmp_path, test_flaky=FLAKY, test_sound=SOUND)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "Once more, alone" in done.stdout
    assert (tmp_path / "sound-runs").read_text() == "."
    assert summed_up(done.stdout, tmp_path) == (
        "FAILED beside others only: test_flaky.py::test_flaky\n"
    )


def test_a_test_that_fails_again_fails_the_run(tmp_path: Path) -> None:
    done = run_tests(tmp_path, test_flaky=FLAKY, test_broken=BROKEN)
    assert done.returncode == 1
    flaky, broken = summed_up(done.stdout, tmp_path).splitlines()
    assert broken.startswith("FAILED test_broken.py::test_broken - ")
    assert flaky == "FAILED beside others only: test_flaky.py::test_flaky"


@pytest.mark.parametrize(("arguments", "code"), [((), 0), (("-k", "nothing"), 5)])
def test_nothing_is_run_again_where_nothing_failed(
    tmp_path: Path, arguments: tuple[str, ...], code: int
) -> None:
    done = run_tests(tmp_path, *arguments, test_sound=SOUND)
    assert done.returncode == code
    assert "Once more" not in done.stdout
