"""A finished run as one HTML file that plays its games without a server or a network."""

from __future__ import annotations

import base64
import hashlib
import json
import math
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from trainer.reporting.rendering import png_url, render
from trainer.sharing.contents import Contents, SharedGame, levels_of, read_contents
from trainer.sharing.films import DeadlinePassed, Film, film_of, picture_of, png
from trainer.sharing.poster import is_poster, poster_of
from tril import __version__
from tril.errors import Invalid
from tril.files.artifact_store import ArtifactStore, write_whole
from tril.games.base import Console, Game, ScreenSpec
from tril.recording import RecordingRefused
from tril.store.database import Database

MAX_BYTES = 3_000_000
"""Most bytes of a page."""
MOST_RANKED = 24
"""Ranked games that are shown at most; each takes a replay to make."""
FILMS_SHARE = 0.6
"""Of the time that a page may take, for its films."""
FEWER_PICTURES = (1, 3, 6)
"""Frames per picture, tried in turn until the page is small enough."""
SHORTEST_FRAMES = 60
PLOT_HEIGHT = 96
PLOT_PADDING = 6

NAMES = {
    "imitator": "Imitator",
    "clone": "Clone",
    "person": "Person",
    "demonstrator": "Demonstrator",
    "varied": "Varied play",
}


@dataclass(frozen=True)
class Parts:
    """Style and script of share pages, as the frontend's build has them."""

    style: str
    script: str

    def shaped(self, screen: ScreenSpec) -> Parts:
        """Return the parts for pages of a game with this screen."""
        shape = f"{screen.width * screen.pixel_aspect:.3f}/{screen.height}"
        return replace(self, style=f"{self.style}:root{{--screen-shape:{shape}}}")

    @property
    def style_hash(self) -> str:
        """Source expression of the style in a content security policy."""
        return _hash(self.style)

    @property
    def script_hash(self) -> str:
        """Source expression of the script in a content security policy."""
        return _hash(self.script)


@dataclass(frozen=True)
class Plan:
    """How much of a run's games a page holds.

    Attributes:
        n_ranked: Number of ranked games.
        frames_per_picture: Frames that a picture of the two games in step stands for.
        ranked_frames_per_picture: Frames that a picture of the ranked games stands for.
        longest: Last frame of the two games that is shown; None for all.
    """

    n_ranked: int
    frames_per_picture: int = 1
    ranked_frames_per_picture: int = 1
    longest: int | None = None


@dataclass(frozen=True)
class Curve:
    """The learned reward along a game, by step."""

    number: int
    actor: str
    levels: list[float]


@dataclass(frozen=True)
class Plot:
    """The curves of the learned reward on one scale.

    Attributes:
        curves: One for each game.
        last: Last frame of the longest game.
        frames_per_step: Frames of a step.
    """

    curves: tuple[Curve, ...]
    last: int
    frames_per_step: int
    height: int = PLOT_HEIGHT

    @property
    def low(self) -> float:
        """Lowest level; 0 is always on the scale."""
        return min(0.0, *(level for curve in self.curves for level in curve.levels))

    @property
    def high(self) -> float:
        """Highest level; 1 is always on the scale."""
        return max(1.0, *(level for curve in self.curves for level in curve.levels))

    def y(self, level: float) -> float:
        """Return the height of a level, from the top."""
        share = (level - self.low) / (self.high - self.low)
        return round(self.height - PLOT_PADDING - share * (self.height - 2 * PLOT_PADDING), 2)

    def path(self, curve: Curve) -> str:
        """Return a curve as an SVG path."""
        points = (
            f"{min(step * self.frames_per_step, self.last)} {self.y(level)}"
            for step, level in enumerate(curve.levels)
        )
        return f"M{'L'.join(points)}"


@dataclass(frozen=True)
class Shown:
    """A game as a page shows it: its film, a still as a data URL, and a name."""

    game: SharedGame
    film: Film
    still: str
    name: str = ""


@dataclass(frozen=True)
class SharePage:
    """A page and its poster, a PNG."""

    contents: Contents
    html: bytes
    poster: bytes


