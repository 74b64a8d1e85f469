"""Training gives way to whoever plays on the same machine."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from trainer.runtime import priority

NICENESS = 19


@pytest.fixture
def niceness(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Return the priority that the process would have, in a list of one."""
    held = [0]

    def nice(more: int) -> int:
        held[0] += more
        return held[0]

    monkeypatch.setattr(os, "nice", nice)
    return held


@pytest.mark.parametrize("leads", [True, False])
def test_the_process_and_a_session_of_its_own_are_lowered(
    niceness: list[int], monkeypatch: pytest.MonkeyPatch, tmp_path: Path, leads: bool
) -> None:
    group = tmp_path / "autogroup"
    group.write_text("0")
    monkeypatch.setattr(priority, "AUTOGROUP", group)
    monkeypatch.setattr(os, "getsid", lambda _: os.getpid() if leads else 1)
    priority.lower_priority(NICENESS)
    priority.lower_priority(NICENESS)
    assert niceness == [NICENESS]
    assert group.read_text() == (str(NICENESS) if leads else "0")


def test_a_kernel_that_does_not_group_sessions_is_no_problem(
    niceness: list[int], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(priority, "AUTOGROUP", tmp_path)  # a folder: it can't be written
    monkeypatch.setattr(os, "getsid", lambda _: os.getpid())
    priority.lower_priority(NICENESS)
    assert niceness == [NICENESS]
