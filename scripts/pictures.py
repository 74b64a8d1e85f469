"""Take the README's pictures from the real app.

    python -m scripts.pictures DATA_FOLDER [RUN]

The data folder holds at least one finished run (``tril demo`` makes one); the newest is shown
unless one is named. The app is started on it, a game is played by key events, and the pages are
photographed into docs/pictures.
"""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
from io import BytesIO
from pathlib import Path

from PIL import Image
from playwright.sync_api import Browser, Page, sync_playwright

from scripts.browser import find_browser

FOLDER = Path(__file__).resolve().parents[1] / "docs" / "pictures"
ADDRESS = re.compile(r"http://\S+\?token=\S+")
WIDTH, HEIGHT = 1280, 800
ANIMATION_FRAMES, ANIMATION_STEP_MS = 60, 100


def start(data: Path) -> tuple[subprocess.Popen[str], str]:
    """Start Tril on a data folder; returns the process and the address with its token."""
    process = subprocess.Popen(
        [sys.executable, "-m", "cli.main", "up", "--port", "0", "--no-browser"],
        env={**os.environ, "TRIL_DATA": str(data), "COLUMNS": "200"},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    assert process.stdout is not None
    for line in process.stdout:
        if found := ADDRESS.search(line):
            return process, found.group()
    raise SystemExit("Tril did not start.")


def open_page(browser: Browser, address: str, scheme: str, width: int = WIDTH) -> Page:
    """Open a signed-in page."""
    context = browser.new_context(
        viewport={"width": width, "height": HEIGHT},
        color_scheme="dark" if scheme == "dark" else "light",
    )
    page = context.new_page()
    page.goto(address)
    return page


def play(page: Page, behaviour: int) -> None:
    """Play half a game by key events and keep it as an animation; the game is discarded."""
    page.goto(f"{page.url.split('/', 3)[0]}//{page.url.split('/')[2]}/behaviours/{behaviour}/play")
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


def photograph(page: Page, path: str, name: str, anchor: str | None = None) -> None:
    """Photograph a page, from a heading on where one is named."""
    root = "/".join(page.url.split("/")[:3])
    page.goto(root + path)
    page.wait_for_timeout(1500)
    if anchor is not None:
        page.get_by_role("heading", name=anchor, exact=True).evaluate(
            "heading => window.scrollTo(0, heading.getBoundingClientRect().top + scrollY - 24)"
        )
        page.wait_for_timeout(1500)
    page.screenshot(path=FOLDER / f"{name}.png")


def main() -> None:
    """Take every picture."""
    data = Path(sys.argv[1]).resolve()
    FOLDER.mkdir(parents=True, exist_ok=True)
    process, address = start(data)
    try:
        with sync_playwright() as playwright:
            browser = playwright.chromium.launch(
                executable_path=str(find_browser()),
                chromium_sandbox=os.geteuid() != 0,
                args=["--disable-gpu", "--disable-background-networking"],
            )
            page = open_page(browser, address, "light")
            runs = page.request.get(f"{address.split('/?')[0]}/api/runs").json()
            wanted = [run for run in runs if run["id"] in sys.argv[2:]] or runs
            run = next(run for run in wanted if run["status"] == "done")
            behaviour = run["behaviour_id"]
            play(page, behaviour)
            photograph(page, f"/behaviours/{behaviour}/rank", "rank")
            photograph(page, f"/runs/{run['id']}", "results", "Result")
            photograph(page, f"/runs/{run['id']}", "attention", "What the reward model looks at")
            browser.close()
    finally:
        process.send_signal(signal.SIGINT)
        process.wait(30)


if __name__ == "__main__":
    main()
