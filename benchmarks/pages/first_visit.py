"""What the tasks of a first-time visitor take, by the names that stand on the pages alone.

    python -m benchmarks.pages.first_visit FOLDER                        # every task
    python -m benchmarks.pages.first_visit FOLDER --tasks example pong --steps 20000
    python -m benchmarks.pages.first_visit FOLDER --write docs/results/first-visit.md

Chromium opens the first page of a Tril on an empty data folder, a new one for each task, and goes
on by roles and names: no address is typed but the first, nothing is looked up elsewhere. Games are
played by key events. Counted are clicks and drags, and keys that steer no game; seconds are those
of the visitor, without playing and without waiting for Tril. Each part of a task is a line of
FOLDER/first-visit.jsonl, a task that was made again takes the place of the earlier one, and a
picture of the last page of each is kept beside it. TASK-end.png shows where a task ended, also
where it failed.
"""

from __future__ import annotations

import argparse
import json
import re
import shutil
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from playwright.sync_api import Browser, Locator, Page, ViewportSize, expect, sync_playwright

from testsupport.browser import launch_chromium
from testsupport.page_actions import Steering, Visitor, drag_into, handle_of
from testsupport.processes import whole_tril

LEDGER = "first-visit.jsonl"
STEPS = 20_000
VIEW = ViewportSize(width=1280, height=800)
GAME_LIMIT_S = 30
UNDERSTANDING_TIMEOUT_MS = 1_800_000
"""A game that Tril has not seen before is learned first."""
RUN_TIMEOUT_MS = 5_400_000
CHANGE_TIMEOUT_S = 60.0
MOST_CORRECTIONS = 12
LEFT, RIGHT, UP, DOWN = "ArrowLeft", "ArrowRight", "ArrowUp", "ArrowDown"
CLEARNESS = (1.0, 0.85, 0.7, 0.6, 0.4, 0.3, 0.15, 0.0)
"""For how much of a game its side is steered to, the best game first."""
CLEARNESS_OF_SIX = (1.0, 0.8, 0.6, 0.4, 0.2, 0.0)
NONSENSE = (0, 5, 1, 4, 2, 3)
"""An order of six games, as places in their right order."""
PICTURE = "canvas => canvas.toDataURL()"
DOUBT = re.compile("may be chance|contradict it most")


@dataclass(frozen=True)
class Part:
    """What a part of a task took.

    Attributes:
        task: Name of the task.
        part: What was done.
        clicks: Clicks and drags.
        keys: Keys that steer no game.
        seconds: The visitor's own, without the following.
        played_s: Of playing.
        waited_s: Of waiting for Tril.
        told: What the pages said in the end.
    """

    task: str
    part: str
    clicks: int
    keys: int
    seconds: float
    played_s: float
    waited_s: float
    told: str


@dataclass
class Visit:
    """A visitor with what the parts of a task took so far.

    Attributes:
        task: Name of the task.
        visitor: Who is there.
        steps: Of each training.
        folder: For pictures and downloads.
        n_parts: How many parts are done.
    """

    task: str
    visitor: Visitor
    steps: int
    folder: Path
    n_parts: int = 0

    @property
    def page(self) -> Page:
        """The page."""
        return self.visitor.page

    @contextmanager
    def part(self, name: str) -> Iterator[list[str]]:
        """Count what a part takes; what the page says is put into the list."""
        visitor = self.visitor
        before = (visitor.clicks, visitor.keys, visitor.played_s, visitor.waited_s)
        began = time.monotonic()
        told: list[str] = []
        yield told
        taken = time.monotonic() - began
        after = (visitor.clicks, visitor.keys, visitor.played_s, visitor.waited_s)
        clicks, keys, played_s, waited_s = (b - a for a, b in zip(before, after, strict=True))
        own_s = taken - played_s - waited_s
        seconds = (round(own_s, 1), round(played_s), round(waited_s))
        made = Part(self.task, name, int(clicks), int(keys), *seconds, told="; ".join(told))
        self.n_parts += 1
        line = json.dumps(asdict(made))
        print(line, flush=True)
        with (self.folder / LEDGER).open("a", encoding="utf-8") as ledger:
            ledger.write(line + "\n")
        self.page.screenshot(path=self.folder / f"{self.task}-{self.n_parts}.png")


