"""What looping film strips cost: a 60 Hz game beside them, and the page that they are on.

    python -m benchmarks.pages.loops [--games 200] [--rounds 3]

Writes recordings that all differ into a data folder of its own and opens their rank page in a
window that is high enough for all of them; the browser's own tools hold every card as if it were
pointed at, so that all film strips loop at once. In another window of the same browser a game is
played by keys, in turns beside the strips at rest and beside the looping ones; a frame is late if
it is drawn more than a sixtieth of a second after its due time. Then the pages themselves: how many
of a page's animation frames come late, the board's at rest and looping, and a result's with its
two games paused and playing. Only the ratios within a run say something on a busy machine.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from pathlib import Path

import numpy as np
from playwright.sync_api import Browser, CDPSession, Page, sync_playwright

from benchmarks.pages.film_strips import WINDOW, write_games
from benchmarks.pages.long_runs import page_of, until_drawn
from benchmarks.play.latency import WATCH, play
from server.web.pages import FRONTEND
from testsupport.browser import launch_chromium
from testsupport.finished_runs import make_finished_run
from testsupport.live import LiveServer, live_server
from testsupport.workplace import make_workplace

GAME_S = 15.0
LISTENED_MS = 8000
LATE_MS = 1.5 * 1000 / 60
FRAMES = """(ms) => new Promise((resolve) => {
  const times = [];
  const tick = (now) => {
    times.push(now);
    if (now - times[0] < ms) requestAnimationFrame(tick);
    else resolve(times);
  };
  requestAnimationFrame(tick);
})"""
CARDS = "[...document.querySelectorAll('[data-loops]')]"
DRAWN = f"{CARDS}.every((card) => [...card.querySelectorAll('img')].every((img) => img.complete))"
N_ANIMATIONS = "document.getAnimations().filter((one) => one.playState === 'running').length"


def open_page(browser: Browser, server: LiveServer, path: str, high: bool = False) -> Page:
    """Open a page whose pictures may move, in a window of its own."""
    page = page_of(browser, server)
    page.emulate_media(reduced_motion="no-preference")
    if high:
        page.set_viewport_size({"width": WINDOW["width"], "height": WINDOW["height"]})
    page.goto(path)
    return page


def set_looping(page: Page, devtools: CDPSession, looping: bool) -> int:
    """Point at all cards of a page at once, or at none; returns how many animations run."""
    root = devtools.send("DOM.getDocument")["root"]["nodeId"]
    query = {"nodeId": root, "selector": "[data-loops]"}
    states = ["hover"] if looping else []
    for node in devtools.send("DOM.querySelectorAll", query)["nodeIds"]:
        devtools.send("CSS.forcePseudoState", {"nodeId": node, "forcedPseudoClasses": states})
    number: int = page.evaluate(N_ANIMATIONS)
    return number


def late_animation_frames(page: Page) -> tuple[float, float]:
    """Return a page's animation frames a second, and the share of them that came late."""
    times = np.array(page.evaluate(FRAMES, LISTENED_MS))
    gaps = np.diff(times)
    return 1000 / float(gaps.mean()), float((gaps > LATE_MS).mean())


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n\n")[0])
    parser.add_argument("--games", type=int, default=200, help="on the board")
    parser.add_argument("--rounds", type=int, default=3, help="of a game at rest and one beside")
    arguments = parser.parse_args()
    rng = np.random.default_rng(0)
    late: dict[str, list[float]] = {"at rest": [], "looping": []}
    pages: dict[str, tuple[float, float]] = {}
    with tempfile.TemporaryDirectory(prefix="tril-loops-") as folder:
        workplace = make_workplace(Path(folder) / "data")
        run_id = make_finished_run(workplace)
        write_games(workplace, arguments.games)
        rank = f"/behaviours/{workplace.behaviour_id}/rank"
        with (
            live_server(workplace.settings.data, frontend=FRONTEND) as server,
            sync_playwright() as playwright,
            launch_chromium(playwright) as browser,
        ):
            board = open_page(browser, server, rank, high=True)
            until_drawn(board, lambda: None, f"{CARDS}.length >= {arguments.games} && {DRAWN}")
            # What is pointed at ends with the session.
            devtools = board.context.new_cdp_session(board)
            devtools.send("DOM.enable")
            devtools.send("CSS.enable")
            player = page_of(browser, server)
            player.add_init_script(WATCH)
            n_loops = 0
            for _ in range(arguments.rounds):
                for name, shares in late.items():
                    n_loops = max(n_loops, set_looping(board, devtools, name == "looping"))
                    seen = play(player, "/behaviours/1/play", GAME_S, rng)
                    shares.append(1 - seen.n_on_time / seen.n_frames)
            player.close()
            if n_loops < arguments.games:
                raise SystemExit(f"Only {n_loops} film strips looped.")
            for name in late:
                set_looping(board, devtools, name == "looping")
                pages[f"board, {name}"] = late_animation_frames(board)
            board.close()
            result = open_page(browser, server, f"/runs/{run_id}")
            games = result.get_by_role("group", name="Games in step")
            games.get_by_role("button", name="Play", exact=True).first.wait_for()
            pages["result, paused"] = late_animation_frames(result)
            games.get_by_role("button", name="Play", exact=True).first.click()
            pages["result, playing"] = late_animation_frames(result)
        workplace.database.close()
    print(f"film strips that looped: {n_loops}")
    for name, shares in late.items():
        print(f"frames of a game late, strips {name}: {np.mean(shares):.2%}")
    for name, (rate_hz, share) in pages.items():
        print(f"{name}: {rate_hz:.1f} frames/s, {share:.1%} late")
    print(json.dumps({"benchmark": "loops", **vars(arguments), "late": late, "pages": pages}))


if __name__ == "__main__":
    main()
