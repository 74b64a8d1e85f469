"""Rewinding games, and going on from recordings, over a real WebSocket of a real server."""

from __future__ import annotations

import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

import numpy as np

from server.play.session.rewind import Checkpoints
from server.play.wire.protocol import Countdown, FrameMessage, Hello, Paused, Rewound
from server.play.wire.scene import Scene
from testsupport.live import QUICK, GameClient, LiveServer, live_server
from testsupport.space_invaders import Keys
from testsupport.workplace import Workplace
from tril.games.atari.starts import AtariStart
from tril.games.space_invaders import SPACE_INVADERS
from tril.play.episode import Episode
from tril.recording import Recorder
from tril.store import games, recordings
from tril.store.models import RecordingState, Source


@contextmanager
def playing(
    live: LiveServer, frame: int, keys: Keys = Keys.RIGHT | Keys.FIRE
) -> Iterator[GameClient]:
    """Play a game up to a frame with these keys held."""
    with live.play(live.new_game(start={"idle_frames": 4})) as player:
        player.hold(keys)
        player.begin()
        player.until_frame(frame)
        yield player


def rewind_to(player: GameClient, frame: int) -> Rewound:
    """Rewind to a frame or a little further, and release."""
    player.say("rewind")
    player.until(FrameMessage, lambda message: message.frame <= frame)
    player.say("release")
    return player.until(Rewound)


def test_a_game_goes_on_from_where_the_player_releases_and_both_branches_are_kept(
    live: LiveServer,
) -> None:
    with playing(live, 150) as player:
        seen = dict(player.screens)
        rewound = rewind_to(player, 70)
        assert 0 < rewound.frame <= 70
        for frame in range(rewound.frame, 150):
            # The screens on the way back are those of the way there.
            np.testing.assert_array_equal(player.screens[frame], seen[frame])
        player.hold(Keys.LEFT)
        assert [player.until(Countdown).seconds for _ in range(3)] == [2, 1, 0]
        player.until_frame(rewound.frame + 100)
        ended = player.stop()
    assert ended.verification == "verified"
    before, after = live.recording(rewound.recording_id), live.recording(ended.recording_id)
    assert (before["state"], before["verification"]) == ("kept", "verified")
    assert before["n_frames"] >= 150
    assert before["parent"] is None
    parent = {"recording_id": before["id"], "number": before["number"], "frame": rewound.frame}
    assert after["parent"] == parent
    one, other = live.row(before["id"]).actions, live.row(after["id"]).actions
    assert one[: rewound.frame] == other[: rewound.frame]
    assert one[rewound.frame :][:60] != other[rewound.frame :][:60]
    course = live.http.get(f"/api/recordings/{before['id']}/course").json()
    branch = {"recording_id": after["id"], "number": after["number"], "frame": rewound.frame}
    assert course["branches"] == [branch]


def test_the_whole_game_can_be_rewound(live: LiveServer) -> None:
    with playing(live, 200) as player:
        rewound = rewind_to(player, 0)
        assert (rewound.frame, rewound.hits) == (0, [])
        player.until_frame(30)
        assert player.stop().verification == "verified"


def test_a_game_can_not_be_rewound_without_end(workplace: Workplace) -> None:
    rules = replace(QUICK, rewinds_at_once=2, rewind_every_s=3600.0)
    with live_server(workplace.settings.data, rules) as live, playing(live, 30) as player:
        for _ in range(2):
            rewound = rewind_to(player, 10)
            player.until_frame(rewound.frame + 20)
        before = live.http.get("/api/behaviours/1/recordings").json()
        player.say("rewind")
        assert "very often" in player.until(Paused).why
        player.say("release")
        player.say("go_on")
        player.until_frame(rewound.frame + 60)
        assert live.http.get("/api/behaviours/1/recordings").json() == before
        assert player.stop().verification == "verified"


def test_hits_after_the_frame_are_taken_back(live: LiveServer) -> None:
    with playing(live, 300, Keys.FIRE) as player:
        rewound = rewind_to(player, 200)
        player.hold(Keys(0))
        ended = player.stop()
    before = live.recording(rewound.recording_id)
    assert [hit.frame for hit in rewound.hits] == [
        hit["frame"] for hit in before["hits"] if hit["frame"] <= rewound.frame
    ]
    assert len(rewound.hits) < len(before["hits"])
    assert [hit.frame for hit in ended.hits][: len(rewound.hits)] == [
        hit.frame for hit in rewound.hits
    ]


