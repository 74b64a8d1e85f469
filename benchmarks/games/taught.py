"""Six games and two environments, taught in the page: play, rewind, rank, train, look.

    python -m benchmarks.games.taught DATA_FOLDER            # what is left of it, then waits
    python -m benchmarks.games.taught DATA_FOLDER --no-wait  # writes down which runs are done

Games are played by key events of a browser, mostly by a schedule, in Breakout and CartPole by what
its canvas shows. 20,000 steps prove that a game can be taught to its end, not that it is learned:
the reward takes far fewer updates than the recipe proposes, so that eight trainings are done in an
evening. Called again on the same folder, it goes on where it was stopped. docs/results gets the
page and a picture of each game.
"""

from __future__ import annotations

import argparse
import itertools
import json
import math
import re
import sqlite3
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass
from datetime import datetime
from functools import partial
from io import BytesIO
from pathlib import Path
from typing import Any

from PIL import Image
from playwright.sync_api import Page, expect, sync_playwright

from testsupport.browser import launch_chromium
from testsupport.dragging import drag_into
from testsupport.processes import whole_tril
from testsupport.waiting import wait_until

RESULTS = Path(__file__).resolve().parents[2] / "docs" / "results"
PAGE = RESULTS / "other-games.md"
STEPS = 20_000
REWARD_UPDATES, FOLD_UPDATES = 100, 30
LONGEST_S = 10
PATIENCE_MS = 60_000
RUN_TIMEOUT_S = 3 * 3600.0
PICTURE_WIDTH = 640

HEAD = f"""# Other games, taught in the page

`python -m benchmarks.games.taught` drives a browser: it finds a game on the page of games, makes
a behaviour of it with games of {LONGEST_S} s, plays three by key events, rewinds where the game
can, keeps them, ranks them by dragging and trains {STEPS:,} steps by the proposed recipe,
`paper`. That proves that each page works for each game, not that anything is learned: `paper`
proposes 10,000,000 steps, and its reward takes {REWARD_UPDATES} updates here instead of 30,000,
since the trainings wait for each other. Games are mostly played by a schedule of keys, in
Breakout and CartPole by what the canvas shows.

*Check* is Kendall's tau of the learned reward and the ranking, then the share of pairs that it
orders right when one of the two games was held out. *Measure* is the mean of each of the
behaviour's measures in games of the imitator, of the clone and of the ranked games of the person,
with how many games met its bound; imitator and clone play three greedy games. *Minutes* are those
of the whole run, on a machine that was busy with other work.

| game | behaviour | ranked by | check | steps | minutes | measure: imitator / clone / person |
|---|---|---|---|---:|---:|---|"""

Play = Callable[[Page, Callable[[], bool]], None]
"""Presses keys on a page until the game is over, which the second argument tells."""


def hold(*schedule: tuple[str, float]) -> Play:
    """Return a player who goes through keys and seconds again and again; "" holds none."""

    def play(page: Page, is_over: Callable[[], bool]) -> None:
        for keys, seconds in itertools.cycle(schedule):
            pressed = keys.split()
            for key in pressed:
                page.keyboard.down(key)
            until = time.monotonic() + seconds
            while time.monotonic() < until and not is_over():
                page.wait_for_timeout(50)
            for key in pressed:
                page.keyboard.up(key)
            if is_over():
                return

    return play


def steer(offset: str, *, tolerance: float, still: str, serve: str = "") -> Play:
    """Return a player who reads the canvas and presses Left or Right.

    Args:
        offset: JavaScript from ``pixel(x, y)``, ``width`` and ``height`` to how far to the right
            to go, null where nothing is seen.
        tolerance: Offsets up to this are left alone.
        still: Key that is held meanwhile, "" for none.
        serve: Key that is pressed where nothing is seen.
    """
    script = f"""canvas => {{
        const {{ width, height }} = canvas;
        const {{ data }} = canvas.getContext("2d").getImageData(0, 0, width, height);
        const pixel = (x, y) => data[4 * (y * width + x)] * 65536
            + data[4 * (y * width + x) + 1] * 256 + data[4 * (y * width + x) + 2];
        {offset}
    }}"""

    def play(page: Page, is_over: Callable[[], bool]) -> None:
        canvas = page.get_by_role("img", name="Game screen")
        held = ""
        while not is_over():
            seen = canvas.evaluate(script)
            if seen is None and serve:
                page.keyboard.press(serve, delay=60)
            aside = seen is not None and abs(seen) > tolerance
            key = ("ArrowRight" if seen > 0 else "ArrowLeft") if aside else still
            if key != held:
                if key:
                    page.keyboard.down(key)
                if held:
                    page.keyboard.up(held)
                held = key
        if held:
            page.keyboard.up(held)

    return play


