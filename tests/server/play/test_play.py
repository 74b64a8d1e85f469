"""Games over a real WebSocket of a real server."""

from __future__ import annotations

import time
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
import pytest
from sqlalchemy import event
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from server.play.rules import PlayRules
from server.play.wire.protocol import (
    MAX_UNACKNOWLEDGED,
    Close,
    Countdown,
    Ended,
    FrameMessage,
    Hello,
    HitMessage,
    Paused,
    TakenOver,
)
from server.web.middleware import CLOSE_UNAUTHORISED
from tests.server.clients import replayed, stored
from testsupport.live import GameClient, LiveServer, cookie, live_server
from testsupport.space_invaders import Keys
from testsupport.waiting import wait_until
from testsupport.workplace import Workplace
from tril.games.space_invaders.memory import Action
from tril.store import games, recordings
from tril.store.database import Database


def assert_screens_replay(live: LiveServer, player: GameClient, ended: Ended) -> None:
    """Compare every screen that was seen with the stored recording's replay."""
    recording = stored(live.database, ended.recording_id)
    screens = replayed(recording, lambda console: console.screen())
    assert len(screens) == ended.frame + 1
    for frame, screen in player.screens.items():
        np.testing.assert_array_equal(screen, screens[frame])


def received_until_quiet(player: GameClient) -> list[object]:
    """Return the messages that come until none does for a while."""
    received: list[object] = []
    try:
        while True:
            received.append(player.next(0.3))
    except TimeoutError:
        return received


def fill_window(player: GameClient, n_before: int = 0) -> None:
    """Take frames without acknowledging them until no more are sent."""
    player.acknowledges = False
    while len(player.frames) < n_before + MAX_UNACKNOWLEDGED:
        player.next()


@contextmanager
def full_disk(database: Database) -> Iterator[None]:
    """Let every change of games and recordings fail as databases do when the disk is full."""
    said = {"sqlite": "database or disk is full", "postgresql": "No space left on device"}

    def refuse(_cursor: Any, statement: str, _parameters: Any, context: Any) -> None:
        if statement.startswith(("UPDATE", "INSERT")):
            dialect = context.dialect
            raise dialect.loaded_dbapi.OperationalError(said[dialect.name])

    event.listen(database.engine, "do_execute", refuse)
    try:
        yield
    finally:
        event.remove(database.engine, "do_execute", refuse)


def test_the_acknowledged_stream_decodes_to_the_screens_of_a_replay(live: LiveServer) -> None:
    with live.play(live.new_game()) as player:
        hello = player.begin()
        assert (hello.frame, hello.resumed, hello.epoch) == (0, False, 1)
        assert [player.until(Countdown).seconds for _ in range(3)] == [2, 1, 0]
        for frame, keys in ((20, Keys.RIGHT | Keys.FIRE), (60, Keys.LEFT), (90, Keys.FIRE)):
            player.until_frame(frame)
            player.hold(keys)
        player.until_frame(130)
        ended = player.stop()
    assert (ended.verification, ended.reason) == ("verified", None)
    # A frame is left out only where the machine is too busy to draw it in time.
    assert len(set(range(100)) & set(player.screens)) >= 90
    assert_screens_replay(live, player, ended)
    recording = live.recording(ended.recording_id)
    assert (recording["state"], recording["n_frames"]) == ("finished", ended.frame)
    assert recording["counters"]["shots"] >= 1


def test_a_game_that_plays_to_its_end_reports_hits_and_the_reason(live: LiveServer) -> None:
    hits = []
    with live.play(live.new_game(start={"idle_frames": 4})) as player:
        player.hold(Keys.FIRE)
        player.begin()
        while not isinstance(message := player.next(), Ended):
            if isinstance(message, HitMessage):
                hits.append(message)
        assert player.close_code() == Close.GAME_OVER
    assert message.reason == "hit"
    assert [(hit.row, hit.column, hit.frame) for hit in hits] == [
        (hit.row, hit.column, hit.frame) for hit in message.hits
    ]
    assert hits, "standing at the start and firing hits aliens of column 1"
    assert all(hit.on_target for hit in hits)
    assert [hit.targets for hit in hits] == list(range(1, len(hits) + 1))
    kept = live.http.post(f"/api/recordings/{message.recording_id}/keep").json()
    assert (kept["state"], kept["verification"]) == ("kept", "verified")
    assert kept["targets"] == len(hits)


def test_a_page_that_acknowledges_nothing_has_six_frames_in_flight_and_the_game_waits(
    live: LiveServer,
) -> None:
    with live.play(live.new_game()) as player:
        player.acknowledges = False
        player.begin()
        paused = player.until(Paused)
        assert "stopped drawing" in paused.why
        assert len(player.frames) == MAX_UNACKNOWLEDGED
        newest = player.frames[-1].sequence
        player.acknowledge(newest)
        caught_up = player.until(FrameMessage)
        assert caught_up.frame > player.frames[-2].frame + 60
        assert caught_up.sequence == newest + 1
        player.acknowledges = True
        player.acknowledge(caught_up.sequence)
        assert [player.until(Countdown).seconds for _ in range(3)] == [2, 1, 0]
        player.until_frame(caught_up.frame + 10)
        assert_screens_replay(live, player, player.stop())


