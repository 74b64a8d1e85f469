"""A page of each behaviour: what was ranked, what Tril said, and what it plays, with clips.

    python -m benchmarks.learning.behaviours.pages FOLDER --output docs/results/behaviours

Shows what `benchmarks.learning.behaviours.imitators` kept in the folder: one page for each
behaviour that was taught by the recipe `any`, with the figures of other recipes beside it.
"""

from __future__ import annotations

import argparse
import io
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from benchmarks.learning.behaviours.games import from_row
from benchmarks.learning.behaviours.suite import EVENT_STEPS, task_named
from server.clips.render import render
from server.clips.request import ClipKind
from server.play.replays.strip import N_MOMENTS, SMALL_COLUMNS, StripFormat, strip_webp
from tril.games import game_named
from tril.games.base import Console
from tril.recording import Recording

N_SHOWN = 4
"""Ranked games that a page shows, from the best to the worst."""
SCALE = 2
"""Enlargement of their moments."""
CLIP_S = 10
LEAST_TOLD = 0.01
"""Probability of a statement that a page tells."""
ALIKE = 0.02
"""Share of the best efforts by which imitator and clone may differ and count as equal."""
PLAYERS = {"best_effort": "best effort", "imitator": "imitator", "clone": "clone"}
"""Whose games a page shows as clips, with what it calls them."""

Kept = Mapping[str, Any]
"""What `imitators` kept of a training."""


def order_picture(recordings: Sequence[Recording], console: Console) -> bytes:
    """Return ranked games as a WebP, a row of eight moments each, the best game first."""
    rows = []
    for recording in recordings:
        sheet = Image.open(io.BytesIO(strip_webp(recording, console)))
        size = StripFormat.of(recording.game.screen)
        top = sheet.height - N_MOMENTS // SMALL_COLUMNS * size.small_height
        width = SMALL_COLUMNS * size.small_width
        # The sheet's reduced moments, (2, 4) of them, side by side.
        lines = [
            np.asarray(sheet)[begin : begin + size.small_height, :width]
            for begin in range(top, sheet.height, size.small_height)
        ]
        row = np.concatenate(lines, axis=1)
        rows.append(row.repeat(SCALE, axis=0).repeat(SCALE, axis=1))
    file = io.BytesIO()
    Image.fromarray(np.concatenate(rows)).save(file, "WEBP", lossless=True, quality=80, method=6)
    return file.getvalue()


