"""Checks of games, when replaying fails for a while."""

from __future__ import annotations

import asyncio
from concurrent.futures import Future

import pytest

from server.play import checks
from server.play.checks import Checks
from server.play.replays import ReplayProcess
from tril.errors import Unavailable
from tril.game.episode import Start
from tril.recording import Recording, RecordingRefused

GAME = Recording(Start(0), b"\x00")


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
    monkeypatch.setattr(checks, "RETRY_S", 0.0)


def test_a_check_that_fails_is_tried_again() -> None:
    replays = Failing(Unavailable("no room"), Unavailable("no room"), None)
    assert asyncio.run(Checks(replays).refusal(GAME, ())) is None
    assert not replays.answers


def test_a_refusal_is_final() -> None:
    replays = Failing(RecordingRefused("It differs."), None)
    assert asyncio.run(Checks(replays).refusal(GAME, ())) == "It differs."
    assert len(replays.answers) == 1


def test_nothing_is_tried_again_when_the_process_ends() -> None:
    replays = Failing(Unavailable("no room"), None)
    waiting = Checks(replays)
    waiting.stop()
    with pytest.raises(Unavailable, match="no room"):
        asyncio.run(waiting.refusal(GAME, ()))
