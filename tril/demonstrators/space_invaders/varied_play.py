"""Varied play: games that between them show many ways of being good and bad at anything.

They know of no behaviour. Most are played towards a few aliens drawn by chance, flawlessly or with
a person's errors; the others are random play. Random play alone seldom lives long enough to hit
more than two aliens, so that it says little about what comes later in a game.
"""

from __future__ import annotations

import numpy as np

from tril.demonstrators.error_model import person
from tril.demonstrators.random_play import play_randomly
from tril.demonstrators.space_invaders.human_like import HumanLikePlayer
from tril.demonstrators.space_invaders.plans import DemonstrationPlan, draw_hits
from tril.demonstrators.space_invaders.player import ScriptedPlayer, draw_style
from tril.games.base import Cell, Console, Start, draw_start
from tril.games.space_invaders import SPACE_INVADERS
from tril.games.space_invaders.memory import COLUMNS, ROWS
from tril.play.episode import Episode
from tril.recording import Recorder, Verified, verify

RANDOM_SHARE = 0.25
"""Share of random play."""

FLAWLESS_SHARE = 0.5
"""Share of flawless play among the others."""

MAX_COLUMNS = 3
"""Most columns that a game's aliens are drawn from."""

MAX_HITS = 10
"""Most aliens that a game is played towards."""

REACTION_MS = (150, 250, 350)
"""Reaction times of the players that make errors, in milliseconds."""


def draw_plan(rng: np.random.Generator) -> DemonstrationPlan:
    """Draw a few aliens of one to three columns, or of all, to play towards."""
    n_columns = int(rng.integers(1, MAX_COLUMNS + 2))
    columns = rng.permutation(COLUMNS)[: n_columns if n_columns <= MAX_COLUMNS else COLUMNS]
    allowed = frozenset((row, column) for row in range(ROWS) for column in columns.tolist())
    return DemonstrationPlan(1, "Varied play", allowed, 1, min(MAX_HITS, len(allowed)))


def play_varied(rng: np.random.Generator, console: Console | None = None) -> Verified:
    """Play one varied game to its end and verify the recording.

    Args:
        rng: Source of all draws.
        console: The console to play on; None loads one.

    Raises:
        RecordingRefused: The replay differs, because the emulator is not deterministic.
    """
    console = console or SPACE_INVADERS.make_console()
    if rng.random() < RANDOM_SHARE:
        return play_randomly(rng, console)
    start = draw_start(SPACE_INVADERS.starts, rng)
    hits = draw_hits(draw_plan(rng), rng, first_column=int(rng.integers(COLUMNS)))
    return play_towards(hits, start, rng, console)


def play_towards(
    hits: tuple[Cell, ...], start: Start, rng: np.random.Generator, console: Console
) -> Verified:
    """Play towards these aliens, flawlessly or with a person's errors."""
    recorder = Recorder(Episode(console, start))
    style = draw_style(rng)
    if rng.random() < FLAWLESS_SHARE:
        ScriptedPlayer(recorder, hits, style, rng).play()
    else:
        errors = person(int(rng.choice(REACTION_MS)))
        HumanLikePlayer(recorder, hits, style, errors, rng).play()
    return verify(recorder.recording(), console=console)