def see_example(visit: Visit) -> None:
    """Open the finished example and see its imitator play."""
    with visit.part("See an example's result") as told:
        told.append(open_example(visit))
        games = visit.page.get_by_role("group", name="Games in step")
        screen = games.get_by_role("img", name=re.compile("^Game screen of")).first
        start_playback(visit, screen, games.get_by_role("button", name="Play", exact=True).first)
    with visit.part("Watch its imitator play live"):
        visit.visitor.follow("Watch the imitator play")
        began = visit.page.get_by_text(re.compile(r"^step [1-9]\d* of \d+$"))
        expect(began.first).to_be_visible()


def open_example(visit: Visit) -> str:
    """Open the finished example; returns its verdict."""
    visit.visitor.click(visit.page.get_by_role("button", name="Open a finished example"))
    verdict = visit.page.get_by_role("region", name="Verdict")
    expect(verdict).to_be_visible()
    return one_line(verdict)


def teach_two_sides(visit: Visit) -> None:
    """Teach one side of Space Invaders by eight games, then the other by the same ones."""
    with visit.part("Stay on the left: create it and play eight games"):
        visit.visitor.follow(re.compile("^All .* games"))
        visit.visitor.follow("Space Invaders")
        create_proposed(visit, "Keep to the left")
        played = play_games(visit, (LEFT,), (RIGHT,), CLEARNESS)
    rank_and_train(visit, played, "eight")
    teach_other_side(visit)


def teach_other_side(visit: Visit) -> None:
    """Teach the right side by the eight games of the left one, in the opposite order."""
    visitor, page = visit.visitor, visit.page
    with visit.part("Stay on the right: create it, take over the eight, reverse the order") as told:
        visitor.follow(re.compile("^Games"))
        visitor.follow("Space Invaders")
        create_proposed(visit, "Keep to the right")
        visitor.step("Rank")
        visitor.click(page.get_by_role("button", name=re.compile("^Take over the 8 games")))
        visitor.click(page.get_by_role("button", name="Reverse the order"))
        visitor.expect_saved()
        told.append(understood(visit))
    with visit.part("Train the other side") as told:
        train(visit, told)


def teach_pong(visit: Visit) -> None:
    """Teach "stay up" in Pong, in the visitor's own words."""
    visitor, page = visit.visitor, visit.page
    with visit.part("Stay up in Pong: create it and play six games"):
        find_game(visit, "Pong")
        visitor.click(page.get_by_role("button", name="Teach a behaviour"))
        dialog = page.get_by_role("dialog")
        visitor.write(dialog.get_by_label("Description"), "Keep the paddle at the top.")
        visitor.write(dialog.get_by_label("Name", exact=True), "Stay up")
        create(visit)
        played = play_games(visit, (UP,), (UP, DOWN, DOWN), CLEARNESS_OF_SIX)
    rank_and_train(visit, played, "six")


def mend_order(visit: Visit) -> None:
    """Rank six games in an order without sense, see why it is not understood, and mend it."""
    visitor, page = visit.visitor, visit.page
    with visit.part("Create a behaviour and play six games"):
        find_game(visit, "Space Invaders")
        create_proposed(visit, "Keep to the left")
        played = play_games(visit, (LEFT,), (RIGHT,), CLEARNESS_OF_SIX)
    with visit.part("Rank them without sense, and be warned") as told:
        rank(visit, [played[place] for place in NONSENSE])
        told.append(understood(visit))
        doubt = page.get_by_role("region", name="What Tril understood").get_by_text(DOUBT).first
        visitor.wait_for(doubt, UNDERSTANDING_TIMEOUT_MS)
        told.append(one_line(doubt))
    with visit.part("Drag what contradicts, until it is understood") as told:
        n_drags = mend(visit, played)
        told.append(f"{n_drags} games dragged")
        told.append(understood(visit))


def mend(visit: Visit, right: Sequence[int]) -> int:
    """Drag one of the two named games above the other until none are named; returns how often.

    Args:
        visit: The visit, on the rank page.
        right: The games in the order that is meant, best first.
    """
    page = visit.page
    panel = page.get_by_role("region", name="What Tril understood")
    named = panel.get_by_text("contradict it most")
    for n_drags in range(MOST_CORRECTIONS):
        settle(panel)
        if not named.count():
            return n_drags
        text = named.inner_text()
        better, worse = map(int, re.findall(r"Recording (\d+)", text))
        if right.index(better) < right.index(worse):
            # The visitor sees that these two are as they were meant.
            return n_drags
        tiers = page.get_by_role("list", name="Tiers, best first")
        target = tiers.get_by_role("listitem").filter(has=handle_of(page.locator("main"), better))
        drag_into(page, handle_of(page.locator("main"), worse), target, "tier")
        visit.visitor.clicks += 1
        visit.visitor.expect_saved()
    return MOST_CORRECTIONS


