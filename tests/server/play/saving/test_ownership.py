"""Verification of games while replaying fails."""

from __future__ import annotations

import asyncio
from concurrent.futures import Future

import pytest

from server.play.replays import ReplayProcess
from server.play.saving import ownership
from server.play.saving.ownership import find_refusal
from tril.errors import Unavailable
from tril.games.atari.starts import AtariStart
from tril.games.space_invaders import SPACE_INVADERS
from tril.recording import Recording, RecordingRefused

GAME = Recording(SPACE_INVADERS, AtariStart(0), b"\x00")


class Failing(ReplayProcess):
    """Answers with these, one after the other; None is a passed check."""

    def __init__(self, *answers: Exception | None) -> None:
        super().__init__()
        self.answers = list(answers)

    def submit(self, *_asked: object) -> Future[bytes]:
        answer = self.answers.pop(0)
        future: Future[bytes] = Future()
        if answer is None:
            future.set_result(b"")
        else:
            future.set_exception(answer)
        return future


@pytest.fixture(autouse=True)
def _at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ownership, "RETRY_S", 0.0)


def test_a_check_that_fails_is_tried_again() -> None:
    replays = Failing(Unavailable("no room"), Unavailable("no room"), None)
    assert asyncio.run(find_refusal(replays, GAME, (), lambda: False)) is None
    assert not replays.answers


def test_a_refusal_is_final() -> None:
    replays = Failing(RecordingRefused("It differs."), None)
    assert asyncio.run(find_refusal(replays, GAME, (), lambda: False)) == "It differs."
    assert len(replays.answers) == 1


def test_it_is_given_up_when_somebody_waits() -> None:
    replays = Failing(Unavailable("no room"), Unavailable("no room"), None)
    wanted = iter((False, True))
    with pytest.raises(Unavailable, match="no room"):
        asyncio.run(find_refusal(replays, GAME, (), lambda: next(wanted)))
    assert len(replays.answers) == 1
