"""Vocabularies are made by a process of their own, once, and end with the server."""

from __future__ import annotations

import logging
import pickle
import subprocess
import sys
from pathlib import Path

import pytest

from server.vocabularies import VocabularyMaker, maker
from testsupport.waiting import wait_until
from tril.games import game_named
from tril.games.settings import GameSettings
from tril.vocabulary.facts import Vocabulary
from tril.vocabulary.making import vocabulary_of

PONG = game_named("pong").with_settings(GameSettings(max_steps=25))
PATIENCE_S = 300.0


@pytest.mark.lengthy
def test_a_vocabulary_is_made_in_the_background_and_found_again(tmp_path: Path) -> None:
    vocabularies = VocabularyMaker(tmp_path)
    first = vocabularies.vocabulary(PONG)
    assert (first.path, first.failed) == (None, False)
    wait_until(lambda: vocabularies.vocabulary(PONG).path is not None, PATIENCE_S)
    # Pictures follow.
    wait_until(lambda: 0 in vocabularies.pictured(PONG), PATIENCE_S)
    making = vocabularies.vocabulary(PONG)
    assert making.path is not None
    assert Vocabulary.load(making.path).n_facts > 0
    assert vocabularies.picture(PONG, 0).startswith(b"\x89PNG")
    vocabularies.stop()
    again = VocabularyMaker(tmp_path)
    assert again.vocabulary(PONG) == making, "nothing is made twice"
    assert again._process is None
    again.stop()


def test_one_that_fails_says_so_and_is_not_tried_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    started = tmp_path / "started"
    program = f"open({str(started)!r}, 'a').write('x'); raise SystemExit('no memory')"
    monkeypatch.setattr(maker, "_COMMAND", (sys.executable, "-c", program))
    vocabularies = VocabularyMaker(tmp_path)
    with caplog.at_level(logging.ERROR):
        vocabularies.vocabulary(PONG)
        wait_until(lambda: vocabularies.vocabulary(PONG).failed)
    assert "no memory" in caplog.text
    vocabularies.vocabulary(PONG)
    vocabularies.stop()
    assert started.read_text() == "x"
    # A worker on the same folder makes it all the same.
    vocabulary_of(tmp_path, PONG)
    assert vocabularies.vocabulary(PONG).path is not None


def test_it_ends_when_the_server_is_killed(tmp_path: Path) -> None:
    whole = game_named("pong")
    child = subprocess.Popen(
        maker._COMMAND, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL
    )
    assert child.stdin is not None
    assert child.stdout is not None
    pickle.dump((tmp_path, whole), child.stdin)
    child.stdin.flush()
    assert 0 <= float(child.stdout.readline()) < 1
    # What the kernel does with the pipes of a killed server.
    child.stdin.close()
    assert child.wait(PATIENCE_S) == 1
    child.stdout.close()
    assert not list((tmp_path / "vocabularies").glob("*.npz"))