FOLLOW_THE_BALL = """
    const RED = 200 * 65536 + 72 * 256 + 72;
    const mean = (from, to) => {
        let sum = 0, n = 0;
        for (let y = from; y < to; y += 1)
            for (let x = 8; x < 152; x += 1)
                if (pixel(x, y) === RED) { sum += x; n += 1; }
        return n ? sum / n : null;
    };
    const [ball, paddle] = [mean(94, 188), mean(190, 193)];
    return ball === null || paddle === null ? null : ball - paddle;
"""
"""Below the bricks only the ball has the paddle's colour."""

UNDER_THE_POLE = """
    const POLE = 202 * 65536 + 152 * 256 + 101;
    const at = (y) => {
        let sum = 0, n = 0;
        for (let x = 0; x < width; x += 1) if (pixel(x, y) === POLE) { sum += x; n += 1; }
        return n ? sum / n : null;
    };
    const rows = [];
    for (let y = 0; y < height; y += 1) { const x = at(y); if (x !== null) rows.push(x); }
    if (rows.length < 8) return null;
    const lean = rows[2] - rows[rows.length - 3];
    const swing = lean - (canvas.lean ?? lean);
    canvas.lean = lean;
    return lean + 3 * swing + 0.01 * (rows[rows.length - 3] - width / 2);
"""
"""Pushes to where the pole leans and swings."""


@dataclass(frozen=True)
class Taught:
    """A game and what is taught in it.

    Attributes:
        game: Its name.
        behaviour: A ready-made behaviour's name, or the name of a new one.
        ranked: In words, what makes a game better.
        plays: Who plays the games, best first.
        description: Of a new behaviour; None takes the ready-made one.
        measure: Of a new behaviour: what is measured, its bound's label, and the bound.
        picture: Which page is shown: "play", "rank" or "result".
    """

    game: str
    behaviour: str
    ranked: str
    plays: Sequence[Play]
    picture: str
    description: str | None = None
    measure: tuple[str, str, str] | None = None

    @property
    def slug(self) -> str:
        """A name for files."""
        return re.sub(r"\W+", "-", self.game.removeprefix("gym:")).lower()


