"""Games over a real WebSocket of a real server."""

from __future__ import annotations

import time
import uuid

import httpx2
import numpy as np
import pytest
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from server.play.rules import PlayRules
from server.play.wire.codec import Screen
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
from testsupport.live import LiveServer, Player, cookie, live_server
from testsupport.waiting import wait_until
from testsupport.workplace import Workplace
from tril.game.controls import Keys
from tril.game.episode import Episode
from tril.game.space_invaders import Action
from tril.recording import replay
from tril.store import games, recordings


def replayed_screens(live: LiveServer, recording_id: int) -> list[Screen]:
    """Return every screen of a stored recording, the start's first."""
    with live.database.reading() as session:
        recording = recordings.as_recording(recordings.get(session, recording_id))
    screens: list[Screen] = []

    def look(episode: Episode) -> None:
        screens.append(episode.console.screen_palette())

    replay(recording, on_frame=look)
    return screens


def heard_until_quiet(player: Player) -> list[object]:
    """Return what comes until nothing does for a while."""
    heard: list[object] = []
    try:
        while True:
            heard.append(player.next(0.3))
    except TimeoutError:
        return heard


def test_the_acknowledged_stream_decodes_to_the_screens_of_a_replay(live: LiveServer) -> None:
    game = live.new_game()
    with live.play(game) as player:
        hello = player.begin()
        assert (hello.frame, hello.resumed, hello.epoch) == (0, False, 1)
        assert [player.until(Countdown).seconds for _ in range(3)] == [2, 1, 0]
        for frame, keys in ((20, Keys.RIGHT | Keys.FIRE), (60, Keys.LEFT), (90, Keys.FIRE)):
            player.until_frame(frame)
            player.hold(keys)
        player.until_frame(130)
        ended = player.stop()
    assert ended.verification == "verified"
    assert ended.reason is None
    screens = replayed_screens(live, ended.recording_id)
    assert len(screens) == ended.frame + 1
    assert set(player.screens) >= set(range(100))
    for frame, screen in player.screens.items():
        np.testing.assert_array_equal(screen, screens[frame])
    recording = live.http.get(f"/api/recordings/{ended.recording_id}").json()
    assert recording["state"] == "finished"
    assert recording["n_frames"] == ended.frame
    assert recording["shots"] >= 1


def test_a_game_that_plays_to_its_end_reports_hits_and_the_reason(live: LiveServer) -> None:
    game = live.new_game(idle_frames=4)
    hits = []
    with live.play(game) as player:
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
    with live.play(game) as late:
        assert late.close_code() == Close.GAME_OVER


