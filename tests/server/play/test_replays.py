"""Replays in a process beside the server."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from typing import cast

import numpy as np
import psutil
import pytest

from server.play.replays import ReplayProcess, ReplayTask, process
from server.play.replays.products import frames_file, read_observation, read_observations
from server.play.replays.strip import strip_webp
from testsupport.waiting import wait_until
from testsupport.workplace import Workplace
from tril.demonstrators import play_varied
from tril.errors import NotFound, Unavailable
from tril.exchange.formats.recording_file import dump_recording, load_recording
from tril.games import UnknownGame
from tril.games.space_invaders import SPACE_INVADERS
from tril.recording import Recording, RecordingRefused, trajectory
from tril.store import recordings

PATIENCE_S = 60.0
DIES = f"""
import os, signal
from {process.__name__} import ReplayProcess
replays = ReplayProcess()
print(replays._running().pid, flush=True)
os.kill(os.getpid(), signal.SIGKILL)
"""


@pytest.fixture(scope="module")
def replays() -> Iterator[ReplayProcess]:
    replays = ReplayProcess()
    yield replays
    replays.stop()


@pytest.fixture
def played(workplace: Workplace) -> tuple[Recording, list[tuple[int, int]]]:
    with workplace.database.reading() as session:
        row = recordings.get(session, workplace.ranked[0])
        hits = [(hit.row, hit.column) for hit in recordings.taken_of(row)]
        return recordings.as_recording(row), hits


def test_a_recording_is_loaded_as_in_this_process(
    replays: ReplayProcess, played: tuple[Recording, list[tuple[int, int]]]
) -> None:
    content = dump_recording(played[0], notes="as it was")
    assert replays.load(content) == load_recording(content)
    with pytest.raises(RecordingRefused, match="idle_frames"):
        replays.load(content | {"start": {"idle_frames": "many"}})


def test_a_recording_that_replays_passes_the_check(
    replays: ReplayProcess, played: tuple[Recording, list[tuple[int, int]]]
) -> None:
    assert replays.submit(ReplayTask.CHECK, *played).result(PATIENCE_S) == b""


def test_the_film_strip_of_a_recording_is_made_in_the_replay_that_checks_it(
    played: tuple[Recording, list[tuple[int, int]]],
) -> None:
    recording, hits = played
    kept: list[tuple[Recording, bytes]] = []
    replays = ReplayProcess(lambda *strip: kept.append(strip))
    with pytest.raises(RecordingRefused):
        replays.submit(ReplayTask.CHECK, recording, [*hits, (5, 5)]).result(PATIENCE_S)
    assert kept == []
    replays.submit(ReplayTask.CHECK, *played).result(PATIENCE_S)
    replays.stop()
    assert kept == [(recording, strip_webp(recording))]


def test_one_that_does_not_is_refused_with_the_reason(
    replays: ReplayProcess, played: tuple[Recording, list[tuple[int, int]]]
) -> None:
    recording, hits = played
    forged = replace(recording, hashes=("0" * 16, *recording.hashes[1:]))
    with pytest.raises(RecordingRefused, match="the memory after frame 60"):
        replays.submit(ReplayTask.CHECK, forged, hits).result(PATIENCE_S)
    with pytest.raises(RecordingRefused, match="The replay takes"):
        replays.submit(ReplayTask.CHECK, recording, [*hits, (5, 5)]).result(PATIENCE_S)


def test_frames_are_those_of_a_replay_in_this_process(
    replays: ReplayProcess, played: tuple[Recording, list[tuple[int, int]]]
) -> None:
    recording, _ = played
    made = replays.submit(ReplayTask.FRAMES, recording).result(PATIENCE_S)
    assert made == frames_file(recording)


@pytest.mark.parametrize("n_frames", [1, 9, 240])
def test_observations_are_those_of_the_trajectory(
    replays: ReplayProcess, played: tuple[Recording, list[tuple[int, int]]], n_frames: int
) -> None:
    recording = played[0].until(n_frames)
    made = replays.submit(ReplayTask.OBSERVATIONS, recording).result(PATIENCE_S)
    expected = trajectory(recording).observations
    assert len(expected) == -(-n_frames // 4) + 1
    assert np.array_equal(read_observations(made), expected)
    for step in {0, len(expected) // 2, len(expected) - 1}:
        assert np.array_equal(read_observation(made, step), expected[step])
    with pytest.raises(NotFound, match=f"ends at step {len(expected) - 1}"):
        read_observation(made, len(expected))


def test_a_game_of_varied_play_is_made_from_its_seed(replays: ReplayProcess) -> None:
    first, again, other = (
        replays.play_varied("space_invaders", seed).result(PATIENCE_S) for seed in (7, 7, 2**63 - 1)
    )
    assert first == again == play_varied(np.random.default_rng(7), SPACE_INVADERS.make_console())
    assert other.recording != first.recording


def test_it_runs_behind_those_who_play_and_comes_back_when_it_was_killed(
    replays: ReplayProcess, played: tuple[Recording, list[tuple[int, int]]]
) -> None:
    replays.submit(ReplayTask.CHECK, *played).result(PATIENCE_S)
    child = _process_of(replays)
    assert child.nice() > psutil.Process().nice()
    child.kill()
    assert replays.submit(ReplayTask.CHECK, *played).result(PATIENCE_S) == b""
    assert _process_of(replays) != child


def test_an_error_is_one_request_s_own(
    replays: ReplayProcess, played: tuple[Recording, list[tuple[int, int]]]
) -> None:
    with pytest.raises(Unavailable, match="Try again"):
        replays.submit(cast("ReplayTask", "nonsense"), played[0]).result(PATIENCE_S)
    assert replays.submit(ReplayTask.CHECK, *played).result(PATIENCE_S) == b""


def test_a_game_that_is_not_installed_is_one_request_s_own(
    replays: ReplayProcess, played: tuple[Recording, list[tuple[int, int]]]
) -> None:
    replays.submit(ReplayTask.CHECK, *played).result(PATIENCE_S)
    child = _process_of(replays)
    # As if the game's package had been removed since this process, which knows it, began.
    gone = replace(played[0], game=replace(SPACE_INVADERS, name="removed"))
    for _ in range(2):
        with pytest.raises(UnknownGame, match="There is no game 'removed' here"):
            replays.submit(ReplayTask.THUMBNAIL, gone).result(PATIENCE_S)
        with pytest.raises(UnknownGame, match="There is no game 'removed' here"):
            replays.play_varied("removed", 0).result(PATIENCE_S)
        assert replays.submit(ReplayTask.CHECK, *played).result(PATIENCE_S) == b""
    assert _process_of(replays) == child


def test_a_process_that_does_not_start_is_said(
    monkeypatch: pytest.MonkeyPatch, played: tuple[Recording, list[tuple[int, int]]]
) -> None:
    monkeypatch.setattr(process, "_COMMAND", (sys.executable, "-c", "raise SystemExit(1)"))
    replays = ReplayProcess()
    with pytest.raises(Unavailable, match="log"):
        replays.submit(ReplayTask.CHECK, *played).result(PATIENCE_S)
    replays.stop()


def test_it_ends_with_its_server_even_if_that_is_killed() -> None:
    died = subprocess.run(
        [sys.executable, "-c", DIES], stdout=subprocess.PIPE, check=False, timeout=PATIENCE_S
    )
    pid = int(died.stdout)
    wait_until(lambda: not _runs(pid), PATIENCE_S)


def _process_of(replays: ReplayProcess) -> psutil.Process:
    assert replays._process is not None
    return psutil.Process(replays._process.pid)


def _runs(pid: int) -> bool:
    return psutil.pid_exists(pid) and psutil.Process(pid).status() != psutil.STATUS_ZOMBIE