TAUGHT = (
    Taught(
        "breakout",
        "Left tunnel",
        "how long the ball is kept, then bricks on the left",
        (
            steer(FOLLOW_THE_BALL, tolerance=3, still="", serve="Space"),
            hold(("Space", 0.1), ("ArrowLeft", 0.7), ("ArrowRight", 0.5)),
            hold(("Space", 0.1), ("ArrowRight", 3)),
        ),
        "play",
    ),
    Taught(
        "pong",
        "Stay up",
        "time in the upper half",
        (
            hold(("ArrowUp", 1.0), ("", 0.4)),
            hold(("ArrowUp", 2.5), ("ArrowDown", 2.5)),
            hold(("ArrowDown", 1.0), ("", 0.4)),
        ),
        "rank",
    ),
    Taught(
        "ms_pacman",
        "Lower half",
        "time in the lower half, alive",
        (
            hold(("ArrowDown", 1.2), ("ArrowLeft", 0.8), ("ArrowDown", 1.2), ("ArrowRight", 0.8)),
            hold(("ArrowLeft", 0.8), ("ArrowDown", 0.8), ("ArrowRight", 0.8), ("ArrowUp", 0.8)),
            hold(("ArrowUp", 1.2), ("ArrowLeft", 0.8), ("ArrowUp", 1.2), ("ArrowRight", 0.8)),
        ),
        "result",
    ),
    Taught(
        "seaquest",
        "Near the surface",
        "time in the upper water, alive",
        (
            hold(("ArrowUp Space", 0.8), ("ArrowDown", 0.25), ("ArrowLeft Space", 0.4)),
            hold(("ArrowDown", 0.8), ("ArrowUp Space", 0.9), ("ArrowRight Space", 0.5)),
            hold(("ArrowDown Space", 2), ("ArrowLeft", 0.5)),
        ),
        "play",
    ),
    Taught(
        "freeway",
        "Wait in the middle",
        "time between the two halves of the road",
        (
            hold(("ArrowUp", 1.25), ("", 20)),
            hold(("ArrowUp", 0.6), ("", 4), ("ArrowUp", 0.5), ("", 20)),
            hold(("ArrowUp", 20)),
        ),
        "rank",
    ),
    Taught(
        "boxing",
        "Keep away",
        "time out of the other's reach",
        (
            hold(("ArrowLeft ArrowUp", 2), ("ArrowLeft ArrowDown", 2)),
            hold(("ArrowRight", 1), ("ArrowLeft", 2)),
            hold(("ArrowRight Space", 1), ("ArrowDown Space", 0.6), ("ArrowRight Space", 0.6)),
        ),
        "result",
    ),
    Taught(
        "gym:CartPole-v1",
        "Pole up",
        "how long the pole stays up",
        (
            steer(UNDER_THE_POLE, tolerance=0, still="ArrowLeft"),
            hold(("ArrowLeft", 0.1), ("ArrowRight", 0.1)),
            hold(("ArrowLeft", 1)),
        ),
        "play",
        "Keep the pole up and the cart on the track.",
        ("How long the game lasts", "At least, seconds", "5"),
    ),
    Taught(
        "gym:MiniGrid-Empty-Random-6x6-v0",
        "Turn right",
        "how often it turns right",
        (
            hold(("ArrowRight", 20)),
            hold(("ArrowRight", 1.5), ("ArrowLeft", 1.5)),
            hold(("ArrowLeft", 20)),
        ),
        "result",
        "Turn right on the spot, and never walk.",
        ("How often a button is pressed", "", ""),
    ),
)


def shorten_rewards(path: Path) -> None:
    """Let every run that is made in a database learn its reward and be judged in brief.

    The page offers no such values, and a worker takes a run as soon as it is there.
    """
    changed = (
        f"json_set(recipe, '$.reward.updates', {REWARD_UPDATES},"
        f" '$.reward.fold_updates', {FOLD_UPDATES},"
        " '$.evaluation.further_start_numbers', json('[]'))"
    )
    with closing(sqlite3.connect(path)) as database:
        database.execute(
            "CREATE TRIGGER IF NOT EXISTS shorter AFTER INSERT ON runs"
            f" BEGIN UPDATE runs SET recipe = {changed} WHERE id = NEW.id; END"
        )
        database.commit()


@contextmanager
def opened(data: Path) -> Iterator[tuple[Page, Any]]:
    """Run Tril on a data folder, and open a signed-in page and a client."""
    with (
        whole_tril(data) as tril,
        sync_playwright() as playwright,
        launch_chromium(playwright) as browser,
        tril.http() as http,
    ):
        shorten_rewards(data / "tril.sqlite")
        page = browser.new_page(viewport={"width": 1280, "height": 900}, base_url=tril.base_url)
        page.set_default_timeout(PATIENCE_MS)
        expect.set_options(timeout=PATIENCE_MS)
        page.goto(tril.address)
        yield page, http


def photograph(page: Page, path: Path) -> None:
    """Keep what a page shows, small."""
    picture = Image.open(BytesIO(page.screenshot())).convert("RGB")
    height = round(PICTURE_WIDTH * picture.height / picture.width)
    smaller = picture.resize((PICTURE_WIDTH, height), Image.Resampling.LANCZOS)
    path.parent.mkdir(exist_ok=True)
    smaller.save(path, quality=75, method=6)


def teach(page: Page, taught: Taught, pictures: Path) -> str:
    """Make the behaviour, play, rewind, rank by dragging and press Train; returns the run."""
    make_behaviour(page, taught)
    kept = [
        play_game(page, taught, play, pictures, first=number == 0)
        for number, play in enumerate(taught.plays)
    ]
    rank(page, kept)
    page.mouse.move(0, 0)
    photograph(page, pictures / f"{taught.slug}-rank.webp")
    page.get_by_role("navigation", name="Path").get_by_role("link", name="Train").click()
    page.get_by_label("Steps", exact=True).fill(str(STEPS))
    page.get_by_text("More settings").click()
    page.get_by_label(re.compile("Go on anyway", re.IGNORECASE)).check()
    page.get_by_role("button", name="Train", exact=True).click()
    page.wait_for_url(re.compile("/runs/"))
    return page.url.rpartition("/runs/")[2]


