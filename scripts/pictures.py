"""Take the README's pictures from the real app.

    python -m scripts.pictures DATA_FOLDER [RUN]

The data folder holds at least one finished run (``tril demo`` makes one); the newest is shown
unless one is named. The app is started on it, a game is played by key events, and the pages are
photographed into docs/pictures.
"""

from __future__ import annotations

import sys
from io import BytesIO
from pathlib import Path

from PIL import Image
from playwright.sync_api import Page, sync_playwright

from testsupport.browser import launch_chromium
from testsupport.processes import whole_tril

FOLDER = Path(__file__).resolve().parents[1] / "docs" / "pictures"
WIDTH, HEIGHT = 1280, 800
ANIMATION_FRAMES, ANIMATION_STEP_MS = 60, 100


def play(page: Page, behaviour: int) -> None:
    """Play half a game by key events and keep it as an animation; the game is discarded."""
    page.goto(f"/behaviours/{behaviour}/play")
    page.get_by_role("button", name="Start game").click()
    page.get_by_role("timer", name="Time left").get_by_text("19.").wait_for(timeout=20_000)
    pictures = []
    page.keyboard.down("Space")
    for number in range(ANIMATION_FRAMES):
        if number in (8, 40):
            page.keyboard.down("ArrowRight")
        if number in (14, 44):
            page.keyboard.up("ArrowRight")
        pictures.append(Image.open(BytesIO(page.screenshot())).convert("RGB"))
        page.wait_for_timeout(ANIMATION_STEP_MS / 4)
    page.keyboard.up("Space")
    page.keyboard.press("Escape")
    smaller = [
        p.resize((WIDTH * 3 // 4, HEIGHT * 3 // 4), Image.Resampling.LANCZOS) for p in pictures
    ]
    smaller[0].save(
        FOLDER / "play.webp",
        save_all=True,
        append_images=smaller[1:],
        duration=ANIMATION_STEP_MS,
        loop=0,
        quality=70,
        method=4,
    )


def photograph(page: Page, path: str, name: str) -> None:
    """Photograph a page."""
    page.goto(path)
    page.wait_for_timeout(4000)  # Games are replayed for their previews.
    page.get_by_text("Working it out").wait_for(state="hidden")
    page.screenshot(path=FOLDER / f"{name}.png")


def main() -> None:
    """Take every picture."""
    data = Path(sys.argv[1]).resolve()
    FOLDER.mkdir(parents=True, exist_ok=True)
    with (
        whole_tril(data) as tril,
        sync_playwright() as playwright,
        launch_chromium(playwright) as browser,
    ):
        page = browser.new_page(viewport={"width": WIDTH, "height": HEIGHT}, base_url=tril.base_url)
        page.goto(tril.address)
        with tril.http() as http:
            runs = http.get("/api/runs").json()
        wanted = [run for run in runs if run["id"] in sys.argv[2:]] or runs
        run = next(run for run in wanted if run["status"] == "done")
        behaviour = run["behaviour_id"]
        play(page, behaviour)
        photograph(page, f"/behaviours/{behaviour}/rank", "rank")
        photograph(page, f"/runs/{run['id']}", "results")


if __name__ == "__main__":
    main()
