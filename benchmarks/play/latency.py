"""Latency from a key to the screen in a real browser, alone and during a training.

    python -m benchmarks.play.latency --games 10

Runs ``tril up`` and Chromium on this machine and presses keys at random moments of a game. Latency
is measured outside the page's code, from the time stamp of a key's event until the page has drawn
and acknowledged the first frame that was executed with that key held. It excludes the display's own
latency, and the frames that the game itself takes until something moves, which are counted on the
emulator. A frame is on time if it is drawn within a sixtieth of a second of its due time, by the
clock of the game's most punctual frame. Then a training is started, and from the given stage on the
same is measured during it, as well as the training's speed: beside the browser, beside a player
whose browser is on another machine (a WebSocket that draws nothing), and beside nobody, the latter
two in turns. Prints a table and a JSON line.
"""

from __future__ import annotations

import argparse
import json
import tempfile
import time
from collections import defaultdict
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from playwright.sync_api import Page, sync_playwright

from benchmarks.play.support.crowd import running_crowd
from testsupport.browser import launch_chromium
from testsupport.processes import TrilProcess, whole_tril
from testsupport.space_invaders import Keys, action_for, evaluation_start
from testsupport.waiting import wait_until
from tril.games.atari.starts import EVALUATION_START_COUNT
from tril.games.space_invaders import SPACE_INVADERS
from tril.play.episode import Episode
from tril.stages import Stage
from tril.store.database import Database, create_database
from tril.store.training import runs

STAGES = [stage.value for stage in Stage]
KEYS = ("ArrowLeft", "ArrowRight", "Space")
HELD_MS = (60, 160)
BETWEEN_MS = (80, 250)
FRAME_MS = 1000 / 60
START_TIMEOUT_S = 60.0
RATE_WINDOW_S, RATE_WINDOWS = 30.0, 3
SETTLING_S = 5.0
"""After a player has come or gone."""

WATCH = """
(() => {
  const seen = { keys: [], inputs: [], frames: [], drawn: [], over: false };
  window.__seen = seen;
  addEventListener("keydown", (event) => {
    if (!event.repeat) seen.keys.push([event.timeStamp, performance.now()]);
  }, true);
  const Native = window.WebSocket;
  const send = Native.prototype.send;
  Native.prototype.send = function (data) {
    send.call(this, data);
    if (typeof data === "string") return;
    const view = ArrayBuffer.isView(data)
      ? new DataView(data.buffer, data.byteOffset, data.byteLength)
      : new DataView(data);
    const sequence = view.getUint32(4, true);
    const list = view.getUint8(0) === 2 ? seen.drawn : seen.inputs;
    list.push([sequence, performance.now()]);
  };
  window.WebSocket = class extends Native {
    constructor(...args) {
      super(...args);
      this.addEventListener("message", ({ data }) => {
        if (typeof data === "string") {
          if (data.includes('"ended"')) seen.over = true;
          return;
        }
        const view = new DataView(data);
        seen.frames.push([4, 8, 12].map((at) => view.getUint32(at, true)));
      });
    }
  };
})();
"""


@dataclass(frozen=True)
class Measured:
    """Measurements of games.

    Attributes:
        latencies_ms: From each key's event to the drawing of the first frame with it.
        n_frames: Frames executed.
        n_on_time: Frames drawn on time.
    """

    latencies_ms: list[float]
    n_frames: int
    n_on_time: int


def evaluate(log: dict[str, Any]) -> Measured:
    """Evaluate what the page's script logged of one game."""
    drawn_at = dict(log["drawn"])
    frames = [frame for frame in log["frames"] if frame[0] in drawn_at and frame[1] > 0]
    latencies = []
    for happened, handled in log["keys"]:
        sent = next((sequence for sequence, at in log["inputs"] if at >= handled), None)
        shown = next((f for f in frames if sent is not None and f[2] >= sent), None)
        if shown is not None:
            latencies.append(drawn_at[shown[0]] - happened)
    offsets = np.array([drawn_at[sequence] - frame * FRAME_MS for sequence, frame, _ in frames])
    on_time = int(np.sum(offsets - offsets.min() <= FRAME_MS)) if frames else 0
    return Measured(latencies, frames[-1][1] if frames else 0, on_time)