def make_behaviour(page: Page, taught: Taught) -> None:
    """Find the game on the page of games, and make the behaviour of it."""
    page.goto("/games")
    search = page.get_by_role("searchbox", name="Find a game")
    search.fill(taught.game.removeprefix("gym:").replace("_", " "))
    link = page.locator(f"a[href$='/games/{taught.game}'], a[href$='/games/{quoted(taught.game)}']")
    link.first.click()
    ready_made = taught.description is None
    name = f"Teach {taught.behaviour}" if ready_made else "Teach a behaviour"
    page.get_by_role("button", name=name).click()
    dialog = page.get_by_role("dialog")
    if taught.description is not None:
        dialog.get_by_label("Description").fill(taught.description)
        dialog.get_by_label("Name").fill(taught.behaviour)
    if taught.measure is not None:
        kind, bound, value = taught.measure
        dialog.get_by_text("What tells in numbers how well it is shown").click()
        dialog.get_by_role("button", name="Measure something").click()
        dialog.get_by_label("What is measured").select_option(kind)
        if bound:
            dialog.get_by_label(bound).fill(value)
        else:
            dialog.get_by_label("Button").select_option("right")
            dialog.get_by_label("Counted").select_option("how long it is held")
            dialog.get_by_label("At least, % of the time").fill("80")
    longest = dialog.get_by_label("Longest game, in seconds")
    if not longest.is_visible():  # Behaviours that bring a length of their own show it.
        dialog.get_by_text("How it is played").click()
    longest.fill(str(LONGEST_S))
    dialog.get_by_role("button", name="Create behaviour").click()
    page.wait_for_url("**/play")


def quoted(game: str) -> str:
    """Return a game's name as it may stand in an address."""
    return game.replace(":", "%3A")


def play_game(page: Page, taught: Taught, play: Play, pictures: Path, first: bool) -> int:
    """Play a game to its end by key events and keep it; the first is rewound if it can be.

    Returns:
        The recording that it is kept as.
    """
    page.goto(re.sub(r"(/behaviours/\d+).*", r"\1/play", page.url))
    page.get_by_role("button", name="Start game").click()
    expect(page.get_by_role("button", name="Pause")).to_be_visible()
    expect(page.locator("strong[role=timer]")).to_be_hidden()
    keep = page.get_by_role("button", name="Keep K")
    picture_at = math.inf

    def is_over() -> bool:
        nonlocal picture_at
        if time.monotonic() > picture_at:
            picture_at = math.inf
            photograph(page, pictures / f"{taught.slug}-play.webp")
        return keep.is_visible()

    if first and page.get_by_role("button", name=re.compile("^Rewind")).is_visible():
        page.wait_for_timeout(1500)
        page.keyboard.down("Backspace")
        expect(page.get_by_text("Rewinding.")).to_be_visible()
        page.wait_for_timeout(300)
        page.keyboard.up("Backspace")
        expect(page.locator("strong[role=timer]")).to_be_visible()
        expect(page.locator("strong[role=timer]")).to_be_hidden()
        print(f"{taught.game}: rewound", flush=True)
    if first:
        picture_at = time.monotonic() + 2
    play(page, is_over)
    keep.click()
    said = page.get_by_text(re.compile(r"Kept as recording \d+"))
    return int(re.sub(r"\D", "", said.inner_text()))


def rank(page: Page, recordings: Sequence[int]) -> None:
    """Drag games, best first, each into a tier of its own below the last."""
    page.get_by_role("navigation", name="Path").get_by_role("link", name="Rank").click()
    tiers = page.get_by_role("list", name="Tiers, best first")
    tray = page.get_by_role("region", name=re.compile("^Unranked"))
    for number, recording in enumerate(recordings):
        handle = tray.get_by_role("button", name=f"Move Recording {recording}", exact=True)
        if number == 0:
            place, announced = page.get_by_text("Drag recordings here"), "the first tier"
        else:
            place = page.get_by_text("Drop below the last tier to make a new one")
            announced = "new tier, worst of all"
        drag_into(page, handle, place, announced)
        expect(tiers.get_by_role("article")).to_have_count(number + 1)
    expect(page.get_by_role("status").get_by_text("Saved")).to_be_visible()


