"""Games that are run back and go on from there, over a real WebSocket of a real server."""

from __future__ import annotations

import uuid
from typing import Any

import numpy as np
import pytest

from server.play.session.rewind import Checkpoints
from server.play.wire.protocol import Countdown, FrameMessage, Hello, Paused, Rewound
from server.play.wire.scene import Scene
from tests.server.live import LiveServer, Player, live_server
from tests.workplace import Workplace
from tril.game.console import Console
from tril.game.controls import Keys
from tril.game.episode import Episode, Start
from tril.recording import Recorder
from tril.store import games, recordings
from tril.store.models import RecordingState, Source


def play_until(player: Player, frame: int) -> None:
    """Fire and go to the right until a frame."""
    player.hold(Keys.RIGHT | Keys.FIRE)
    player.begin()
    player.until_frame(frame)


def run_back_to(player: Player, frame: int) -> Rewound:
    """Run the game back to a frame or a little further, and let go."""
    player.say("rewind")
    player.until(FrameMessage, lambda message: message.frame <= frame)
    player.say("release")
    return player.until(Rewound)


def shown(live: LiveServer, recording_id: int) -> dict[str, Any]:
    """Return a recording as the API shows it."""
    recording: dict[str, Any] = live.http.get(f"/api/recordings/{recording_id}").json()
    return recording


def actions_of(live: LiveServer, recording_id: int) -> bytes:
    """Return the actions of a stored recording."""
    with live.database.reading() as session:
        return recordings.get(session, recording_id).actions


def test_a_game_goes_on_from_where_the_player_lets_go_and_both_branches_are_kept(
    live: LiveServer,
) -> None:
    with live.play(live.new_game(idle_frames=4)) as player:
        play_until(player, 150)
        seen = dict(player.screens)
        rewound = run_back_to(player, 70)
        assert 0 < rewound.frame <= 70
        for frame in range(rewound.frame, 150):
            # The screens on the way back are those of the way there.
            np.testing.assert_array_equal(player.screens[frame], seen[frame])
        player.hold(Keys.LEFT)
        assert [player.until(Countdown).seconds for _ in range(3)] == [2, 1, 0]
        player.until_frame(rewound.frame + 100)
        ended = player.stop()
    assert ended.verification == "verified"
    before, after = shown(live, rewound.recording_id), shown(live, ended.recording_id)
    assert (before["state"], before["verification"]) == ("kept", "verified")
    assert before["n_frames"] >= 150
    assert before["parent"] is None
    assert after["parent"] == {"recording_id": before["id"], "frame": rewound.frame}
    one, other = actions_of(live, before["id"]), actions_of(live, after["id"])
    assert one[: rewound.frame] == other[: rewound.frame]
    assert one[rewound.frame :][:60] != other[rewound.frame :][:60]
    course = live.http.get(f"/api/recordings/{before['id']}/course").json()
    assert course["branches"] == [{"recording_id": after["id"], "frame": rewound.frame}]


def test_the_whole_game_can_be_run_back(live: LiveServer) -> None:
    with live.play(live.new_game(idle_frames=4)) as player:
        play_until(player, 200)
        player.say("rewind")
        start = player.until(FrameMessage, lambda message: message.frame == 0)
        np.testing.assert_array_equal(player.screens[start.frame], player.screens[0])
        player.say("release")
        rewound = player.until(Rewound)
        assert (rewound.frame, rewound.hits) == (0, [])
        player.until_frame(30)
        assert player.stop().verification == "verified"


def test_hits_after_the_frame_are_taken_back(live: LiveServer) -> None:
    with live.play(live.new_game(idle_frames=4)) as player:
        player.hold(Keys.FIRE)
        player.begin()
        player.until_frame(300)
        rewound = run_back_to(player, 200)
        player.hold(Keys(0))
        ended = player.stop()
    before = shown(live, rewound.recording_id)
    assert [hit.frame for hit in rewound.hits] == [
        hit["frame"] for hit in before["hits"] if hit["frame"] <= rewound.frame
    ]
    assert len(rewound.hits) < len(before["hits"])
    assert [hit.frame for hit in ended.hits][: len(rewound.hits)] == [
        hit.frame for hit in rewound.hits
    ]


def test_running_back_twice_without_playing_keeps_one_branch(live: LiveServer) -> None:
    with live.play(live.new_game(idle_frames=4)) as player:
        play_until(player, 150)
        first = run_back_to(player, 120)
        second = run_back_to(player, 80)
        assert second.recording_id == first.recording_id
        assert second.frame <= 80
        player.until_frame(second.frame + 20)
        third = run_back_to(player, second.frame - 10)
        assert third.recording_id > first.recording_id
        ended = player.stop()
    middle = shown(live, third.recording_id)
    assert middle["parent"] == {"recording_id": first.recording_id, "frame": second.frame}
    assert shown(live, ended.recording_id)["parent"]["recording_id"] == middle["id"]


def test_a_connection_that_breaks_on_the_way_back_leaves_the_game_where_it_was(
    live: LiveServer,
) -> None:
    game, tab = live.new_game(idle_frames=4), str(uuid.uuid4())
    with live.play(game, tab) as player:
        play_until(player, 120)
        player.say("rewind")
        player.until(FrameMessage, lambda message: message.frame <= 60)
        player.socket.socket.close()
    with live.play(game, tab) as player:
        hello = player.begin()
        assert hello.frame >= 120
        player.until_frame(hello.frame + 5)
        ended = player.stop()
    assert ended.verification == "verified"
    assert shown(live, ended.recording_id)["parent"] is None