@dataclass
class _Films:
    """Films of games, made when they are first asked for.

    None of games that do not replay, or were not made in time.

    Attributes:
        console: Console to replay on.
        deadline_s: Time of `time.monotonic` by which they have to be made.
        made: The films by game, frames per picture and last frame.
        late: Numbers of the games whose films were not made in time.
    """

    console: Console
    deadline_s: float = math.inf
    made: dict[tuple[int, int, int | None], Film | None] = field(default_factory=dict)
    late: set[int] = field(default_factory=set)

    def film(
        self, game: SharedGame, frames_per_picture: int, longest: int | None = None
    ) -> Film | None:
        key = game.number, frames_per_picture, longest
        if key not in self.made:
            try:
                self.made[key] = film_of(
                    game.recording,
                    game.still_frame,
                    self.console,
                    frames_per_picture=frames_per_picture,
                    longest=longest,
                    deadline_s=self.deadline_s,
                )
            except RecordingRefused:
                self.made[key] = None
            except DeadlinePassed:
                self.made[key] = None
                self.late.add(game.number)
        return self.made[key]


def make_share_page(
    database: Database,
    store: ArtifactStore,
    run_id: str,
    data: Path,
    parts: Parts,
    within_s: float | None = None,
) -> SharePage:
    """Return a finished run as a page of at most MAX_BYTES.

    Args:
        database: The application's database.
        store: The artifact store.
        run_id: The run.
        data: The data folder.
        parts: Style and script of the page.
        within_s: How long it may take. Ranked games that take longer are left out; None makes all.

    Raises:
        NotFound: No such run, or its behaviour was deleted.
        Conflict: It is not finished.
        Invalid: The page is too large whatever is left out, or not even the two games in step were
            made in time.
    """
    began_s = time.monotonic()
    contents = read_contents(database, run_id, data)
    console = contents.game.make_console()
    # The last part is for the levels and for writing the page.
    films = _Films(console, began_s + FILMS_SHARE * within_s if within_s is not None else math.inf)
    played = [game for game in (contents.imitator, contents.best) if game is not None]
    replaying = [game for game in played if films.film(game, 1) is not None]
    if films.late:
        assert within_s is not None
        raise Invalid(
            f"The games of {contents.game.title} are replayed so slowly that not even two were done"
            f" in {within_s:.0f} s. `tril runs share {run_id} --output page.html` takes as long as"
            " it needs."
        )
    levels = levels_of(database, store, contents, replaying, console)
    longest = max((game.recording.n_frames for game in replaying), default=0)
    for plan in _plans(min(len(contents.ranked), MOST_RANKED), longest):
        html = _page(contents, films, levels, plan, parts).encode()
        if len(html) <= MAX_BYTES:
            stills = [
                (NAMES[game.actor], film.still)
                for game in replaying
                if (film := films.film(game, 1)) is not None
            ]
            console.close()
            return SharePage(contents, html, poster_of(contents, stills))
    raise Invalid(f"This run does not fit into a page of {MAX_BYTES / 1e6:.0f} MB.")


def write_share_page(page: SharePage, path: Path) -> Path:
    """Write a page, and its poster beside it; return the poster's path.

    Raises:
        Invalid: Another picture has the poster's name.
    """
    poster = poster_path(path)
    write_whole(path, page.html)
    write_whole(poster, page.poster)
    return poster


def poster_path(path: Path) -> Path:
    """Return where the poster of a page goes.

    Raises:
        Invalid: There is a file that is no poster, which would be lost.
    """
    poster = path.with_suffix(".png")
    if poster.exists() and not is_poster(poster.read_bytes()):
        raise Invalid(
            f"The page's poster would overwrite {poster}. Move that file, or choose another name"
            " for the page."
        )
    return poster


def _plans(n_ranked: int, longest: int) -> Iterator[Plan]:
    """Yield plans for a page's games, each smaller than the one before."""
    fewest = FEWER_PICTURES[-1]
    for frames in FEWER_PICTURES:
        yield Plan(n_ranked, 1, frames)
    while n_ranked:
        n_ranked = n_ranked * 3 // 4
        yield Plan(n_ranked, 1, fewest)
    for frames in FEWER_PICTURES[1:]:
        yield Plan(0, frames, fewest)
    while longest > SHORTEST_FRAMES:
        longest //= 2
        yield Plan(0, fewest, fewest, longest)