def send_result(visit: Visit) -> None:
    """Send an example's result as one file, and open it where there is no Tril."""
    visitor, page = visit.visitor, visit.page
    file = visit.folder / "sent.html"
    with visit.part("Send a result to a colleague"):
        open_example(visit)
        began = time.monotonic()
        with page.expect_download(timeout=RUN_TIMEOUT_MS) as download:
            visitor.click(page.get_by_role("button", name="Share"))
        download.value.save_as(file)
        visitor.waited_s += time.monotonic() - began
    open_sent(visit, file)


def open_sent(visit: Visit, file: Path) -> None:
    """Open a file in a browser context without a network, and see it play."""
    browser = visit.page.context.browser
    assert browser is not None
    context = browser.new_context(viewport=VIEW, offline=True)
    colleague = Visit(visit.task, Visitor(context.new_page()), 0, visit.folder, visit.n_parts)
    with colleague.part("The colleague opens the file and sees it play") as told:
        colleague.page.goto(file.resolve().as_uri())
        screen = colleague.page.get_by_role("img", name="Game screen of Imitator")
        play = colleague.page.get_by_role("button", name="Play", exact=True)
        start_playback(colleague, screen, play)
        told.append(f"{file.stat().st_size / 1e6:.1f} MB")
    context.close()


def find_game(visit: Visit, title: str) -> None:
    """Go from the first page to that of a game."""
    visitor, page = visit.visitor, visit.page
    visitor.follow(re.compile("^All .* games"))
    visitor.write(page.get_by_role("searchbox", name="Find a game"), title)
    visitor.press("Enter")
    expect(page.get_by_role("heading", name=title, level=1)).to_be_visible()


def create_proposed(visit: Visit, name: str) -> None:
    """Create a behaviour that the page of a game proposes."""
    visit.visitor.click(visit.page.get_by_role("button", name=f"Teach {name}"))
    create(visit)


def create(visit: Visit) -> None:
    """Create the behaviour that a dialog describes."""
    dialog = visit.page.get_by_role("dialog")
    visit.visitor.click(dialog.get_by_role("button", name="Create behaviour"))
    visit.page.wait_for_url("**/play")


def play_games(
    visit: Visit, keys: Sequence[str], others: Sequence[str], shares: Sequence[float]
) -> list[int]:
    """Play a game for each share of the keys; returns their recordings."""
    return [visit.visitor.play(Steering(keys, others, one), GAME_LIMIT_S) for one in shares]


def rank_and_train(visit: Visit, games: Sequence[int], count: str) -> None:
    """Rank games and train the order, as two parts of a task.

    Args:
        visit: The visit, at the behaviour of the games.
        games: The games, best first.
        count: Their number in words.
    """
    with visit.part(f"Rank the {count} and see what is understood") as told:
        rank(visit, games)
        told.append(understood(visit))
    with visit.part("Train, until the page asks whether it was meant") as told:
        train(visit, told)


def rank(visit: Visit, games: Sequence[int]) -> None:
    """Rank games, best first, on the page that the path leads to."""
    visit.visitor.step("Rank")
    visit.visitor.rank(games)


def understood(visit: Visit) -> str:
    """Return what the rank page says first of the order that is shown."""
    panel = visit.visitor.wait_for_understanding(UNDERSTANDING_TIMEOUT_MS)
    began = time.monotonic()
    settle(panel)
    visit.visitor.waited_s += time.monotonic() - began
    return statement_of(panel.get_by_role("listitem").first)


def settle(panel: Locator) -> None:
    """Wait until what the panel says has been the same for some seconds."""
    deadline = time.monotonic() + CHANGE_TIMEOUT_S
    text, since = "", time.monotonic()
    while time.monotonic() - since < 3 and time.monotonic() < deadline:
        if (now := panel.inner_text()) != text:
            text, since = now, time.monotonic()
        panel.page.wait_for_timeout(200)


def statement_of(item: Locator) -> str:
    """Return a statement with its probability."""
    lines = [line.strip() for line in item.inner_text().splitlines() if line.strip()]
    share = next((line for line in lines if line.endswith("%")), "")
    return f"{lines[0]} ({share})" if share and share != lines[0] else lines[0]


