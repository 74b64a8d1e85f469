"""Any game, from the empty page to an imitator, in a browser.

    python -m benchmarks.games.taught FOLDER                 # all eight, one after the other
    python -m benchmarks.games.taught FOLDER --games pong --pictures docs/results/games
    python -m benchmarks.games.taught FOLDER --write docs/results/other-games.md

Chromium finds a game on the page of games, creates a behaviour, plays games by key events that hold
the behaviour's keys ever less, keeps and ranks them, trains by `any` and waits for the end. Each
game is a line of FOLDER/taught.jsonl; games that have one are left out, so that a call that was cut
short goes on. Pictures of the pages are kept beside it, or in the named folder.
"""

from __future__ import annotations

import argparse
import io
import json
import re
import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from PIL import Image
from playwright.sync_api import Page, TimeoutError, ViewportSize, expect, sync_playwright

from testsupport.browser import launch_chromium
from testsupport.page_actions import Steering, Visitor
from testsupport.processes import TrilProcess, whole_tril
from tril.games import game_named

STEPS = 20_000
GAME_S = 12
SHARES = (1.0, 0.8, 0.6, 0.4, 0.2, 0.0)
"""For how much of a game the behaviour's keys are held, best game first."""
TRAINING_LIMIT_S = 5400
VIEW = ViewportSize(width=1280, height=800)


@dataclass(frozen=True)
class Lesson:
    """A behaviour of a game that a player who holds keys can show.

    Attributes:
        game: Name of the game.
        name: Of the behaviour.
        description: What it says.
        keys: Keys of which the better games hold one or another.
        others: Keys that are held otherwise; "" holds none.
    """

    game: str
    name: str
    description: str
    keys: tuple[str, ...]
    others: tuple[str, ...]


UP, DOWN, LEFT, RIGHT = "ArrowUp", "ArrowDown", "ArrowLeft", "ArrowRight"
LESSONS = (
    Lesson("pong", "Stay up", "Keep the paddle at the top.", (UP,), (UP, DOWN, DOWN)),
    Lesson(
        "breakout", "Stay on the left", "Keep the paddle at the left.", (LEFT,), (RIGHT, LEFT, "")
    ),
    Lesson("freeway", "Cross", "Walk up whatever comes.", (UP,), (DOWN, "", UP)),
    Lesson("ms_pacman", "Left half", "Stay in the left half.", (LEFT, UP, LEFT), (RIGHT, DOWN, UP)),
    Lesson("seaquest", "Deep", "Dive and stay deep.", (DOWN,), (UP, LEFT, RIGHT)),
    Lesson("boxing", "Lower right", "Stay in the lower right corner.", (DOWN, RIGHT), (UP, LEFT)),
    Lesson("gym:MountainCar-v0", "Left hill", "Climb the left hill.", (LEFT,), (RIGHT, "")),
    Lesson(
        "gym:MiniGrid-Empty-16x16-v0", "Turn left", "Turn left again and again.", (LEFT,), (UP, UP)
    ),
)


class Player:
    """A person who plays, ranks and trains one behaviour in a browser.

    Args:
        page: A page that is signed in.
        tril: The Tril that serves it.
        lesson: What is taught.
        pictures: The folder of its pictures.
    """

    def __init__(self, page: Page, tril: TrilProcess, lesson: Lesson, pictures: Path) -> None:
        self.page = page
        self.tril = tril
        self.lesson = lesson
        self.game = game_named(lesson.game)
        self.pictures = pictures
        self.visitor = Visitor(page)

    def teach(self) -> dict[str, Any]:
        """Go from the page of games to the end of the training; returns the line of the ledger."""
        began = time.monotonic()
        behaviour = self._create()
        recordings = [self._play(share) for share in SHARES]
        played = time.monotonic()
        self._rank(behaviour, recordings)
        run = self._train(behaviour)
        trained = time.monotonic()
        return {
            "game": self.lesson.game,
            "title": self.game.title,
            "behaviour": self.lesson.name,
            "rewound": self.game.saves_states,
            "play_s": round(played - began),
            "train_s": round(trained - played),
            "clicks": self.visitor.clicks,
            **self._look(run),
        }

    def _create(self) -> int:
        """Create the behaviour from the page of the game; returns its id."""
        self.page.goto("/games")
        # One that is not of the emulator is opened by its name.
        self.page.goto(f"/games/{self.lesson.game}")
        visitor = self.visitor
        visitor.click(self.page.get_by_role("button", name="Teach a behaviour"))
        dialog = self.page.get_by_role("dialog")
        visitor.write(dialog.get_by_label("Description"), self.lesson.description)
        visitor.write(dialog.get_by_label("Name", exact=True), self.lesson.name)
        visitor.click(dialog.get_by_text("How it is played"))
        seconds = dialog.get_by_label("Longest game, in seconds")
        with suppress(TimeoutError):
            seconds.wait_for(timeout=2_000)
            visitor.write(seconds, str(GAME_S))
        visitor.click(dialog.get_by_role("button", name="Create behaviour"))
        self.page.wait_for_url("**/play")
        address = re.search(r"/behaviours/(\d+)/", self.page.url)
        assert address is not None
        return int(address.group(1))

    def _play(self, share: float) -> int:
        """Play a game and keep it; returns its recording."""
        midway = None
        if share == SHARES[0]:
            midway = self._rewind if self.game.saves_states else self._photograph_play
        steering = Steering(self.lesson.keys, self.lesson.others, share)
        return self.visitor.play(steering, 2 * GAME_S, midway)

    def _rewind(self) -> None:
        self.visitor.hold("Backspace", 0.5)
        self._photograph_play()

    def _photograph_play(self) -> None:
        self._photograph("play")

    def _rank(self, behaviour: int, recordings: Sequence[int]) -> None:
        """Put the games in order by the buttons of the page, best first."""
        self.page.goto(f"/behaviours/{behaviour}/rank")
        self.visitor.rank(recordings)
        self.visitor.wait_for_understanding(1_800_000)
        self._photograph("rank")

    def _train(self, behaviour: int) -> str:
        """Train to the end; returns the run's id."""
        self.page.goto(f"/behaviours/{behaviour}/train")
        self.page.get_by_role("radio", name=re.compile("^any")).check()
        self.page.get_by_text("More settings").click()
        self.page.get_by_label(re.compile("Go on anyway", re.IGNORECASE)).check()
        self.visitor.clicks += 3
        self.visitor.start_training(STEPS)
        run = self.page.url.rpartition("/")[2]
        self.visitor.wait_for_run(1000 * TRAINING_LIMIT_S)
        return run

    def _look(self, run: str) -> dict[str, Any]:
        """Look at the run; returns what it says of itself."""
        self.page.goto(f"/runs/{run}")
        with suppress(AssertionError):
            expect(self.page.get_by_role("group", name="Games in step")).to_be_visible()
        self.page.wait_for_timeout(4_000)
        self._photograph("run")
        with self.tril.http() as http:
            shown = http.get(f"/api/runs/{run}").json()
            results = http.get(f"/api/runs/{run}/results").json()
        check: Mapping[str, Any] = results["check"] or {}
        told = [
            f"{statement['sentence']} ({statement['probability']:.0%})"
            for statement in check.get("statements", ())[:2]
        ]
        return {"status": shown["status"], "told": told, "tau": check.get("tau")}

    def _photograph(self, what: str) -> None:
        """Keep a picture of the page as it stands."""
        picture = Image.open(io.BytesIO(self.page.screenshot()))
        path = self.pictures / picture_name(self.lesson.game, what)
        picture.convert("RGB").save(path, quality=60, method=6)