def test_a_game_that_its_player_paused_does_not_go_on_by_itself(live: LiveServer) -> None:
    with live.play(live.new_game()) as player:
        player.begin()
        player.acknowledges = False
        assert "stopped drawing" in player.until(Paused).why
        player.say("pause")
        assert "You paused" in player.until(Paused).why
        player.acknowledges = True
        player.acknowledge(player.frames[-1].sequence)
        assert not any(isinstance(message, Countdown) for message in received_until_quiet(player))


def test_a_connection_that_breaks_pauses_the_game_and_the_next_one_resumes_it(
    live: LiveServer,
) -> None:
    game = live.new_game()
    tab = str(uuid.uuid4())
    with live.play(game, tab) as player:
        player.begin()
        player.until_frame(70)
        player.socket.socket.close()
    with live.play(game, tab) as player:
        hello = player.until(Hello)
        assert (hello.resumed, hello.epoch) == (True, 2)
        assert hello.frame >= 70
        first = player.until(FrameMessage)
        assert (first.encoded.is_key, first.frame) == (True, hello.frame)
        player.say("ready")
        player.until_frame(hello.frame + 30)
        ended = player.stop()
    assert ended.verification == "verified"
    assert_screens_replay(live, player, ended)


def test_the_newest_tab_has_the_game_and_the_other_is_told(live: LiveServer) -> None:
    game = live.new_game()
    with live.play(game) as first:
        first.begin()
        first.until_frame(20)
        with live.play(game) as second:
            hello = second.until(Hello)
            assert hello.frame >= 20
            first.until(TakenOver)
            assert first.close_code() == Close.TAKEN_OVER
            second.say("ready")
            second.until_frame(hello.frame + 10)
            assert second.stop().verification == "verified"


def test_pausing_and_going_on_keeps_the_frame(live: LiveServer) -> None:
    with live.playing(15) as player:
        player.say("pause")
        assert player.until(Paused).why
        player.say("go_on")
        assert player.until(Countdown).seconds == 2
        # A frame that was dropped for a slow client is shown once the game stands.
        standing = player.frames[-1].frame
        assert player.until(FrameMessage).frame == standing + 1


def test_slow_motion_lasts_over_a_reconnect_and_is_recorded(live: LiveServer) -> None:
    game = live.new_game()
    tab = str(uuid.uuid4())
    with live.play(game, tab) as player:
        assert player.begin().speed_percent == 100
        player.until_frame(10)
        player.say("speed", percent=25)
        player.until_frame(20)
    with live.play(game, tab) as player:
        assert player.begin().speed_percent == 25
        player.say("speed", percent=100)
        ended = player.stop()
    assert ended.verification == "verified"
    recording = live.recording(ended.recording_id)
    assert (recording["slowest_percent"], recording["single_steps"]) == (25, 0)


def test_single_frames_are_executed_with_the_keys_held(live: LiveServer) -> None:
    with live.playing(5) as player:
        player.say("pause")
        player.until(Paused)
        standing = player.frames[-1].frame
        player.hold(Keys.LEFT | Keys.FIRE)
        player.hold(Keys.LEFT)
        for _ in range(3):
            player.say("step")
        player.until_frame(standing + 3)
        assert not received_until_quiet(player)
        ended = player.stop()
    assert ended.frame == standing + 3
    assert ended.verification == "verified"
    row = live.row(ended.recording_id)
    assert list(row.actions[-3:]) == [Action.LEFTFIRE, Action.LEFT, Action.LEFT]
    assert row.conditions["play"]["single_steps"] == [standing + 1, standing + 2, standing + 3]
    assert row.conditions["play"]["pauses"] == [standing]
    assert live.recording(ended.recording_id)["single_steps"] == 3


def test_a_step_while_the_game_runs_is_ignored(live: LiveServer) -> None:
    with live.playing(5) as player:
        player.say("step")
        player.until_frame(10)
        ended = player.stop()
    assert live.recording(ended.recording_id)["single_steps"] == 0


def test_an_input_is_applied_to_the_next_frame_and_named_by_it(live: LiveServer) -> None:
    with live.playing(10) as player:
        player.hold(Keys.RIGHT)
        sequence = player.hold(Keys(0))
        applied = player.until(FrameMessage, lambda message: message.input_sequence == sequence)
        player.until_frame(applied.frame + 5)
        ended = player.stop()
    actions = live.row(ended.recording_id).actions
    assert actions.count(Action.RIGHT) == 1, "a tap between two frames counts for one frame"