def play(page: Page, address: str, seconds: float, rng: np.random.Generator) -> Measured:
    """Play one game with keys at random moments."""
    page.goto(address)
    page.get_by_role("button", name="Start game").click()
    wait_for_page(page, "window.__seen.frames.some(([, frame]) => frame > 5)")
    until = time.monotonic() + seconds
    while time.monotonic() < until and not page.evaluate("window.__seen.over"):
        key = str(rng.choice(KEYS))
        page.keyboard.down(key)
        page.wait_for_timeout(float(rng.uniform(*HELD_MS)))
        page.keyboard.up(key)
        page.wait_for_timeout(float(rng.uniform(*BETWEEN_MS)))
    seen = evaluate(page.evaluate("window.__seen"))
    # Otherwise the next visit would resume it.
    if not page.evaluate("window.__seen.over"):
        page.get_by_role("button", name="End the game here").click()
        wait_for_page(page, "window.__seen.over")
    return seen


def wait_for_page(page: Page, holds: str) -> None:
    """Wait until a JavaScript expression is true; page.wait_for_function needs eval in the page."""
    give_up_at = time.monotonic() + START_TIMEOUT_S
    while not page.evaluate(holds):
        if time.monotonic() > give_up_at:
            raise SystemExit(f"This never became true: {holds}")
        page.wait_for_timeout(50)


def summed(games: list[Measured]) -> dict[str, float]:
    """Summarise games."""
    latencies = [ms for seen in games for ms in seen.latencies_ms]
    n_frames = sum(seen.n_frames for seen in games)
    if not latencies:
        raise SystemExit("No key was seen to have an effect; the games were too short.")
    p50, p95, p99 = np.percentile(latencies, (50, 95, 99), method="inverted_cdf")
    return {
        "presses": len(latencies),
        "p50_ms": round(float(p50), 1),
        "p95_ms": round(float(p95), 1),
        "p99_ms": round(float(p99), 1),
        "frames": n_frames,
        "on_time_percent": round(100 * sum(seen.n_on_time for seen in games) / n_frames, 2),
    }


def frames_until_something_moves() -> list[int]:
    """Count the frames from a key to the first change on the screen, at many moments of games.

    1 means that the first frame executed with the key differs from the one without it.
    """
    console, counts = SPACE_INVADERS.make_console(), []
    for number in range(EVALUATION_START_COUNT):
        for key in (Keys.LEFT, Keys.RIGHT):
            episode = Episode(console, evaluation_start(number))
            for _ in range(30 + 7 * number % 60):
                episode.advance(action_for(Keys(0)))
            state = episode.save()
            screens = []
            for keys in (Keys(0), key):
                episode.restore(state)
                shown = []
                for _ in range(10):
                    episode.advance(action_for(keys))
                    shown.append(console.screen())
                screens.append(shown)
            pairs = enumerate(zip(*screens, strict=True), start=1)
            differs = [n for n, (without, with_key) in pairs if (without != with_key).any()]
            counts += differs[:1]
    return counts


@dataclass(frozen=True)
class Training:
    """A run that trains while games are played."""

    database: Database
    run_id: str

    def wait_for(self, stage: str, timeout_s: float) -> None:
        """Wait until the run has reached a stage."""
        until = time.monotonic() + timeout_s
        while True:
            with self.database.reading() as session:
                row = runs.get(session, self.run_id)
            if row.stage and STAGES.index(row.stage) >= STAGES.index(stage):
                return
            if time.monotonic() > until or row.finished_at is not None:
                raise SystemExit(f"The training is {row.status} at {row.stage!r}: {row.message}")
            time.sleep(0.5)

    def done(self) -> tuple[str, float]:
        """Return the stage and its progress, 0 to 1."""
        with self.database.reading() as session:
            row = runs.get(session, self.run_id)
        return row.stage, row.stage_done

    def next_report(self) -> tuple[str, float, float]:
        """Wait for progress; returns stage, progress, and when: seconds, monotonic."""
        last = self.done()
        wait_until(lambda: self.done() != last)
        return *self.done(), time.monotonic()


