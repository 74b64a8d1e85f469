"""The games that come with the emulator, and what the survey found of each."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from ale_py import roms

CATALOGUE = Path(__file__).with_name("catalogue.json")
"""Written by scripts.surveys.atari."""

_TITLES = {
    "atlantis2": "Atlantis II",
    "darkchambers": "Dark Chambers",
    "earthworld": "SwordQuest: EarthWorld",
    "et": "E.T.",
    "hero": "H.E.R.O.",
    "jamesbond": "James Bond",
    "koolaid": "Kool-Aid Man",
    "kung_fu_master": "Kung-Fu Master",
    "mario_bros": "Mario Bros.",
    "montezuma_revenge": "Montezuma's Revenge",
    "mr_do": "Mr. Do!",
    "ms_pacman": "Ms. Pac-Man",
    "pacman": "Pac-Man",
    "pitfall": "Pitfall!",
    "pitfall2": "Pitfall II",
    "qbert": "Q*bert",
    "riverraid": "River Raid",
    "star_gunner": "Stargunner",
    "tic_tac_toe_3d": "3-D Tic-Tac-Toe",
    "trondead": "Tron: Deadly Discs",
    "up_n_down": "Up 'n Down",
    "yars_revenge": "Yars' Revenge",
}


@dataclass(frozen=True)
class Entry:
    """What is known of a game.

    Attributes:
        rom: Name of its ROM, e.g. "ms_pacman".
        md5: MD5 of the ROM that was surveyed.
        screen: Height and width in pixels.
        background: Gray that most of the screen has when play begins.
        pal: Whether its colours are those of PAL, else those of NTSC.
        actions: Names of its actions.
        modes: Modes of the cartridge.
        difficulties: Positions of the difficulty switch.
        lives: Lives at its start; 0 where the emulator counts none.
        intro: Frames before play begins, the action held at first, and for how many of them; None
            if no action made a difference on the screen.
        hidden: Areas that show score or lives: left, top, right, bottom.
    """

    rom: str
    md5: str
    screen: tuple[int, int]
    background: int
    pal: bool
    actions: tuple[str, ...]
    modes: tuple[int, ...]
    difficulties: tuple[int, ...]
    lives: int
    intro: Mapping[str, int] | None
    hidden: tuple[tuple[int, int, int, int], ...]

    @property
    def title(self) -> str:
        """The game's name for people."""
        return _TITLES.get(self.rom) or self.rom.replace("_", " ").title()


def rom_path(rom: str) -> Path:
    """Return the path of a ROM: in the emulator's package, not in ALE_ROMS_DIR."""
    return Path(roms.__file__).with_name(f"{rom}.bin")


@cache
def rom_md5(rom: str) -> str:
    """Return the MD5 of a ROM."""
    return hashlib.md5(rom_path(rom).read_bytes(), usedforsecurity=False).hexdigest()


@cache
def entries() -> Mapping[str, Entry]:
    """Return the catalogue's entries by the name of their ROM."""
    surveyed: dict[str, Any] = json.loads(CATALOGUE.read_text())
    return {
        rom: Entry(
            rom=rom,
            md5=entry["md5"],
            screen=tuple(entry["screen"]),
            background=entry["background"],
            pal=entry["pal"],
            actions=tuple(entry["actions"]),
            modes=tuple(entry["modes"]),
            difficulties=tuple(entry["difficulties"]),
            lives=entry["lives"],
            intro=entry["intro"],
            hidden=tuple(tuple(area) for area in (*entry["score"], *entry["life"])),
        )
        for rom, entry in surveyed.items()
    }