def train(visit: Visit, told: list[str]) -> None:
    """Train the order, and wait for the question whether what was learned was meant."""
    visitor, page = visit.visitor, visit.page
    visitor.follow("Continue to Train")
    visitor.start_training(visit.steps)
    told.append(visitor.wait_for_run(RUN_TIMEOUT_MS))
    expect(page.get_by_text("Is this what you meant?").first).to_be_visible()
    heading = "What Tril understood: better games have"
    statements = page.get_by_role("region", name=heading)
    told.append(statement_of(statements.get_by_role("listitem").first))
    figures = page.get_by_label("Figures", exact=True)
    if figures.count():
        told.append(one_line(figures))


def one_line(what: Locator) -> str:
    """Return a text of several lines in one."""
    return " ".join(what.inner_text().split())


def start_playback(visit: Visit, screen: Locator, play: Locator) -> None:
    """Press a play button, and wait until the picture of a game screen changes."""
    expect(screen).to_be_visible()
    before = screen.evaluate(PICTURE)
    visit.visitor.click(play)
    visit.page.wait_for_function(
        "([canvas, before]) => canvas.toDataURL() !== before", arg=[screen.element_handle(), before]
    )


TASKS: Mapping[str, Callable[[Visit], None]] = {
    "example": see_example,
    "sides": teach_two_sides,
    "pong": teach_pong,
    "order": mend_order,
    "send": send_result,
}


def visit_once(browser: Browser, task: str, folder: Path, steps: int) -> None:
    """Do a task on an empty data folder, and keep what its parts take."""
    data = folder / task
    if data.exists():
        shutil.rmtree(data)
    with whole_tril(data) as tril:
        page = browser.new_page(viewport=VIEW)
        page.set_default_timeout(60_000)
        page.goto(tril.address)
        visit = Visit(task, Visitor(page, np.random.default_rng(0)), steps, folder)
        try:
            TASKS[task](visit)
        finally:
            page.screenshot(path=folder / f"{task}-end.png")
        page.close()


def table_of(parts: Sequence[Part], steps: int) -> str:
    """Return the page of the results, as Markdown."""
    lines = [
        "# What a first visit takes",
        "",
        "`python -m benchmarks.pages.first_visit FOLDER`: Chromium does a visitor's tasks on an "
        "empty data folder, from the first page on, by what stands on the pages alone. Clicks "
        "count drags, keys those that steer no game; a game and Tril's work have columns of their "
        f"own. Trainings are of {steps:,} steps, which show the way, not what can be learned: "
        "[the summary](summary.md) has that.",
        "",
        "| task | clicks | keys | seconds | played, s | Tril worked, s | what the page said |",
        "|---|---:|---:|---:|---:|---:|---|",
    ]
    lines += [
        f"| {one.part} | {one.clicks} | {one.keys} | {one.seconds:.1f} | {one.played_s:.0f} "
        f"| {one.waited_s:.0f} | {one.told.replace('|', '/')} |"
        for one in parts
    ]
    return "\n".join(lines) + "\n"


def read_ledger(path: Path) -> list[Part]:
    """Return the parts that a ledger has, by task; none if there is no ledger."""
    lines = path.read_text(encoding="utf-8").splitlines() if path.exists() else []
    parts = [Part(**json.loads(line)) for line in lines]
    return sorted(parts, key=lambda one: list(TASKS).index(one.task))


def main() -> None:
    """Do the tasks, and print and write the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n\n")[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--tasks", nargs="*", choices=list(TASKS), default=list(TASKS))
    parser.add_argument("--steps", type=int, default=STEPS, help="of each training")
    parser.add_argument("--write", type=Path, help="only write the page of what is known")
    arguments = parser.parse_args()
    expect.set_options(timeout=60_000)  # Beside other work everything takes longer.
    ledger = arguments.folder / LEDGER
    if not arguments.write:
        arguments.folder.mkdir(parents=True, exist_ok=True)
        for task in arguments.tasks:
            others = [one for one in read_ledger(ledger) if one.task != task]
            lines = [json.dumps(asdict(one)) + "\n" for one in others]
            ledger.write_text("".join(lines), encoding="utf-8")
            with sync_playwright() as playwright, launch_chromium(playwright) as browser:
                visit_once(browser, task, arguments.folder, arguments.steps)
    table = table_of(read_ledger(ledger), arguments.steps)
    print(table)
    if arguments.write:
        arguments.write.write_text(table, encoding="utf-8")


if __name__ == "__main__":
    main()
