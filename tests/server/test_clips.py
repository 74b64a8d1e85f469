"""Recordings as GIF, WebP and MP4."""

from __future__ import annotations

import io
import threading
from dataclasses import replace

import av
import numpy as np
import numpy.typing as npt
import pytest
from PIL import Image, ImageSequence
from starlette.testclient import TestClient

from server.clips import ClipKind, ClipMaker
from server.clips.render import frames_per_picture, render
from tests.server.clients import replayed, stored
from testsupport.workplace import FRAMES, Workplace
from tril.errors import Invalid, Unavailable
from tril.files.cache import sealed
from tril.games import game_named
from tril.games.atari.palette import palette_grayscale, palette_rgb
from tril.play.screens import brightest
from tril.recording import Recording

FRAMES_PER_PICTURE, PICTURE_MS = 3, 50


def pictures_of(screens: npt.NDArray[np.uint8]) -> npt.NDArray[np.uint8]:
    """Return the brightest of every three screens, the last one or two included."""
    groups = range(0, len(screens), FRAMES_PER_PICTURE)
    gray = palette_grayscale()
    return np.array([brightest(screens[at : at + FRAMES_PER_PICTURE], gray) for at in groups])


@pytest.fixture
def recording(workplace: Workplace) -> Recording:
    return stored(workplace.database, workplace.ranked[3])


@pytest.fixture
def screens(recording: Recording) -> npt.NDArray[np.uint8]:
    return np.array(replayed(recording, lambda console: console.screen()))


def clip(client: TestClient, recording_id: int, kind: str) -> bytes:
    answer = client.get(f"/api/recordings/{recording_id}/clip.{kind}")
    assert answer.status_code == 200, answer.text
    number = client.get(f"/api/recordings/{recording_id}").json()["number"]
    name = f'filename="column-1-recording-{number}.{kind}"'
    assert name in answer.headers["content-disposition"]
    return answer.content