class BehaviourPage:
    """The page of a behaviour, in Markdown, and its pictures.

    Args:
        kept: What was kept of its training by `any`.
        others: The same of other recipes.
    """

    def __init__(self, kept: Kept, others: Sequence[Kept]) -> None:
        self._kept = kept
        self._others = others
        self._game = game_named(kept["game"])
        self._task = task_named(kept["game"], kept["task"])
        self.name = f"{kept['game']}-{kept['task'].replace(' ', '-')}"
        self.title = f"{self._game.title}: {kept['task']}"

    def write(self, folder: Path) -> None:
        """Write the page and its pictures."""
        console = self._game.make_console()
        games = self._kept["games"]
        n_ranked = len(games["ranked"])
        self._shown = np.rint(np.linspace(0, n_ranked - 1, N_SHOWN)).astype(int).tolist()
        ranked = [from_row(games["ranked"][place], self._game) for place in self._shown]
        (folder / f"{self.name}-order.webp").write_bytes(order_picture(ranked, console))
        n_frames = CLIP_S * self._game.clock.frame_rate_hz
        for player in PLAYERS:
            recording = from_row(games[player], self._game)
            shown = recording.until(min(n_frames, recording.n_frames))
            clip = render(shown, ClipKind.WEBP, console)
            (folder / f"{self.name}-{player}.webp").write_bytes(clip)
        console.close()
        (folder / f"{self.name}.md").write_text(self._text(), encoding="utf-8")

    def _text(self) -> str:
        kept = self._kept
        worths = kept["games"]["ranked_worths"]
        places = ", ".join(f"{place + 1} ({self._worth(worths[place])})" for place in self._shown)
        lines = [
            f"# {self.title}",
            "",
            f"{self.verdict}",
            "",
            "## What was ranked",
            "",
            f"{kept['ranked']} games of a scripted player with a person's delays and mistakes, in"
            " an order in which a quarter of the neighbours are swapped, and"
            f" {kept['best']} best efforts. The picture has eight moments each of the games in"
            f" places {places}; in brackets, what each is worth by the behaviour's own measure,"
            " which Tril never sees:",
            "",
            f"![Four ranked games]({self.name}-order.webp)",
            "",
            "## What Tril said",
            "",
            *(f"- {sentence} ({share})" for share, sentence in self.told),
            "",
            "The check of the order "
            + ("passed." if kept["passed"] else "refused it; it was trained all the same."),
            "",
            "## What it plays",
            "",
            f"| {' | '.join(PLAYERS.values())} |",
            f"|{'---|' * len(PLAYERS)}",
            "| " + " | ".join(f"![Game]({self.name}-{one}.webp)" for one in PLAYERS) + " |",
            "",
            f"The first {CLIP_S} s: of the best of the best efforts, and of the games of imitator"
            " and clone that are of median worth.",
            "",
            "| player | worth | lost |",
            "|---|---:|---:|",
            *(f"| {name} | {self._worth(worth)} | {lost} |" for name, worth, lost in self.figures),
            "",
            f"Of whole games from {self._game.starts.n_evaluation} evaluation starts, with sticky"
            f" actions. {kept['steps']:,} steps, training seed {kept['seed']}, one training each.",
        ]
        return "\n".join(lines) + "\n"

    @property
    def told(self) -> list[tuple[str, str]]:
        """What Tril said: share and sentence."""
        pairs = [one.split(" ", 1) for one in self._kept["told"]]
        return [
            (f"{float(share):.0%}", sentence)
            for share, sentence in pairs
            if float(share) >= LEAST_TOLD
        ]

    @property
    def figures(self) -> list[tuple[str, float, str]]:
        """Each player's name, mean worth and share of lost games."""
        rows = [(f"imitator, `{self._kept['recipe']}`", self._kept["imitator"])]
        rows += [(f"imitator, `{one['recipe']}`", one["imitator"]) for one in self._others]
        rows += [("clone", self._kept["clone"]), ("replay of a best effort", self._kept["tape"])]
        return [(name, one["worth"], f"{one['died']:.0%}") for name, one in rows] + [
            ("the player's best efforts", self._kept["best_efforts"], ""),
            ("the ranked games", self._kept["ranked_games"], ""),
        ]

    @property
    def verdict(self) -> str:
        """What came of it, in a sentence."""
        imitator, clone = self._kept["imitator"]["worth"], self._kept["clone"]["worth"]
        best = self._kept["best_efforts"]
        beside = "as much as"
        if abs(imitator - clone) >= ALIKE * best:
            beside = "more than" if imitator > clone else "less than"
        return (
            f"**The imitator reaches {imitator / best:.0%} of the best efforts, {beside} its clone"
            f" ({clone / best:.0%}).**"
        )

    def _worth(self, worth: float) -> str:
        """Return a worth as people read it: a share of the time, or a number of events."""
        if not self._task.counts_events:
            return f"{worth:.0%}"
        return f"{worth * self._game.clock.max_steps / EVENT_STEPS:.1f}"


def index_of(pages: Sequence[BehaviourPage]) -> str:
    """Return the page that leads to those of the behaviours, in Markdown."""
    links = [f"- [{page.title}]({page.name}.md): {page.verdict}" for page in pages]
    names = [page.name for page in pages]
    return "\n".join(
        [
            "# Behaviours, one by one",
            "",
            "What was ranked, what Tril said and what is played, with clips, written by"
            " `python -m benchmarks.learning.behaviours.pages FOLDER`.",
            "",
            *links,
            "",
            "```{toctree}",
            ":hidden:",
            *names,
            "```",
            "",
        ]
    )


def main() -> None:
    """Write the pages."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--output", type=Path, required=True)
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args()
    kept = [json.loads(one.read_text()) for one in sorted(arguments.folder.glob("*.trained.json"))]
    kept = [one for one in kept if one["seed"] == arguments.seed]
    arguments.output.mkdir(parents=True, exist_ok=True)
    pages: list[BehaviourPage] = []
    for row in kept:
        if row["recipe"] != "any":
            continue
        of_behaviour = (row["game"], row["task"])
        others = [
            one
            for one in kept
            if (one["game"], one["task"]) == of_behaviour and one["recipe"] != "any"
        ]
        page = BehaviourPage(row, others)
        page.write(arguments.output)
        pages.append(page)
        print(f"{page.title}: {page.verdict}", flush=True)
    (arguments.output / "README.md").write_text(index_of(pages), encoding="utf-8")


if __name__ == "__main__":
    main()