def test_a_page_that_acknowledges_nothing_has_six_frames_on_their_way_and_the_game_waits(
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
        player.stop()


def test_a_game_that_its_player_paused_does_not_go_on_by_itself(live: LiveServer) -> None:
    with live.play(live.new_game()) as player:
        player.begin()
        player.acknowledges = False
        assert "stopped drawing" in player.until(Paused).why
        player.say("pause")
        assert "You paused" in player.until(Paused).why
        player.acknowledges = True
        player.acknowledge(player.frames[-1].sequence)
        assert not any(isinstance(message, Countdown) for message in heard_until_quiet(player))
        player.stop()


def test_a_slow_page_sees_the_newest_frame_after_a_gap(live: LiveServer) -> None:
    with live.play(live.new_game()) as player:
        player.acknowledges = False
        player.begin()
        while len(player.frames) < MAX_UNACKNOWLEDGED:
            player.next()
        time.sleep(0.5)  # a page that is busy with something else
        player.acknowledges = True
        player.acknowledge(player.frames[-1].sequence)
        message = player.until(FrameMessage)
        assert message.frame > player.frames[-2].frame + 10
        player.until_frame(message.frame + 20)
        ended = player.stop()
    screens = replayed_screens(live, ended.recording_id)
    for frame, screen in player.screens.items():
        np.testing.assert_array_equal(screen, screens[frame])


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
        assert hello.resumed
        assert hello.frame >= 70
        assert hello.epoch == 2
        first = player.until(FrameMessage)
        assert first.encoded.is_key
        assert first.frame == hello.frame
        player.say("ready")
        player.until_frame(hello.frame + 30)
        ended = player.stop()
    assert ended.verification == "verified"
    screens = replayed_screens(live, ended.recording_id)
    for frame, screen in player.screens.items():
        np.testing.assert_array_equal(screen, screens[frame])


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
    with live.play(live.new_game()) as player:
        player.begin()
        player.until_frame(15)
        player.say("pause")
        assert player.until(Paused).why
        standing = player.frames[-1].frame
        player.say("go_on")
        assert player.until(Countdown).seconds == 2
        assert player.until(FrameMessage).frame == standing + 1
        player.stop()


def test_a_game_in_slow_motion_takes_longer_and_says_so(live: LiveServer) -> None:
    game = live.new_game()
    tab = str(uuid.uuid4())
    with live.play(game, tab) as player:
        assert player.begin().speed_percent == 100
        player.until_frame(10)
        player.say("speed", percent=25)
        player.until_frame(15)
        began = time.monotonic()
        player.until_frame(45)
        assert 1.9 <= time.monotonic() - began < 3.2
    with live.play(game, tab) as player:
        assert player.begin().speed_percent == 25
        player.say("speed", percent=100)
        ended = player.stop()
    assert ended.verification == "verified"
    recording = live.http.get(f"/api/recordings/{ended.recording_id}").json()
    assert (recording["slowest_percent"], recording["single_steps"]) == (25, 0)


def test_single_frames_are_executed_with_the_keys_held(live: LiveServer) -> None:
    with live.play(live.new_game()) as player:
        player.begin()
        player.until_frame(5)
        player.say("pause")
        player.until(Paused)
        standing = player.frames[-1].frame
        player.hold(Keys.LEFT | Keys.FIRE)
        player.hold(Keys.LEFT)
        for _ in range(3):
            player.say("step")
        player.until_frame(standing + 3)
        assert not heard_until_quiet(player)
        ended = player.stop()
    assert ended.frame == standing + 3
    assert ended.verification == "verified"
    with live.database.reading() as session:
        row = recordings.get(session, ended.recording_id)
        assert list(row.actions[-3:]) == [Action.LEFTFIRE, Action.LEFT, Action.LEFT]
        steps = [standing + 1, standing + 2, standing + 3]
        assert row.conditions["play"]["single_steps"] == steps
        assert row.conditions["play"]["pauses"] == [standing]
    assert live.http.get(f"/api/recordings/{ended.recording_id}").json()["single_steps"] == 3


def test_a_step_while_the_game_runs_is_passed_over(live: LiveServer) -> None:
    with live.play(live.new_game()) as player:
        player.begin()
        player.until_frame(5)
        player.say("step")
        player.until_frame(10)
        ended = player.stop()
    assert live.http.get(f"/api/recordings/{ended.recording_id}").json()["single_steps"] == 0


def test_the_game_runs_at_sixty_frames_a_second(live: LiveServer) -> None:
    with live.play(live.new_game()) as player:
        player.begin()
        player.until_frame(10)
        began = time.monotonic()
        player.until_frame(130)
        took = time.monotonic() - began
        player.stop()
    assert 1.9 <= took < 3.2


def test_an_input_is_applied_to_the_next_frame_and_named_by_it(live: LiveServer) -> None:
    with live.play(live.new_game()) as player:
        player.begin()
        player.until_frame(10)
        player.hold(Keys.RIGHT)
        sequence = player.hold(Keys(0))
        applied = player.until(FrameMessage, lambda message: message.input_sequence == sequence)
        player.until_frame(applied.frame + 5)
        ended = player.stop()
    with live.database.reading() as session:
        actions = recordings.get(session, ended.recording_id).actions
    assert actions.count(Action.RIGHT) == 1, "a tap between two frames counts for one frame"


def test_a_recording_says_how_late_its_game_was_seen(live: LiveServer) -> None:
    game = live.new_game()
    tab = str(uuid.uuid4())
    with live.play(game, tab) as player:
        player.begin()
        player.acknowledges = False
        player.until_frame(3)
        player.acknowledge(player.frames[-1].sequence, 41.5)
        while len(player.frames) < 4 + MAX_UNACKNOWLEDGED:
            player.next()
        time.sleep(0.5)  # frames are left out meanwhile
        player.acknowledges = True
        player.acknowledge(player.frames[-1].sequence)
        player.until_frame(100)
    with live.play(game, tab) as player:
        hello = player.begin()
        player.acknowledges = False
        message = player.until_frame(hello.frame + 1)
        player.acknowledge(message.sequence, 120.0)
        ended = player.stop()
    latency = live.http.get(f"/api/recordings/{ended.recording_id}").json()["latency"]
    assert (latency["presses"], latency["p50_ms"], latency["p95_ms"]) == (2, 41.5, 120.0)
    assert latency["frames_dropped"] > 10
    assert latency["is_bad"]
    with live.database.reading() as session:
        conditions = recordings.get(session, ended.recording_id).conditions
    assert conditions["play"]["presses"] == [[3, 41.5], [message.frame, 120.0]]


@pytest.mark.parametrize(
    "message", ["{}", '{"type": "shout"}', b"\x01", b"\x09" + bytes(7), b"\x01\xff" + bytes(6)]
)
def test_a_message_that_is_not_of_the_protocol_closes_the_stream(
    live: LiveServer, message: str | bytes
) -> None:
    with live.play(live.new_game()) as player:
        player.until(Hello)
        player.socket.send(message)
        assert player.close_code() == Close.BAD_MESSAGE


def test_an_unknown_game_closes_with_4404(live: LiveServer) -> None:
    with live.play({"stream_path": f"/api/games/{uuid.uuid4()}/stream"}) as player:
        assert player.close_code() == Close.NO_SUCH_GAME


def test_a_stream_without_cookie_closes_with_4401(live: LiveServer) -> None:
    path = live.new_game()["stream_path"]
    with connect(f"ws://{live.authority}{path}", compression=None) as socket:
        assert Player(socket).close_code() == Close.UNAUTHORISED


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


def test_a_game_goes_on_in_another_server_after_a_restart(workplace: Workplace) -> None:
    data = workplace.settings.data
    with live_server(data) as first:
        game = first.new_game()
        with first.play(game) as player:
            player.begin()
            seen = player.until_frame(40).frame
    with live_server(data) as second, second.play(game) as player:
        hello = player.begin()
        assert hello.resumed
        assert hello.frame >= seen, "a server that stops in good order saves all"
        player.until_frame(hello.frame + 10)
        assert player.stop().verification == "verified"


def test_a_game_taken_over_by_another_process_is_given_up_by_the_first(
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
                ended = after.stop()
    assert ended.verification == "verified"


def test_a_game_that_is_left_alone_becomes_an_unfinished_recording(workplace: Workplace) -> None:
    data = workplace.settings.data
    with live_server(data) as first:
        game = first.new_game()
        empty = first.new_game()
        with first.play(game) as player:
            player.begin()
            player.until_frame(30)
    with workplace.database.writing() as session:
        for row in games.abandoned(session, after=-games.LEASE):
            row.lease_expires_at = row.created_at - 10 * PlayRules().abandoned_after
    with live_server(data) as second:
        recording = _wait_for_end(second.http, game["recording_id"])
        assert (recording["state"], recording["verification"]) == ("unfinished", "verified")
        assert _wait_for_end(second.http, empty["recording_id"])["deleted"]
        listed = second.http.get("/api/behaviours/1/recordings").json()
    assert game["recording_id"] in [item["id"] for item in listed]
    assert empty["recording_id"] not in [item["id"] for item in listed]


def _wait_for_end(http: httpx2.Client, recording_id: int) -> dict[str, object]:
    path = f"/api/recordings/{recording_id}"
    wait_until(lambda: http.get(path).json()["state"] != "playing")
    recording: dict[str, object] = http.get(path).json()
    return recording


def test_a_finished_game_that_nobody_decided_about_is_kept(workplace: Workplace) -> None:
    data = workplace.settings.data
    with live_server(data) as first, first.play(first.new_game()) as player:
        player.begin()
        player.until_frame(10)
        ended = player.stop()
    with workplace.database.writing() as session:
        row = recordings.get(session, ended.recording_id)
        assert row.finished_at is not None
        row.finished_at -= 2 * PlayRules().decided_after
    with live_server(data) as second:
        wait_until(
            lambda: (
                second.http.get(f"/api/recordings/{ended.recording_id}").json()["state"] == "kept"
            )
        )