def look(page: Page, taught: Taught, run: str, pictures: Path) -> None:
    """Photograph what came of a run, from its measures on."""
    page.goto(f"/runs/{run}")
    table = page.get_by_role("table", name="Measures of the behaviour")
    shown = page.get_by_role("heading", name="Result", exact=True).or_(table).first
    shown.evaluate("shown => window.scrollTo(0, shown.getBoundingClientRect().top + scrollY - 48)")
    page.wait_for_timeout(3000)  # Games are replayed for their pictures.
    photograph(page, pictures / f"{taught.slug}-result.webp")


def is_over(http: Any, run: str) -> bool:
    """Tell whether a run is over."""
    status: str = http.get(f"/api/runs/{run}").raise_for_status().json()["status"]
    return status not in ("queued", "running", "cancelling")


def row_of(taught: Taught, results: dict[str, Any]) -> str:
    """Return a game's row of the table."""
    run, check = results["run"], results["check"]
    minutes = ""
    if run["finished_at"] is not None:
        span = datetime.fromisoformat(run["finished_at"]) - datetime.fromisoformat(
            run["started_at"]
        )
        minutes = f"{span.total_seconds() / 60:.0f}"
    means = [
        " / ".join(mean_of(row[who], row["unit"]) for who in ("imitator", "clone", "person"))
        for row in results["measures"]
    ]
    cells = (
        taught.game,
        taught.behaviour,
        taught.ranked,
        "" if check is None else check_words(check["tau"], check["held_out_accuracy"]),
        f"{run['steps']:,}" if run["status"] == "done" else f"{run['status']}",
        minutes,
        "; ".join(means),
    )
    return f"| {' | '.join(cells)} |"


def check_words(tau: float, held_out: float | None) -> str:
    """Return what the check of the ranking found; nothing is held out of some runs."""
    return f"{tau:.2f}" + ("" if held_out is None else f", {held_out:.0%}")


def mean_of(mean: dict[str, Any] | None, unit: str) -> str:
    """Return a mean, and how many games met the bound."""
    if mean is None:
        return "–"
    met = "" if mean["n_met"] is None else f" ({mean['n_met']} of {mean['n']})"
    value = f"{mean['mean']:.0%}" if unit == "share" else f"{mean['mean']:.1f}"
    return value + met


def write_page(rows: Sequence[str], pictures: Path) -> None:
    """Write the page of results, and the picture of each game that there is."""
    shown = []
    for taught in TAUGHT:
        picture = pictures / f"{taught.slug}-{taught.picture}.webp"
        if not picture.exists():
            picture = pictures / f"{taught.slug}-play.webp"
        if picture.exists():
            name = f"taught-{taught.slug}.webp"
            (RESULTS / name).write_bytes(picture.read_bytes())
            shown.append(f"![{taught.game}: {picture.stem.rpartition('-')[2]}]({name})")
    PAGE.write_text("\n".join([HEAD, *rows, "", *shown]) + "\n", encoding="utf-8")


def main() -> None:
    """Teach what is not taught yet, and write down what came of it."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("data", type=Path)
    parser.add_argument("--no-wait", action="store_true", help="for runs that are not over")
    arguments = parser.parse_args()
    data = arguments.data.resolve()
    data.mkdir(parents=True, exist_ok=True)
    made = data.parent / f"{data.name}-runs.json"
    runs: dict[str, str] = json.loads(made.read_text()) if made.exists() else {}
    pictures = data.parent / f"{data.name}-pictures"
    rows = []
    with opened(data) as (page, http):
        for taught in TAUGHT:
            if taught.game not in runs:
                runs[taught.game] = teach(page, taught, pictures)
                made.write_text(json.dumps(runs))
                print(f"{taught.game}: run {runs[taught.game]}", flush=True)
        for taught in TAUGHT:
            run = runs[taught.game]
            if not arguments.no_wait:
                wait_until(partial(is_over, http, run), RUN_TIMEOUT_S)
            results = http.get(f"/api/runs/{run}/results").raise_for_status().json()
            if results["run"]["status"] == "done":
                look(page, taught, run, pictures)
            rows.append(row_of(taught, results))
            write_page(rows, pictures)
            print(rows[-1], flush=True)


if __name__ == "__main__":
    main()