def table_of(rows: Sequence[Mapping[str, Any]], pictures: str) -> str:
    """Return the page of the results, as Markdown.

    Args:
        rows: Lines of the ledger.
        pictures: Their folder, seen from the page.
    """
    lines = [
        "# Other games, from the empty page to an imitator",
        "",
        "`python -m benchmarks.games.taught FOLDER`, in a browser: six games of "
        f"{GAME_S} s by key events that hold the behaviour's keys from all of the time to none of "
        f"it, put in order by buttons, {STEPS:,} steps of `any`. It shows that the way through the "
        "page is open in any game. So few steps are no measure of what can be learned: "
        "[statements](../decisions/26-statements.md) has that. Times are of a busy machine.",
        "",
        "| game | behaviour | clicks | played | trained | what Tril understood | tau | pages |",
        "|---|---|---:|---:|---:|---|---:|---|",
    ]
    for row in rows:
        cells = (
            row["title"],
            row["behaviour"],
            str(row["clicks"]),
            f"{row['play_s']} s",
            f"{row['train_s'] / 60:.0f} min, {row['status']}",
            "; ".join(row["told"]),
            "" if row["tau"] is None else f"{row['tau']:.2f}",
            ", ".join(
                f"[{page}]({pictures}/{picture_name(row['game'], page)})"
                for page in ("play", "rank", "run")
            ),
        )
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines) + "\n"


def picture_name(game: str, page: str) -> str:
    """Return the file name of a page's picture."""
    return re.sub(r"\W+", "-", game) + f"-{page}.webp"


def main() -> None:
    """Teach the behaviours that the folder does not have, and write the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n\n")[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--games", nargs="*", default=[lesson.game for lesson in LESSONS])
    parser.add_argument("--pictures", type=Path, help="their folder; FOLDER/pictures by default")
    parser.add_argument("--write", type=Path, help="only write the page of what is known")
    arguments = parser.parse_args()
    expect.set_options(timeout=60_000)  # Beside other work everything takes longer.
    ledger = arguments.folder / "taught.jsonl"
    rows = [json.loads(line) for line in ledger.read_text().splitlines()] if ledger.exists() else []
    if arguments.write:
        arguments.write.write_text(table_of(rows, "games"))
        return
    pictures: Path = arguments.pictures or arguments.folder / "pictures"
    pictures.mkdir(parents=True, exist_ok=True)
    known = {row["game"] for row in rows}
    wanted = [x for x in LESSONS if x.game in arguments.games and x.game not in known]
    with (
        whole_tril(arguments.folder / "data") as tril,
        sync_playwright() as playwright,
        launch_chromium(playwright) as browser,
    ):
        for lesson in wanted:
            page = browser.new_page(viewport=VIEW, base_url=tril.base_url)
            page.set_default_timeout(60_000)
            page.goto(tril.address)
            row = Player(page, tril, lesson, pictures).teach()
            page.close()
            with ledger.open("a") as file:
                file.write(json.dumps(row) + "\n")
            print(json.dumps(row), flush=True)


if __name__ == "__main__":
    main()
