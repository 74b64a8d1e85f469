"""What a newcomer does, in one go: play, rank by mouse and by keyboard, train, look."""

from __future__ import annotations

import json
import re
import sqlite3
import time
from contextlib import closing
from pathlib import Path

from playwright.sync_api import Locator, Page, expect

from testsupport.page_actions import drag_into, handle_of
from testsupport.processes import TrilProcess
from testsupport.workplace import TINY
from tril.recipes import with_values

DATA = Path(__file__).parents[1] / "data" / "column-1.jsonl"
GAME_TIMEOUT_MS = 45_000
RUN_TIMEOUT_MS = 400_000
REWARD_TIMEOUT_MS = 60_000
"""The recording is replayed and judged by the reward model, whatever else the machine does."""
BEHAVIOUR_1 = re.compile(r"/behaviours/\d+")


def test_play_rank_train_and_look(page: Page, tmp_path: Path, running_tril: TrilProcess) -> None:
    shrink_runs(running_tril.settings.data / "tril.sqlite")
    page.get_by_role("link", name=re.compile("Column 1")).first.click()
    page.wait_for_url(BEHAVIOUR_1)
    _play_for_twenty_seconds(page)
    _import_three(page, tmp_path)
    _rank(page)
    _train(page)
    _look(page)
    _follow_the_reward(page)


def shrink_runs(path: Path) -> None:
    """Let every run that is made in a database go through its stages at their smallest.

    The page offers no such recipe, and a worker takes a run as soon as it is there.
    """
    recipe = json.dumps(with_values(TINY, {"name": "fast"}).to_dict()).replace("'", "''")
    with closing(sqlite3.connect(path)) as database:
        database.execute(
            "CREATE TRIGGER smallest AFTER INSERT ON runs"
            f" BEGIN UPDATE runs SET recipe = '{recipe}' WHERE id = NEW.id; END"
        )


def _play_for_twenty_seconds(page: Page) -> None:
    """Play by real key events until the game ends, then keep it as perfect."""
    page.get_by_role("navigation", name="Path").get_by_role("link", name="Play").click()
    page.get_by_role("button", name="Start game").click()
    canvas = page.get_by_role("img", name="Game screen")
    expect(canvas).to_be_visible()
    expect(page.get_by_role("timer", name="Time left")).not_to_contain_text(
        "20.0 s", timeout=20_000
    )
    frames = _count_changes(page, canvas)
    assert frames > 20, f"the screen changed {frames} times in two seconds"
    ended = page.get_by_role("button", name="Keep K")
    page.keyboard.down("Space")
    for key in ("ArrowRight", "ArrowLeft") * 20:
        if ended.is_visible():
            break
        page.keyboard.press(key, delay=700)
    page.keyboard.up("Space")
    expect(ended).to_be_visible(timeout=GAME_TIMEOUT_MS)
    expect(page.get_by_text(re.compile(r"Hit by a bomb|Survived all 300 steps"))).to_be_visible()
    _press_until_hidden(page, "k", ended)
    page.keyboard.press("p")
    page.get_by_role("button", name="Mark all the same").click()
    expect(page.get_by_role("button", name=re.compile("Perfect"))).to_have_attribute(
        "aria-pressed", "true"
    )


def _press_until_hidden(page: Page, key: str, button: Locator) -> None:
    """Press a key that does nothing just after the end, when presses are still for the game."""
    deadline = time.monotonic() + 10
    while button.is_visible():
        assert time.monotonic() < deadline, f"the key {key} does nothing"
        page.keyboard.press(key, delay=50)


def _count_changes(page: Page, canvas: Locator) -> int:
    """How often the canvas shows something new within two seconds."""
    changes: int = canvas.evaluate(
        """async (canvas) => {
            let last = null, changes = 0;
            const until = performance.now() + 2000;
            while (performance.now() < until) {
                await new Promise(requestAnimationFrame);
                const now = canvas.toDataURL();
                changes += now !== last;
                last = now;
            }
            return changes;
        }"""
    )
    return changes


def _import_three(page: Page, folder: Path) -> None:
    """Add a good, a middling and a bad game from a file, unranked; one line is no recording."""
    lines = DATA.read_text().splitlines()
    chosen = [json.loads(lines[index]) for index in (0, 5, 11)]
    file = folder / "three.jsonl"
    file.write_text("".join(json.dumps(line) + "\n" for line in [*chosen, {"format": "else"}]))
    page.get_by_role("navigation", name="Path").get_by_role("link", name="Recordings").click()
    page.get_by_role("button", name=re.compile("Import")).first.click()
    dialog = page.get_by_role("dialog")
    dialog.get_by_label("File of recordings").set_input_files(file)
    dialog.get_by_role("button", name="Import").click()
    # Each recording is replayed first, after the game that was played just now.
    expect(dialog.get_by_text(re.compile("4"))).to_be_visible(timeout=30_000)
    dialog.get_by_role("button", name=re.compile("Done|Close")).first.click()
    expect(page.get_by_role("article")).to_have_count(4)


