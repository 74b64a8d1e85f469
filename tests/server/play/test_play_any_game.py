"""Games of Gymnasium environments over a real WebSocket of a real server."""

from __future__ import annotations

import io
from typing import Any

import numpy as np
import pytest
from PIL import Image

from server.play.wire.protocol import Countdown, Ended, Hello
from tests.server.clients import replayed, stored
from testsupport.live import LiveServer
from testsupport.space_invaders import Keys


def new_game(live: LiveServer, name: str) -> dict[str, Any]:
    """Begin a game of a new behaviour of this game."""
    answer = live.http.post(
        "/api/behaviours", json={"name": f"A behaviour of {name}"[:60], "game": name}
    )
    assert answer.status_code == 201, answer.text
    return live.new_game(answer.json()["id"])


def test_a_game_that_waits_stands_still_until_a_button_is_held(live: LiveServer) -> None:
    """Button 0 turns left, button 2 walks; what is executed is what is recorded."""
    with live.play(new_game(live, "gym:MiniGrid-DoorKey-5x5-v0")) as player:
        hello = player.until(Hello)
        assert hello.palette is None
        player.say("ready")
        player.until(Countdown, lambda message: message.seconds == 0)
        with pytest.raises(TimeoutError):
            player.next(1.0)
        player.hold(Keys(1))
        player.until_frame(3)
        player.hold(Keys(0))
        ended = player.stop()
    assert (ended.verification, ended.reason) == ("verified", None)
    recording = stored(live.database, ended.recording_id)
    assert set(recording.actions) == {0}
    screens = replayed(recording, lambda console: console.screen())
    for frame, screen in player.screens.items():
        np.testing.assert_array_equal(screen, screens[frame])
    picture = live.http.get(f"/api/recordings/{ended.recording_id}/thumbnail.png")
    assert picture.status_code == 200, picture.text
    with Image.open(io.BytesIO(picture.content)) as thumbnail:
        assert thumbnail.size == (160, 160)


def test_a_game_that_is_over_tells_so_and_is_kept(live: LiveServer) -> None:
    with live.play(new_game(live, "gym:CartPole-v1")) as player:
        player.hold(Keys(1))
        player.begin()
        ended = player.until(Ended)
    assert (ended.verification, ended.reason) == ("verified", "over")
    kept = live.http.post(f"/api/recordings/{ended.recording_id}/keep").json()
    assert (kept["state"], kept["n_frames"]) == ("kept", ended.frame)
    assert live.http.get(f"/api/recordings/{ended.recording_id}/frames").status_code == 200
    assert live.http.get(f"/api/recordings/{ended.recording_id}/memory").status_code == 404


def test_an_environment_that_cannot_be_played_is_refused_with_the_reason(live: LiveServer) -> None:
    answer = live.http.post("/api/behaviours", json={"name": "Swing", "game": "gym:Pendulum-v1"})
    assert answer.status_code == 422
    assert "discrete actions" in answer.text