@pytest.mark.parametrize("kind", ["gif", "webp"])
def test_pictures_show_the_brightest_of_every_three_frames_in_their_own_colours(
    client: TestClient, workplace: Workplace, screens: npt.NDArray[np.uint8], kind: str
) -> None:
    expected = palette_rgb()[pictures_of(screens).repeat(2, axis=2)]
    at_ms = 0
    with Image.open(io.BytesIO(clip(client, workplace.ranked[3], kind))) as animation:
        # Pictures that equal the one before may be one that is shown for longer.
        for picture in ImageSequence.Iterator(animation):
            shown = np.asarray(picture.convert("RGB"))
            lasts_ms = int(picture.info["duration"])
            for moment in range(at_ms, at_ms + lasts_ms, PICTURE_MS):
                np.testing.assert_array_equal(shown, expected[moment // PICTURE_MS])
            at_ms += lasts_ms
    assert at_ms == len(expected) * PICTURE_MS == -(-(FRAMES + 1) // 3) * 50


def test_a_video_has_every_frame_at_60_hz_and_looks_the_same(
    client: TestClient, workplace: Workplace, screens: npt.NDArray[np.uint8]
) -> None:
    with av.open(io.BytesIO(clip(client, workplace.ranked[3], "mp4")), "r") as video:
        stream = video.streams.video[0]
        assert (stream.codec_context.name, stream.pix_fmt) == ("h264", "yuv420p")
        assert (stream.width, stream.height) == (640, 420)
        assert stream.average_rate == 60
        frames = [frame.to_ndarray(format="rgb24") for frame in video.decode(stream)]
    assert len(frames) == FRAMES + 1
    expected = palette_rgb()[screens].repeat(4, axis=2).repeat(2, axis=1)
    errors = [
        np.abs(frame.astype(int) - screen).mean()
        for frame, screen in zip(frames, expected, strict=True)
    ]
    assert max(errors) < 2


def test_what_is_drawn_in_one_frame_of_three_only_is_shown(
    screens: npt.NDArray[np.uint8],
) -> None:
    pictures = pictures_of(screens)
    assert len(pictures) == -(-len(screens) // FRAMES_PER_PICTURE)
    gray = palette_grayscale()
    for index, picture in enumerate(pictures):
        among = screens[index * 3 : index * 3 + 3]
        np.testing.assert_array_equal(gray[picture], gray[among].max(axis=0))


@pytest.mark.parametrize("name", ["gym:CartPole-v1", "gym:MiniGrid-DoorKey-5x5-v0"])
def test_games_in_red_green_and_blue_have_clips_at_their_own_rate(name: str) -> None:
    game = game_named(name)
    actions = bytes(number % game.controls.n_actions for number in range(8))
    recording = Recording(game, game.starts.training[0], actions)
    screens = replayed(recording, lambda console: console.screen())
    with av.open(io.BytesIO(render(recording, ClipKind.MP4)), "r") as video:
        assert video.streams.video[0].average_rate == game.clock.frame_rate_hz
        frames = [frame.to_ndarray(format="rgb24") for frame in video.decode(video=0)]
    assert len(frames) == len(screens) == 9
    for frame, screen in zip(frames, screens, strict=True):
        expected = screen.repeat(2, axis=0).repeat(2, axis=1)
        assert np.abs(frame.astype(int) - expected).mean() < 3
    n = frames_per_picture(game.clock)
    with Image.open(io.BytesIO(render(recording, ClipKind.WEBP))) as animation:
        shown = np.asarray(animation.convert("RGB"))
        assert animation.info["duration"] == n * 1000 // game.clock.frame_rate_hz
    np.testing.assert_array_equal(shown, screens[n - 1])
    with Image.open(io.BytesIO(render(recording, ClipKind.GIF))) as animation:
        assert animation.size == (game.screen.width, game.screen.height)


def test_a_clip_is_made_once(client: TestClient, workplace: Workplace) -> None:
    first = clip(client, workplace.ranked[0], "gif")
    (kept,) = workplace.settings.cache_folder.glob("*.gif")
    assert kept.read_bytes() == sealed(first)
    kept.write_bytes(sealed(b"kept"))
    assert clip(client, workplace.ranked[0], "gif") == b"kept"


def test_an_unknown_kind_or_recording_is_refused(client: TestClient, workplace: Workplace) -> None:
    assert client.get(f"/api/recordings/{workplace.ranked[0]}/clip.avi").status_code == 422
    assert client.get("/api/recordings/99999/clip.gif").status_code == 404


def test_a_recording_that_does_not_replay_is_refused_with_the_reason(recording: Recording) -> None:
    wrong = replace(recording, hashes=("0" * 16, *recording.hashes[1:]))
    with pytest.raises(Invalid, match="after frame 60"):
        ClipMaker().make(wrong, ClipKind.GIF)


def test_one_that_takes_too_long_is_given_up(recording: Recording) -> None:
    with pytest.raises(Unavailable, match="too long"):
        ClipMaker(timeout_s=0.01).make(recording, ClipKind.GIF)


def test_only_so_many_wait_for_their_turn(
    recording: Recording, monkeypatch: pytest.MonkeyPatch
) -> None:
    going, go_on = threading.Event(), threading.Event()

    def run(_self: ClipMaker, _request: bytes) -> bytes:
        going.set()
        assert go_on.wait(60)
        return b"clip"

    monkeypatch.setattr(ClipMaker, "_run", run)
    maker = ClipMaker(max_waiting=0)
    made: list[bytes] = []
    first = threading.Thread(target=lambda: made.append(maker.make(recording, ClipKind.GIF)))
    first.start()
    assert going.wait(60)
    with pytest.raises(Unavailable, match="Several clips"):
        maker.make(recording, ClipKind.MP4)
    go_on.set()
    first.join()
    assert made == [b"clip"]
    assert maker.make(recording, ClipKind.WEBP) == b"clip"