def _rank(page: Page) -> None:
    page.get_by_role("navigation", name="Path").get_by_role("link", name="Rank").click()
    tiers = page.get_by_role("list", name="Tiers, best first")
    tray = page.get_by_role("region", name=re.compile("Unranked"))
    expect(tray.get_by_role("article")).to_have_count(4)

    drag_into(page, handle_of(tray, 2), page.get_by_text("Drag recordings here"), "the first tier")
    expect(tiers.get_by_role("article")).to_have_count(1)
    expect(page.get_by_text("Recording 2: the first tier")).to_be_attached()
    expect(page.get_by_role("status").get_by_text("Saved")).to_be_visible()

    tray.get_by_role("button", name="Rank as worst: Recording 3").click()
    expect(tiers.get_by_role("article")).to_have_count(2)
    tray.get_by_role("button", name="Rank as worst: Recording 4").click()
    expect(tiers.get_by_role("article")).to_have_count(3)

    handle = handle_of(page.locator("main"), 4)
    handle.focus()
    page.keyboard.press("Space")
    expect(page.get_by_text("Picked up Recording 4")).to_be_attached()
    _wait_for_timers(page)
    for key, announced in (
        ("ArrowUp", "Over new tier between tiers 2 and 3"),
        ("ArrowUp", "Over tier 2 of 3"),
        ("ArrowUp", "Over new tier between tiers 1 and 2"),
        ("Space", "Dropped Recording 4: new tier between tiers 1 and 2"),
    ):
        page.keyboard.press(key)
        expect(page.get_by_text(announced)).to_be_attached()
    _expect_order(tiers, ["Recording 2", "Recording 4", "Recording 3"])

    expect(page.get_by_role("status").get_by_text("Saved")).to_be_visible()
    page.keyboard.press("Control+z")
    _expect_order(tiers, ["Recording 2", "Recording 3", "Recording 4"])
    expect(page.get_by_text("Saved")).to_be_visible()
    page.reload()
    _expect_order(tiers, ["Recording 2", "Recording 3", "Recording 4"])


def _wait_for_timers(page: Page) -> None:
    """Wait for every timer that is due: dnd-kit listens to the arrow keys from one of them on."""
    page.evaluate("() => new Promise((done) => setTimeout(done))")


def _expect_order(tiers: Locator, names: list[str]) -> None:
    expect(tiers.get_by_role("heading", level=3)).to_have_text(
        [re.compile(rf"{name}\b") for name in names]
    )


def _train(page: Page) -> None:
    page.get_by_role("navigation", name="Path").get_by_role("link", name="Train").click()
    page.get_by_label("Steps", exact=True).fill("1000")
    page.get_by_text("More settings").click()
    page.get_by_label(re.compile("Go on anyway", re.IGNORECASE)).check()
    page.get_by_role("button", name="Train", exact=True).click()
    page.wait_for_url(re.compile("/runs/"))
    deadline = time.monotonic() + RUN_TIMEOUT_MS / 1000
    done = page.get_by_text("Done", exact=True)
    failed = page.get_by_text(re.compile("^(Failed|Stopped|Cancelled)$"))
    expect(done.or_(failed)).to_be_visible(timeout=(deadline - time.monotonic()) * 1000)
    expect(done).to_be_visible()


def _look(page: Page) -> None:
    expect(page.get_by_role("group", name="Games in step")).to_be_visible()
    page.get_by_text("What does the reward look at?").click()
    maps = page.get_by_role("img", name=re.compile("attention", re.IGNORECASE))
    expect(maps).to_have_count(4)
    for index in range(4):
        picture = maps.nth(index)
        picture.scroll_into_view_if_needed()
        page.wait_for_function(
            "(img) => img.complete && img.naturalWidth > 0", arg=picture.element_handle()
        )


def _follow_the_reward(page: Page) -> None:
    """Open the moment of a percentile; move the picture by the curve, the curve by the picture."""
    page.get_by_role("slider", name="Any percentile of R").press("End")
    page.get_by_role("link", name="Open this moment").click()
    page.wait_for_url(re.compile(r"/recordings/\d+\?step=\d+&run="))
    picture = page.get_by_role("slider", name="Position in the recording")
    curve = page.get_by_role("slider", name="Position on the curve of R")
    expect(curve).to_be_visible(timeout=REWARD_TIMEOUT_MS)
    last = int(picture.get_attribute("max") or 0)
    step = int(page.url.partition("step=")[2].partition("&")[0])
    expect(picture).to_have_value(str(min(4 * step, last)))
    curve.scroll_into_view_if_needed()
    box = curve.bounding_box()
    assert box is not None
    page.mouse.move(box["x"] + box["width"] / 4, box["y"] + box["height"] / 2)
    page.mouse.down()
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2, steps=4)
    page.mouse.up()
    assert abs(int(picture.input_value()) - last / 2) <= 2
    picture.press("Home")
    expect(curve).to_have_attribute("aria-valuenow", "0")
