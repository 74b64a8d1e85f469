"""Games of Gymnasium environments over a real WebSocket of a real server."""

from __future__ import annotations

import io
import threading
import time
from itertools import count
from typing import Any

import numpy as np
import pytest
from PIL import Image

from server.play.wire.protocol import Countdown, Ended, Hello
from tests.server.clients import replayed, stored
from tests.server.play.slow_env import NAME as SLOW
from tests.server.play.slow_env import STEP_S
from testsupport.live import LiveServer
from testsupport.space_invaders import Keys
from tril.files.cache import sealed

NUMBERS = count(1)


def new_game(live: LiveServer, name: str) -> dict[str, Any]:
    """Begin a game of a new behaviour of this game."""
    answer = live.http.post(
        "/api/behaviours", json={"name": f"Behaviour {next(NUMBERS)}", "game": name}
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
    # The check of the game has made it.
    made = max(live.settings.cache_folder.glob("*.strip"), key=lambda file: file.stat().st_mtime)
    picture = live.http.get(f"/api/recordings/{ended.recording_id}/strip.webp")
    assert picture.status_code == 200, picture.text
    assert sealed(picture.content) == made.read_bytes()
    with Image.open(io.BytesIO(picture.content)) as strip:
        # Eight moments of 160x160 in two columns, then the same, of 80x80, in four.
        assert strip.size == (320, 4 * 160 + 2 * 80)


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


def test_a_slow_environment_does_not_hold_up_other_games(live: LiveServer) -> None:
    slow_game, other_game = new_game(live, SLOW), live.new_game(1)
    over = threading.Event()
    n_slow: list[float] = []

    def play_slowly() -> None:
        with live.play(slow_game) as player:
            player.begin()
            while not over.is_set():
                player.until_frame(len(n_slow) + 1)
                n_slow.append(time.monotonic())

    thread = threading.Thread(target=play_slowly)
    thread.start()
    try:
        with live.play(other_game) as player:
            player.begin()
            player.until_frame(30)
            began, shown = len(n_slow), [time.monotonic()]
            while shown[-1] < shown[0] + 3.0:
                player.next()
                shown.append(time.monotonic())
            n_steps = len(n_slow) - began
    finally:
        over.set()
        thread.join(20.0)
    assert n_steps >= 10
    # In the event loop, each slow step would be a gap of its own length.
    assert (np.diff(shown) >= 0.9 * STEP_S).sum() < n_steps / 2