def test_a_paused_game_can_be_run_back(live: LiveServer) -> None:
    with live.play(live.new_game(idle_frames=4)) as player:
        play_until(player, 90)
        player.say("pause")
        player.until(Paused)
        rewound = run_back_to(player, 40)
        player.until_frame(rewound.frame + 10)
        assert player.stop().verification == "verified"


def test_what_was_noted_of_frames_that_were_run_back_is_taken_back_too(live: LiveServer) -> None:
    with live.play(live.new_game(idle_frames=4)) as player:
        play_until(player, 20)
        player.say("speed", percent=50)
        player.until_frame(40)
        player.say("speed", percent=100)
        player.until_frame(100)
        player.say("pause")
        player.until(Paused)
        rewound = run_back_to(player, 30)
        ended = player.stop()
    with live.database.reading() as session:
        before = recordings.get(session, rewound.recording_id).conditions["play"]
        after = recordings.get(session, ended.recording_id).conditions["play"]
    assert [percent for _, percent in before["speeds"]] == [50, 100]
    assert len(before["pauses"]) == 1
    assert after["speeds"] == [before["speeds"][0], [rewound.frame, 100]]
    assert after["pauses"] == []


def test_a_game_that_was_taken_up_again_can_be_run_back_past_that(workplace: Workplace) -> None:
    data = workplace.settings.data
    with live_server(data) as first:
        game = first.new_game(idle_frames=4)
        with first.play(game) as player:
            play_until(player, 130)
            seen = dict(player.screens)
    with live_server(data) as second, second.play(game) as player:
        player.until(Hello)
        rewound = run_back_to(player, 20)
        assert rewound.frame <= 20
        for frame in range(rewound.frame, 100, 20):
            if frame in player.screens:
                np.testing.assert_array_equal(player.screens[frame], seen[frame])
        player.until_frame(rewound.frame + 70)
        assert player.stop().verification == "verified"


def test_a_game_can_go_on_from_a_recording(live: LiveServer) -> None:
    with live.play(live.new_game(idle_frames=4)) as player:
        player.hold(Keys.FIRE)
        player.begin()
        player.until_frame(20)
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
    after = shown(live, ended.recording_id)
    assert after["parent"] == {"recording_id": parent.recording_id, "frame": 100}
    assert after["slowest_percent"] == 75
    assert shown(live, parent.recording_id)["n_frames"] == parent.frame


@pytest.mark.parametrize(("frame", "status"), [(-1, 422), (1201, 422), (900, 422)])
def test_a_game_can_not_go_on_from_frames_that_were_not_played(
    live: LiveServer, frame: int, status: int
) -> None:
    with live.play(live.new_game(idle_frames=4)) as player:
        player.begin()
        player.until_frame(10)
        parent = player.stop()
    answer = live.http.post(f"/api/games/from/{parent.recording_id}", json={"frame": frame})
    assert answer.status_code == status


def test_a_game_can_not_go_on_from_one_that_is_being_played(live: LiveServer) -> None:
    game = live.new_game(idle_frames=4)
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
        row = games.claim(session, game.id, "a", "tab")
        assert games.end(session, row.id, row.epoch, RecordingState.UNFINISHED, None)
        assert row.recording.deleted_at is not None


def test_an_owner_that_lost_its_game_can_not_branch_it(workplace: Workplace) -> None:
    with workplace.database.writing() as session:
        parent = recordings.listing(session, 1)[0]
        parent.source = Source.PERSON
        game = games.create_from(session, parent, 100, None)
        games.claim(session, game.id, "a", "tab")
        recording = recordings.as_recording(game.recording)
        recorder = Recorder.resume(recording, Console())
        lost = games.Progress(game.id, 0, recorder.recording(), recorder.replay())
        assert games.branch(session, lost, lost, None) is None


def test_a_checkpoints_gives_every_scene_whether_its_states_are_there_or_not() -> None:
    rng = np.random.default_rng(3)
    console, checkpoints = Console(), Checkpoints()
    recorder = Recorder(Episode(console, Start(9)))
    expected = [Scene.of(recorder.episode)]
    while recorder.episode.frame < 200 and recorder.episode.end is None:
        checkpoints.add_if_due(recorder.episode)
        recorder.advance(int(rng.integers(6)))
        expected.append(Scene.of(recorder.episode))
    recording, other = recorder.recording(), Console()
    for known in (checkpoints, Checkpoints()):
        for last in (recording.n_frames, 125, 120, 119, 1, 0):
            given = known.scenes(recording, last, other)
            assert max(given) == last
            assert min(given) == last - last % 60
            for frame, scene in given.items():
                np.testing.assert_array_equal(scene.screen, expected[frame].screen)
                assert scene.frame == frame
                assert scene.formation == expected[frame].formation
                assert scene.shots == expected[frame].shots
    checkpoints.discard_after(100)
    state = checkpoints.latest_until(500)
    assert state is not None
    assert len(state.actions) == 60


def test_a_game_resumed_near_a_state_is_the_game() -> None:
    rng = np.random.default_rng(4)
    checkpoints, recorder = Checkpoints(), Recorder(Episode(Console(), Start(9)))
    for action in rng.integers(6, size=190).tolist():
        checkpoints.add_if_due(recorder.episode)
        recorder.advance(action)
    until = recorder.recording().until(170)
    resumed = Recorder.resume(until, Console(), near=checkpoints.latest_until(170))
    assert resumed.recording() == until
    assert resumed.replay() == Recorder.resume(until, Console()).replay()
    for action in recorder.episode.actions[170:]:
        resumed.advance(action)
    assert resumed.recording() == recorder.recording()
    assert resumed.episode.console.ram_hash() == recorder.episode.console.ram_hash()
