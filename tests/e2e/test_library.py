"""The library in a real browser: filters, bulk actions, a recording frame by frame, clips."""

from __future__ import annotations

import base64
import io
import math
import re
from collections.abc import Iterator

import av
import numpy as np
import numpy.typing as npt
import pytest
from PIL import Image
from playwright.sync_api import Browser, FloatRect, Page, expect

from server.web.pages import FRONTEND
from tests.e2e.pages import DESKTOP, signed_in
from testsupport.live import LiveServer, live_server
from testsupport.workplace import FRAMES, Workplace
from tril.games.atari.palette import palette_rgb
from tril.play.episode import Episode
from tril.recording import replay
from tril.store import recordings


@pytest.fixture(scope="module")
def built(shared_workplace: Workplace) -> Iterator[LiveServer]:
    """Return a running server with the built pages."""
    with live_server(shared_workplace.settings.data, frontend=FRONTEND) as running:
        yield running


@pytest.fixture
def page(browser: Browser, built: LiveServer) -> Iterator[Page]:
    """Return the library of column 1; errors in its console fail the test."""
    with signed_in(browser, built, "/behaviours/1/recordings", viewport=DESKTOP) as page:
        yield page


def screens_of(workplace: Workplace, recording_id: int) -> npt.NDArray[np.uint8]:
    """Return what a replay shows, uint8 (frames + 1, 210, 160, 3)."""
    with workplace.database.reading() as session:
        recording = recordings.as_recording(recordings.get(session, recording_id))
    seen: list[npt.NDArray[np.uint8]] = []

    def look(episode: Episode) -> None:
        seen.append(palette_rgb()[episode.console.screen()])

    replay(recording, on_frame=look)
    return np.array(seen)


def shown_on(page: Page) -> npt.NDArray[np.uint8]:
    """Return what the game's canvas shows, uint8 (210, 160, 3)."""
    canvas = page.get_by_role("img", name="Game screen")
    url = str(canvas.evaluate("(canvas) => canvas.toDataURL('image/png')"))
    content = base64.b64decode(url.partition(",")[2])
    return np.asarray(Image.open(io.BytesIO(content)).convert("RGB"))


def test_every_key_and_press_leads_to_exactly_its_frame(
    page: Page, shared_workplace: Workplace
) -> None:
    moving = shared_workplace.ranked[3]
    expected = screens_of(shared_workplace, moving)
    page.goto(f"/recordings/{moving}?frame=100")
    slider = page.get_by_role("slider", name="Position in the recording")

    def at(frame: int) -> None:
        expect(slider).to_have_value(str(frame))
        np.testing.assert_array_equal(shown_on(page), expected[frame])

    at(100)
    for key, frame in [
        ("ArrowRight", 101),
        ("Shift+ArrowRight", 105),
        ("ArrowLeft", 104),
        ("Shift+ArrowLeft", 100),
        ("End", FRAMES),
        ("ArrowLeft", FRAMES - 1),
        ("Home", 0),
    ]:
        page.keyboard.press(key)
        at(frame)
    expect(page.get_by_text("Action of frame 0: the start")).to_be_visible()
    box = slider.bounding_box()
    assert box is not None
    page.mouse.click(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    assert abs(int(slider.input_value()) - FRAMES // 2) <= 1
    at(int(slider.input_value()))
    expect(page.get_by_text(re.compile("Action of frame .*: right and fire"))).to_be_visible()


def test_the_address_keeps_the_filters_and_a_deletion_of_several_is_undone(
    page: Page, shared_workplace: Workplace
) -> None:
    cards = page.get_by_role("article")
    expect(cards).to_have_count(4)
    page.get_by_label("Show").select_option("Perfect ones")
    expect(cards).to_have_count(1)
    page.reload()
    expect(cards).to_have_count(1)
    page.get_by_role("button", name="Clear the filters").click()
    expect(cards).to_have_count(4)

    first, *_, last = sorted(shared_workplace.ranked)
    page.get_by_label(f"Select Recording {last}").click()
    page.get_by_label(f"Select Recording {first + 1}").click(modifiers=["Shift"])
    bar = page.get_by_role("group", name="Selected recordings")
    expect(bar).to_contain_text("3 recordings selected")
    bar.get_by_role("button", name="Delete").click()
    expect(cards).to_have_count(1)
    page.get_by_role("button", name="Undo").click()
    expect(cards).to_have_count(4)


def test_a_card_loops_through_the_moments_of_its_strip_while_it_is_pointed_at(page: Page) -> None:
    card = page.get_by_role("article").first
    picture = card.locator("img").first
    content = page.request.get(str(picture.get_attribute("src"))).body()
    with Image.open(io.BytesIO(content)) as strip:
        sheet = np.asarray(strip.convert("RGB"))
    moments = sheet[: 4 * 210].reshape(4, 210, 2, 160, 3).swapaxes(1, 2).reshape(8, 210, 160, 3)

    def shown() -> npt.NDArray[np.uint8]:
        expect(picture).to_have_js_property("complete", True)
        box = picture.locator("..").bounding_box()
        assert box is not None
        # Browsers paint on whole pixels.
        left, top = math.floor(box["x"] + 0.5), math.floor(box["y"] + 0.5)
        clip: FloatRect = {"x": left, "y": top, "width": 320, "height": 210}
        png = page.screenshot(clip=clip, animations="allow")
        return np.asarray(Image.open(io.BytesIO(png)).convert("RGB"))

    def doubled(moment: npt.NDArray[np.uint8]) -> npt.NDArray[np.uint8]:
        return moment.repeat(2, axis=1)

    np.testing.assert_array_equal(shown(), doubled(moments[-1]))
    heading = page.get_by_role("heading", name="4 recordings")
    for begin in (card.hover, card.get_by_role("button", name=re.compile("Watch")).focus):
        page.keyboard.press("Shift")  # what gets the focus from now on shows it
        begin()
        seek = """(image, ms) => image.getAnimations().map((one) => {
            one.pause();
            one.currentTime = ms;
        }).length"""
        for place, moment in enumerate(moments):
            assert picture.evaluate(seek, 150 + 350 * place + 100) == 1
            np.testing.assert_array_equal(shown(), doubled(moment))
        heading.hover()
        page.evaluate("document.activeElement.blur()")
        np.testing.assert_array_equal(shown(), doubled(moments[-1]))
    page.emulate_media(reduced_motion="reduce")
    card.hover()
    assert picture.evaluate("(image) => image.getAnimations().length") == 0


def test_a_video_and_the_data_are_downloaded(page: Page, shared_workplace: Workplace) -> None:
    best = shared_workplace.ranked[0]
    page.get_by_role("link", name=f"Recording {best}", exact=True).click()
    with page.expect_download(timeout=60_000) as download:
        page.get_by_role("button", name="MP4").click()
    assert download.value.suggested_filename == f"column-1-recording-{best}.mp4"
    with av.open(str(download.value.path()), "r") as video:
        assert sum(1 for _ in video.decode(video=0)) == FRAMES + 1
    with page.expect_download() as download:
        page.get_by_role("link", name="Data (JSON)").click()
    assert download.value.suggested_filename == f"column-1-recording-{best}.json"