def test_rewinding_twice_without_playing_keeps_one_branch(live: LiveServer) -> None:
    with playing(live, 150) as player:
        first = rewind_to(player, 120)
        second = rewind_to(player, 80)
        assert second.recording_id == first.recording_id
        assert second.frame <= 80
        player.until_frame(second.frame + 20)
        third = rewind_to(player, second.frame - 10)
        assert third.recording_id > first.recording_id
        ended = player.stop()
    middle = live.recording(third.recording_id)
    number = live.recording(first.recording_id)["number"]
    assert middle["parent"] == {
        "recording_id": first.recording_id,
        "number": number,
        "frame": second.frame,
    }
    assert live.recording(ended.recording_id)["parent"]["recording_id"] == middle["id"]


def test_a_connection_that_breaks_while_rewinding_leaves_the_game_where_it_was(
    live: LiveServer,
) -> None:
    game, tab = live.new_game(start={"idle_frames": 4}), str(uuid.uuid4())
    with live.play(game, tab) as player:
        player.begin()
        player.until_frame(120)
        player.say("rewind")
        player.until(FrameMessage, lambda message: message.frame <= 60)
        player.socket.socket.close()
    with live.play(game, tab) as player:
        hello = player.begin()
        assert hello.frame >= 120
        player.until_frame(hello.frame + 5)
        ended = player.stop()
    assert ended.verification == "verified"
    assert live.recording(ended.recording_id)["parent"] is None


def test_conditions_after_the_frame_are_taken_back_in_a_paused_game(live: LiveServer) -> None:
    with playing(live, 20) as player:
        player.say("speed", percent=50)
        player.until_frame(40)
        player.say("speed", percent=100)
        player.until_frame(100)
        player.say("pause")
        player.until(Paused)
        rewound = rewind_to(player, 30)
        player.until_frame(rewound.frame + 10)
        ended = player.stop()
    assert ended.verification == "verified"
    before = live.row(rewound.recording_id).conditions["play"]
    after = live.row(ended.recording_id).conditions["play"]
    assert [percent for _, percent in before["speeds"]] == [50, 100]
    assert len(before["pauses"]) == 1
    assert after["speeds"] == [before["speeds"][0], [rewound.frame, 100]]
    assert after["pauses"] == []


def test_a_game_resumed_in_another_server_loses_nothing_and_can_be_rewound_past_that(
    workplace: Workplace,
) -> None:
    data = workplace.settings.data
    with live_server(data) as first:
        game = first.new_game(start={"idle_frames": 4})
        with first.play(game) as player:
            player.begin()
            player.until_frame(130)
            seen = dict(player.screens)
    with live_server(data) as second, second.play(game) as player:
        hello = player.until(Hello)
        assert hello.resumed
        assert hello.frame >= max(seen), "a server that stops in good order saves all"
        rewound = rewind_to(player, 20)
        for frame in range(rewound.frame, 100, 20):
            if frame in player.screens:
                np.testing.assert_array_equal(player.screens[frame], seen[frame])
        player.until_frame(rewound.frame + 70)
        assert player.stop().verification == "verified"


def test_a_game_can_go_on_from_a_recording(live: LiveServer) -> None:
    with playing(live, 20, Keys.FIRE) as player:
        player.say("speed", percent=75)
        player.until_frame(150)
        parent = player.stop()
    answer = live.http.post(f"/api/games/from/{parent.recording_id}", json={"frame": 100})
    assert answer.status_code == 201, answer.text
    with live.play(answer.json()) as player:
        hello = player.begin()
        assert (hello.frame, hello.resumed, hello.speed_percent) == (100, True, 75)
        assert [hit.frame for hit in hello.hits] == [
            hit.frame for hit in parent.hits if hit.frame <= 100
        ]
        player.until_frame(120)
        ended = player.stop()
    assert ended.verification == "verified"
    after = live.recording(ended.recording_id)
    number = live.recording(parent.recording_id)["number"]
    assert after["parent"] == {
        "recording_id": parent.recording_id,
        "number": number,
        "frame": 100,
    }
    assert after["slowest_percent"] == 75
    assert live.recording(parent.recording_id)["n_frames"] == parent.frame


