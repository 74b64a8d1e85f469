"""Every game that comes with the emulator, without a module of its own."""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

from tril.errors import Invalid
from tril.games.atari.catalogue import Entry, entries, rom_md5, rom_path
from tril.games.atari.console import AtariConsole, Intro
from tril.games.atari.joystick import joystick
from tril.games.atari.palette import PIXEL_ASPECT, palette_grayscale, palette_rgb
from tril.games.atari.readout import ENDS, LIFE, OVER, AtariReadout
from tril.games.atari.ready_made import READY_MADE
from tril.games.atari.starts import AtariStarts, Legs
from tril.games.base import Clock, Game, GameFamily, Rectangle, ScreenSpec, StartCache
from tril.games.things import Tally, thing_from_json


class AtariFamily:
    """The games of the emulator's package, each by the name of its ROM."""

    def titles(self) -> Mapping[str, str]:
        """Return the titles of all of them by their names."""
        return {name: entry.title for name, entry in entries().items()}

    def game(self, name: str) -> Game | None:
        """Return a game, None if there is no such ROM.

        Raises:
            Invalid: The emulator's package has another ROM than the one that was surveyed.
        """
        entry = entries().get(name)
        if entry is None:
            return None
        if not rom_path(name).exists() or rom_md5(name) != entry.md5:
            raise Invalid(
                f"The installed ale-py has another {entry.title} than this version of Tril knows:"
                " install the version that Tril asks for."
            )
        return _game(entry)


@cache
def _known_things() -> dict[str, Any]:
    """Return the things and tallies of each game; a test compares them with the picture.

    The addresses are those of AtariARI (Anand et al. 2019, Unsupervised State Representation
    Learning in Atari; MIT licence), the offsets were fitted to screens.
    """
    known_things: dict[str, Any] = json.loads(Path(__file__).with_name("things.json").read_text())
    return known_things


def _game(entry: Entry) -> Game:
    intro = entry.intro or {"frames": 0, "button": 0, "hold": 0}

    def console(game: Game, start_cache: StartCache) -> AtariConsole:
        return AtariConsole(game, rom_path(entry.rom), Intro(**intro), start_cache)

    controls = joystick(entry.actions, turned=entry.rom in _TURNED)
    known_things = _known_things().get(entry.rom, {})
    return Game(
        name=entry.rom,
        title=entry.title,
        version=entry.md5,
        clock=Clock(),
        controls=controls,
        starts=AtariStarts(
            title=entry.title,
            legs=Legs(actions=tuple(range(controls.n_actions)), max_steps=LEG_STEPS),
            modes=entry.modes,
            difficulties=entry.difficulties,
            has_intro=intro["frames"] > 0,
        ),
        screen=ScreenSpec(
            *entry.screen,
            palette=palette_rgb(entry.pal),
            grayscale=palette_grayscale(entry.pal),
            hidden=tuple(Rectangle(*area) for area in entry.hidden),
            background=entry.background,
            pixel_aspect=PIXEL_ASPECT,
        ),
        ends=ENDS,
        end_rules=(LIFE, OVER) if entry.lives else (OVER,),
        new_console=console,
        new_readout=AtariReadout,
        things={
            name: thing_from_json(thing) for name, thing in known_things.get("things", {}).items()
        },
        behaviours=READY_MADE.get(entry.rom, ()),
        pieces=known_things.get("pieces", ""),
        tallies={name: Tally(**tally) for name, tally in known_things.get("tallies", {}).items()},
    )


_TURNED = frozenset({"pong"})
"""Games whose paddle goes down by left and up by right."""

LEG_STEPS = 6
"""Longest leg of an opening: three of them take 1.2 s at most."""

ATARI: GameFamily = AtariFamily()
