"""Varied play: games that between them show many ways of being good and bad at anything.

They know of no behaviour. Most are played towards a few aliens drawn by chance, flawlessly or with
a person's errors; the others are random play. Random play alone seldom lives long enough to hit
more than two aliens, so that it says little about what comes later in a game.
"""

from __future__ import annotations

import numpy as np

from tril.demonstrator.error_model import person
from tril.demonstrator.human_like import HumanLikePlayer
from tril.demonstrator.plans import DemonstrationPlan, draw_hits
from tril.demonstrator.player import ScriptedPlayer, draw_style
from tril.demonstrator.random_play import play_randomly
from tril.game.console import Console
from tril.game.episode import Episode, draw_start
from tril.game.space_invaders import COLUMNS, ROWS
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
    console = console or Console()
    if rng.random() < RANDOM_SHARE:
        return play_randomly(rng, console)
    recorder = Recorder(Episode(console, draw_start(rng)))
    wanted = draw_hits(draw_plan(rng), rng, first_column=int(rng.integers(COLUMNS)))
    style = draw_style(rng)
    if rng.random() < FLAWLESS_SHARE:
        ScriptedPlayer(recorder, wanted, style, rng).play()
    else:
        errors = person(int(rng.choice(REACTION_MS)))
        HumanLikePlayer(recorder, wanted, style, errors, rng).play()
    return verify(recorder.recording(), console=console)