def test_a_recording_says_how_late_its_game_was_seen(live: LiveServer) -> None:
    game = live.new_game()
    tab = str(uuid.uuid4())
    with live.play(game, tab) as player:
        player.begin()
        player.acknowledges = False
        player.until_frame(3)
        player.acknowledge(player.frames[-1].sequence, 41.5)
        fill_window(player, n_before=4)
        time.sleep(0.5)  # frames are dropped meanwhile
        player.acknowledges = True
        player.acknowledge(player.frames[-1].sequence)
        player.until_frame(100)
    with live.play(game, tab) as player:
        hello = player.begin()
        player.acknowledges = False
        message = player.until_frame(hello.frame + 1)
        player.acknowledge(message.sequence, 120.0)
        ended = player.stop()
    latency = live.recording(ended.recording_id)["latency"]
    assert (latency["presses"], latency["p50_ms"], latency["p95_ms"]) == (2, 41.5, 120.0)
    assert latency["frames_dropped"] > 10
    assert latency["is_bad"]
    presses = live.row(ended.recording_id).conditions["play"]["presses"]
    assert presses == [[3, 41.5], [message.frame, 120.0]]


@pytest.mark.parametrize("message", ["{}", '{"type": "shout"}', b"\x01", b"\x09" + bytes(7)])
def test_a_message_that_is_not_of_the_protocol_closes_the_stream(
    live: LiveServer, message: str | bytes
) -> None:
    with live.play(live.new_game()) as player:
        player.until(Hello)
        player.socket.send(message)
        assert player.close_code() == Close.BAD_MESSAGE


def test_a_stream_without_cookie_closes_with_4401(live: LiveServer) -> None:
    path = live.new_game()["stream_path"]
    with connect(f"ws://{live.authority}{path}", compression=None) as socket:
        assert GameClient(socket).close_code() == CLOSE_UNAUTHORISED


@pytest.mark.parametrize(
    "origin", ["http://evil.example", "http://127.0.0.1:1", "https://127.0.0.1", "null"]
)
def test_a_stream_from_a_foreign_page_is_refused(live: LiveServer, origin: str) -> None:
    path = live.new_game()["stream_path"]
    with (
        pytest.raises(InvalidStatus) as refused,
        connect(
            f"ws://{live.authority}{path}",
            additional_headers={"Cookie": cookie(live.settings), "Origin": origin},
        ),
    ):
        pass
    assert refused.value.response.status_code == 403


def test_a_full_disk_pauses_the_game_and_nothing_of_it_is_lost(live: LiveServer) -> None:
    with live.playing(20) as player:
        with full_disk(live.services.database):
            paused = player.until(Paused)
            assert "disk is full" in paused.why
            assert "Free some space" in paused.why
            standing = player.frames[-1].frame
            answer = live.http.patch("/api/player", json={"name": "Somebody"})
            assert answer.status_code == 503
            assert "Free some space" in answer.json()["detail"]
            player.say("stop")
            assert "disk is full" in player.until(Paused).why
        ended = player.until(Ended)
    assert (ended.frame, ended.verification) == (standing, "verified")
    assert live.row(ended.recording_id).n_frames == standing


def test_a_game_taken_over_by_another_process_is_dropped_by_the_first(
    workplace: Workplace,
) -> None:
    data = workplace.settings.data
    with live_server(data) as first, live_server(data) as second:
        game = first.new_game()
        with first.play(game) as before:
            before.begin()
            before.until_frame(70)
            with second.play(game) as after:
                hello = after.until(Hello)
                assert hello.resumed
                assert hello.frame >= 10
                before.until(TakenOver)
                assert before.close_code() == Close.TAKEN_OVER
                after.say("ready")
                after.until_frame(hello.frame + 5)
                assert after.stop().verification == "verified"


def test_games_that_are_left_alone_are_ended_or_kept(workplace: Workplace) -> None:
    rules = PlayRules()
    with live_server(workplace.settings.data) as first:
        game = first.new_game()
        with first.play(game) as player:
            player.begin()
            player.until_frame(30)
        left, empty = game["recording_id"], first.new_game()["recording_id"]
        with first.playing(10) as player:
            undecided = player.stop().recording_id
    with workplace.database.writing() as session:
        for row in games.abandoned(session, after=-games.LEASE):
            row.lease_expires_at = row.created_at - 10 * rules.abandoned_after
        finished = recordings.get(session, undecided)
        assert finished.finished_at is not None
        finished.finished_at -= 2 * rules.decided_after
    with live_server(workplace.settings.data) as second:
        expected = {left: "unfinished", empty: "unfinished", undecided: "kept"}
        wait_until(lambda: {each: second.recording(each)["state"] for each in expected} == expected)
        assert second.recording(left)["verification"] == "verified"
        assert second.recording(empty)["deleted"]
        listed = second.http.get("/api/behaviours/1/recordings").json()
    assert {item["id"] for item in listed} == {left, undecided, *workplace.ranked}
