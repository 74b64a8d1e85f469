"""Who owns a game, and what its owner may write."""

from __future__ import annotations

from collections.abc import Iterator
from datetime import timedelta
from pathlib import Path

import pytest
from sqlalchemy.orm import Session

from testsupport.workplace import Workplace, make_workplace
from tril.errors import NotFound
from tril.games.atari.starts import AtariStart
from tril.games.space_invaders import SPACE_INVADERS
from tril.games.space_invaders.memory import Action
from tril.play.episode import Episode
from tril.recording import Recorder
from tril.store import games, players, recordings
from tril.store.games import GameOver, Progress
from tril.store.models import GameRow, RecordingState, Verification, now


@pytest.fixture
def session(tmp_path: Path) -> Iterator[Session]:
    made: Workplace = make_workplace(tmp_path / "data")
    with made.database.writing() as session:
        yield session
    made.database.close()


@pytest.fixture(scope="module")
def recorder() -> Recorder:
    recorder = Recorder(Episode(SPACE_INVADERS.make_console(), AtariStart(4)))
    for _ in range(61):
        recorder.advance(Action.FIRE)
    return recorder


def begin(session: Session) -> tuple[GameRow, int]:
    """Begin a game with an owner; returns it with the owner's epoch."""
    game = games.create(session, 1, AtariStart(4), None)
    return game, games.acquire(session, game.id, "server", "tab").epoch


def progress(game_id: str, epoch: int, recorder: Recorder) -> Progress:
    return Progress(game_id, epoch, recorder.recording(), recorder.replay())


def test_an_owner_saves_and_an_earlier_one_is_refused(session: Session, recorder: Recorder) -> None:
    game = games.create(session, 1, AtariStart(4), None)
    first = games.acquire(session, game.id, "server-1", "tab-1").epoch
    second = games.acquire(session, game.id, "server-2", "tab-2").epoch
    assert (first, second) == (1, 2)
    assert not games.save(session, progress(game.id, first, recorder))
    assert recordings.get(session, game.recording_id).n_frames == 0
    assert games.save(session, progress(game.id, second, recorder))
    row = recordings.get(session, game.recording_id)
    assert recordings.as_recording(row) == recorder.recording()
    assert row.state == RecordingState.PLAYING
    assert not games.end(session, game.id, first, RecordingState.FINISHED, None)
    assert games.end(session, game.id, second, RecordingState.FINISHED, None)
    assert row.verification == Verification.VERIFIED
    assert not games.save(session, progress(game.id, second, recorder)), "it is over"
    with pytest.raises(GameOver):
        games.acquire(session, game.id, "server-1", "tab-1")


def test_a_game_that_does_not_replay_says_why(session: Session, recorder: Recorder) -> None:
    game, epoch = begin(session)
    games.save(session, progress(game.id, epoch, recorder))
    games.end(session, game.id, epoch, RecordingState.FINISHED, "It differs.")
    row = recordings.get(session, game.recording_id)
    assert (row.verification, row.verification_note) == (Verification.FAILED, "It differs.")


def test_a_game_in_which_nothing_was_played_leaves_nothing_in_the_library(session: Session) -> None:
    game, epoch = begin(session)
    games.end(session, game.id, epoch, RecordingState.UNFINISHED, None)
    assert game.recording_id not in [row.id for row in recordings.listing(session, 1)]


def test_games_count_as_abandoned_once_nobody_owned_them_for_long_enough(session: Session) -> None:
    left, epoch = begin(session)
    played, its_epoch = begin(session)
    games.release(session, left.id, epoch)
    in_a_second = timedelta(seconds=-1)
    assert [row.id for row in games.abandoned(session, in_a_second)] == [left.id]
    assert games.abandoned(session, timedelta(minutes=1)) == []
    games.release(session, played.id, its_epoch)


def test_only_a_game_that_nobody_owns_is_taken_over(session: Session) -> None:
    game, epoch = begin(session)
    a_minute = timedelta(minutes=1)
    assert games.acquire_abandoned(session, game.id, "server-2", a_minute) is None
    game.lease_expires_at = now() - 2 * a_minute
    taken = games.acquire_abandoned(session, game.id, "server-2", a_minute)
    assert taken is not None
    assert (taken.epoch, taken.owner) == (epoch + 1, "server-2")
    assert games.acquire_abandoned(session, game.id, "server-3", a_minute) is None
    games.end(session, game.id, taken.epoch, RecordingState.UNFINISHED, None)
    assert games.acquire_abandoned(session, game.id, "server-3", -a_minute) is None, "it is over"


def test_games_count_as_open_until_a_minute_after_their_lease(session: Session) -> None:
    owner = players.owner(session).id
    mine, another = (
        games.create(session, 1, AtariStart(4), owner),
        games.create(session, 1, AtariStart(4), None),
    )
    assert (games.count_open(session), games.count_open(session, owner)) == (2, 1)
    assert games.is_open(session, mine.id)
    mine.lease_expires_at = now() - games.OPEN_FOR - timedelta(seconds=1)
    session.flush()
    assert (games.count_open(session), games.count_open(session, owner)) == (1, 0)
    assert not games.is_open(session, mine.id)
    epoch = games.acquire(session, another.id, "server", "tab").epoch
    games.end(session, another.id, epoch, RecordingState.FINISHED, None)
    assert games.count_open(session) == 0


def test_undecided_games_are_kept_after_some_time(session: Session, recorder: Recorder) -> None:
    game, epoch = begin(session)
    games.save(session, progress(game.id, epoch, recorder))
    games.end(session, game.id, epoch, RecordingState.FINISHED, None)
    row = recordings.get(session, game.recording_id)
    games.keep_undecided(session, timedelta(hours=1))
    assert row.state == RecordingState.FINISHED
    row.finished_at = now() - timedelta(hours=2)
    games.keep_undecided(session, timedelta(hours=1))
    assert row.state == RecordingState.KEPT


def test_an_unknown_game_is_named_so(session: Session) -> None:
    with pytest.raises(NotFound):
        games.acquire(session, "nothing", "server", "tab")