@contextmanager
def training(tril: TrilProcess, recipe: str, steps: int) -> Iterator[Training]:
    """Train on the example of column 1 for the block, then cancel the run."""
    database = create_database(tril.settings.application_url)
    with tril.http() as http:
        asked = {"behaviour_id": 1, "example": True, "go_on_anyway": True}
        answer = http.post("/api/runs", json={**asked, "recipe": recipe, "steps": steps})
        answer.raise_for_status()
        run_id = answer.json()["id"]
        try:
            yield Training(database, run_id)
        finally:
            http.post(f"/api/runs/{run_id}/cancel")
            database.close()


@contextmanager
def rated(run: Training, rates: list[float]) -> Iterator[None]:
    """Add the stage's progress per second within the block, unless the stage changes."""
    # Progress is reported at the end of each rollout, some seconds after the one before.
    first_stage, first, since = run.next_report()
    yield
    stage, done, until = run.next_report()
    if stage == first_stage:
        rates.append((done - first) / (until - since))


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--games", type=int, default=10, help="games alone, and as many beside")
    parser.add_argument("--seconds", type=float, default=18.0, help="longest time of a game")
    parser.add_argument("--recipe", default="fast", help="of the training beside")
    parser.add_argument("--steps", type=int, default=300_000, help="of the training beside")
    parser.add_argument("--stage", default="imitator", help="of the training to measure beside")
    parser.add_argument("--wait", type=float, default=1800.0, help="seconds for it to come there")
    parser.add_argument("--alone", action="store_true", help="leave the training out")
    parser.add_argument("--seed", type=int, default=0, help="of the presses")
    arguments = parser.parse_args()
    rng = np.random.default_rng(arguments.seed)
    moves = frames_until_something_moves()
    rows: dict[str, dict[str, float]] = {}
    speed: dict[str, list[float]] = defaultdict(list)
    with (
        tempfile.TemporaryDirectory(prefix="tril-latency-") as folder,
        whole_tril(Path(folder) / "data", "--workers", "1") as tril,
        sync_playwright() as playwright,
        launch_chromium(playwright) as browser,
    ):
        context = browser.new_context(viewport={"width": 1280, "height": 900})
        context.add_init_script(WATCH)
        page = context.new_page()
        page.goto(tril.address)

        def games() -> dict[str, float]:
            address = f"{tril.base_url}/behaviours/1/play"
            played = [play(page, address, arguments.seconds, rng) for _ in range(arguments.games)]
            page.goto("about:blank")
            return summed(played)

        rows["alone"] = games()
        if not arguments.alone:
            with training(tril, arguments.recipe, arguments.steps) as run:
                run.wait_for(arguments.stage, arguments.wait)
                with rated(run, speed["a browser"]):
                    rows["beside a training"] = games()
                for _ in range(RATE_WINDOWS):
                    time.sleep(SETTLING_S)
                    with rated(run, speed["nobody"]):
                        time.sleep(RATE_WINDOW_S)
                    with running_crowd(tril.settings, n_players=1, n_processes=1):
                        time.sleep(SETTLING_S)
                        with rated(run, speed["a player elsewhere"]):
                            time.sleep(RATE_WINDOW_S)
    print(f"{'':20}{'presses':>9}{'p50 ms':>9}{'p95':>7}{'p99':>7}{'frames':>9}{'on time':>9}")
    for name, row in rows.items():
        print(
            f"{name:20}{row['presses']:9}{row['p50_ms']:9}{row['p95_ms']:7}{row['p99_ms']:7}"
            f"{row['frames']:9}{row['on_time_percent']:8}%"
        )
    print(
        f"\nthe game's own frames until the cannon moves: {min(moves)} to {max(moves)}, "
        f"{np.mean(moves):.1f} on average"
    )
    for beside, rates in speed.items():
        if rates and speed["nobody"]:
            share = np.mean(rates) / np.mean(speed["nobody"])
            print(f"beside {beside}, the training goes at {share:.0%} of its speed")
    print(
        json.dumps(
            {
                "benchmark": "latency",
                **vars(arguments),
                **rows,
                "frames_until_move": [min(moves), round(float(np.mean(moves)), 2), max(moves)],
                "stage_per_s": speed,
            }
        )
    )


if __name__ == "__main__":
    main()