def _page(
    contents: Contents,
    films: _Films,
    levels: Mapping[int, list[float]],
    plan: Plan,
    parts: Parts,
) -> str:
    game = contents.game
    sides = _sides(contents, films, plan)
    shown_numbers = {side.game.number for side in sides}
    last = max((side.film.last for side in sides), default=0)
    tiles = [
        Shown(ranked, film, _still(film, game))
        for ranked in _spread(contents.ranked, plan.n_ranked)
        if (film := films.film(ranked, plan.ranked_frames_per_picture)) is not None
    ]
    # The best game is ranked, too, as a rule: its film is there already.
    kept = {tile.game.number: tile for tile in tiles} | {s.game.number: s for s in sides}
    plot = _plot(sides, levels, last, game)
    summary = contents.verdict.sentence if contents.verdict else contents.behaviour.description
    return render(
        "share.html.j2",
        parts=parts.shaped(game.screen),
        tril=__version__,
        contents=contents,
        behaviour=contents.behaviour,
        game=game,
        screen=game.screen,
        summary=summary,
        sides=sides,
        plot=plot,
        last=last,
        tiles=tiles,
        names=NAMES,
        told=list(_told(contents, plan, sides, tiles, len(films.late))),
        screen_json=_json(
            {
                "width": game.screen.width,
                "height": game.screen.height,
                "pixel_aspect": game.screen.pixel_aspect,
                "palette": None if game.screen.palette is None else game.screen.palette.tolist(),
                "frame_rate_hz": game.clock.frame_rate_hz,
                "frames_per_step": game.clock.frames_per_step,
                "last": last,
                "low": plot.low if plot else 0,
                "high": plot.high if plot else 1,
                "plot_height": PLOT_HEIGHT,
                "plot_padding": PLOT_PADDING,
            }
        ),
        films=[
            _json(
                {
                    "number": number,
                    "last": shown.film.last,
                    "frames_per_picture": shown.film.frames_per_picture,
                    "content": base64.b64encode(shown.film.content).decode(),
                    "levels": levels.get(number) if number in shown_numbers else None,
                }
            )
            for number, shown in kept.items()
        ],
    )


def _sides(contents: Contents, films: _Films, plan: Plan) -> list[Shown]:
    sides = []
    for game in (contents.imitator, contents.best):
        if game is None:
            continue
        film = films.film(game, plan.frames_per_picture, plan.longest)
        if film is None:
            continue
        name = f"{NAMES[game.actor]}, best game"
        if game is contents.imitator:
            name = NAMES["imitator"]
        sides.append(Shown(game, film, _still(film, contents.game), name))
    return sides


def _plot(
    sides: Sequence[Shown], levels: Mapping[int, list[float]], last: int, game: Game
) -> Plot | None:
    if not sides or not levels:
        return None
    frames_per_step = game.clock.frames_per_step
    curves = tuple(
        Curve(
            side.game.number,
            side.game.actor,
            # Of a game that is cut, as much as is shown.
            levels[side.game.number][: -(-side.film.last // frames_per_step) + 1],
        )
        for side in sides
    )
    return Plot(curves, last, frames_per_step)


def _spread(games: Sequence[SharedGame], n: int) -> list[SharedGame]:
    """Return some of the games, evenly from the first to the last."""
    if n >= len(games):
        return list(games)
    if n < 2:
        return list(games[:n])
    return [games[round(place * (len(games) - 1) / (n - 1))] for place in range(n)]


def _told(
    contents: Contents, plan: Plan, sides: Sequence[Shown], tiles: Sequence[Shown], n_late: int
) -> Iterator[str]:
    """Yield what the page shows of the games and what it leaves out."""
    rate_hz = contents.game.clock.frame_rate_hz
    if sides:
        shown = "Both games are shown" if len(sides) == 2 else "The game is shown"
        if plan.frames_per_picture == 1:
            yield f"{shown} frame by frame, {rate_hz} a second, exactly as played."
        else:
            yield (
                f"{shown} with {rate_hz / plan.frames_per_picture:.0f} of {rate_hz} pictures a"
                " second, so that the file stays small."
            )
        if plan.longest is not None:
            yield f"Only the first {plan.longest / rate_hz:.0f} s are shown, for the same reason."
    missing = sum(g is not None for g in (contents.imitator, contents.best)) - len(sides)
    if missing:
        which = "One of the two games" if sides else "The game of imitator or person"
        yield f"{which} can't be replayed here and is left out."
    if tiles and plan.ranked_frames_per_picture > 1:
        yield (
            f"Ranked games are shown with {rate_hz / plan.ranked_frames_per_picture:.0f} pictures"
            " a second."
        )
    if n_late:
        yield (
            f"{len(tiles)} of {len(contents.ranked)} ranked games are shown; {n_late} took too long"
            " to replay. The command tril runs share takes as long as it needs."
        )
    elif len(tiles) < len(contents.ranked):
        yield (
            f"{len(tiles)} of {len(contents.ranked)} ranked games are shown, evenly from the best"
            " to the worst."
        )


def _still(film: Film, game: Game) -> str:
    return png_url(png(picture_of(film.still, game)))


def _json(values: Any) -> str:
    """Return JSON that is safe within a script element."""
    return json.dumps(values, separators=(",", ":")).replace("<", "\\u003c")


def _hash(text: str) -> str:
    return f"sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}"