def test_a_game_can_not_go_on_from_frames_that_were_not_played(live: LiveServer) -> None:
    with live.playing(10) as player:
        parent = player.stop()
    for frame in (-1, 1201, 900):
        answer = live.http.post(f"/api/games/from/{parent.recording_id}", json={"frame": frame})
        assert answer.status_code == 422


def test_a_game_can_not_go_on_from_one_that_is_being_played(live: LiveServer) -> None:
    game = live.new_game(start={"idle_frames": 4})
    answer = live.http.post(f"/api/games/from/{game['recording_id']}", json={"frame": 0})
    assert answer.status_code == 409
    assert live.http.post("/api/games/from/99999", json={"frame": 0}).status_code == 404


def test_a_game_can_not_go_on_from_what_no_person_played(live: LiveServer) -> None:
    scripted = live.http.get("/api/behaviours/1/recordings").json()[-1]
    assert scripted["source"] == "scripted"
    answer = live.http.post(f"/api/games/from/{scripted['id']}", json={"frame": 10})
    assert answer.status_code == 409
    assert "no person's game" in answer.json()["detail"]


def test_of_a_branch_that_was_never_played_nothing_is_left(workplace: Workplace) -> None:
    with workplace.database.writing() as session:
        parent = recordings.listing(session, 1)[0]
        parent.source = Source.PERSON
        game = games.create_from(session, parent, 100, None)
        row = games.acquire(session, game.id, "a", "tab")
        assert games.end(session, row.id, row.epoch, RecordingState.UNFINISHED, None)
        assert row.recording.deleted_at is not None


def test_an_owner_that_lost_its_game_can_not_branch_it(workplace: Workplace) -> None:
    with workplace.database.writing() as session:
        parent = recordings.listing(session, 1)[0]
        parent.source = Source.PERSON
        game = games.create_from(session, parent, 100, None)
        games.acquire(session, game.id, "a", "tab")
        recording = recordings.as_recording(game.recording)
        recorder = Recorder.resume(recording, SPACE_INVADERS.make_console())
        lost = games.Progress(game.id, 0, recorder.recording(), recorder.replay())
        assert games.branch(session, lost, lost, None) is None


def test_checkpoints_give_every_scene_whether_the_states_are_there_or_not() -> None:
    rng = np.random.default_rng(3)
    console, checkpoints = SPACE_INVADERS.make_console(), Checkpoints()
    recorder = Recorder(Episode(console, AtariStart(9)))
    expected = [Scene.of(recorder.episode)]
    while recorder.episode.frame < 200 and recorder.episode.end is None:
        checkpoints.add_if_due(recorder.episode)
        recorder.advance(int(rng.integers(6)))
        expected.append(Scene.of(recorder.episode))
    recording, other = recorder.recording(), SPACE_INVADERS.make_console()
    for known in (checkpoints, Checkpoints()):
        for last in (recording.n_frames, 125, 120, 119, 1, 0):
            given = known.scenes(recording, last, other)
            assert max(given) == last
            assert min(given) == last - last % 60
            for frame, scene in given.items():
                np.testing.assert_array_equal(scene.screen, expected[frame].screen)
                assert scene.frame == frame
                assert scene.marks == expected[frame].marks
                assert scene.counted == expected[frame].counted
    checkpoints.discard_after(100)
    state = checkpoints.latest_until(500)
    assert state is not None
    assert len(state.actions) == 60


def test_a_game_resumed_near_a_checkpoint_is_the_game() -> None:
    rng = np.random.default_rng(4)
    checkpoints, recorder = (
        Checkpoints(),
        Recorder(Episode(SPACE_INVADERS.make_console(), AtariStart(9))),
    )
    for action in rng.integers(6, size=190).tolist():
        checkpoints.add_if_due(recorder.episode)
        recorder.advance(action)
    until = recorder.recording().until(170)
    resumed = Recorder.resume(
        until, SPACE_INVADERS.make_console(), nearest_state=checkpoints.latest_until(170)
    )
    assert resumed.recording() == until
    assert resumed.replay() == Recorder.resume(until, SPACE_INVADERS.make_console()).replay()
    for action in recorder.episode.actions[170:]:
        resumed.advance(action)
    assert resumed.recording() == recorder.recording()
    assert resumed.episode.console.state_hash() == recorder.episode.console.state_hash()
