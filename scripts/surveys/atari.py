"""What the console itself tells of every game: where play begins, and what shows score and lives.

    python -m scripts.surveys.atari              # writes catalogue.json, about 15 minutes
    python -m scripts.surveys.atari pong         # prints one game's entry

No game is known here. Play begins at the first frame at which a key makes a difference on the
screen. A byte of memory that changes hardly ever but when the game pays is part of the score; the
pixels that change with it, when another value is written there, are where the score is shown. Lives
are found likewise.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import ale_py
import numpy as np
import numpy.typing as npt
from ale_py.roms import get_all_rom_ids

from tril.games.atari.catalogue import CATALOGUE, rom_md5, rom_path
from tril.games.atari.palette import palette_grayscale, palette_rgb

NOOP = ale_py.Action.NOOP
FRAMES_HELD = 8
FRAMES_WATCHED = 48
LONGEST_INTRO = 640
"""Frames after which a key is tried that may leave a title screen."""
LONGEST_ANSWER = 400
TITLE_HOLD = 10
FRAMES_PLAYED = 24_000
LONGEST_GAME = 4_000
NEAR = 3
"""Frames around a reward in which its bytes may change."""
PRECISION = 0.8
"""Least share of a byte's changes that are near a reward."""
RECALL = 0.5
"""Least share of rewards with a change of the byte, for the digits that change the most."""
LARGEST_AREA = 0.05
"""Largest area of a digit, as a share of the screen."""
EDGE = 0.2
"""Share of the screen's height at its top and bottom where a score hides its whole band."""

Box = tuple[int, int, int, int]
"""Left, top, right, bottom in pixels; right and bottom are outside."""
Mask = npt.NDArray[np.bool_]


@dataclass(frozen=True)
class Games:
    """Random games, frame by frame, one after the other.

    Attributes:
        rams: uint8 (frames, 128).
        first: First frames of games, bool (frames,).
        paid: At which frames the game paid, bool (frames,).
        died: At which frames a life was lost, bool (frames,).
        states: States spread over the games.
        moved: Share of frames in which each pixel changed, float (height, width).
    """

    rams: npt.NDArray[np.uint8]
    first: Mask
    paid: Mask
    died: Mask
    states: Sequence[ale_py.ALEState]
    moved: npt.NDArray[np.float64]


class Subject:
    """A console with one game, at its default mode and difficulty."""

    def __init__(self, rom: str) -> None:
        ale_py.ALEInterface.setLoggerMode(ale_py.LoggerMode.Error)
        self.ale = ale_py.ALEInterface()
        self.ale.setFloat("repeat_action_probability", 0.0)
        self.ale.setBool("sound", False)
        self.ale.loadROM(rom_path(rom))
        minimal = self.ale.getMinimalActionSet()
        # A few games list none; it does nothing in them either.
        self.actions = minimal if NOOP in minimal else [NOOP, *minimal]
        self.names = [action.name for action in self.actions]
        self.modes = sorted(int(mode) for mode in self.ale.getAvailableModes())
        self.difficulties = sorted(int(level) for level in self.ale.getAvailableDifficulties())
        self.noop = self.names.index("NOOP")

    def reset(self, intro: dict[str, int] | None = None) -> None:
        """Begin a game, past its intro."""
        self.ale.setMode(self.modes[0])
        self.ale.setDifficulty(self.difficulties[0])
        self.ale.reset_game()
        if intro is not None:
            for frame in range(intro["frames"]):
                self.act(intro["button"] if frame < intro["hold"] else self.noop)

    def act(self, action: int) -> int:
        """Run a frame with this action; return what the game pays."""
        return int(self.ale.act(self.actions[action]))

    def screens_after(self, state: ale_py.ALEState, action: int) -> list[npt.NDArray[np.uint8]]:
        """Return the screens that follow when an action is held for a while and then let go."""
        self.ale.restoreState(state)
        screens = []
        for frame in range(FRAMES_WATCHED):
            self.act(action if frame < FRAMES_HELD else self.noop)
            if frame % 4 >= 2:  # two in a row: some games draw things at every second frame only
                screens.append(self.ale.getScreen())
        return screens

    def is_controlled(self, state: ale_py.ALEState) -> bool:
        """Whether a direction makes a difference on the screen; a button, if there are none."""
        moves = [n for n, name in enumerate(self.names) if name in ("UP", "DOWN", "LEFT", "RIGHT")]
        idle_screens = self.screens_after(state, self.noop)
        return any(
            not np.array_equal(screen, idle_screen)
            for action in moves or [n for n in range(len(self.names)) if n != self.noop]
            for screen, idle_screen in zip(
                self.screens_after(state, action), idle_screens, strict=True
            )
        )


def intro_of(subject: Subject) -> dict[str, int] | None:
    """Find the intro of a game, None if no key makes a difference."""
    titles = [name for name in ("FIRE", "UP", "RIGHT", "DOWN", "LEFT") if name in subject.names]
    for title in (None, *titles):
        hold = 0 if title is None else TITLE_HOLD
        button = subject.noop if title is None else subject.names.index(title)
        subject.reset({"frames": hold, "button": button, "hold": hold})
        for frames in range(hold, LONGEST_INTRO if title is None else LONGEST_ANSWER, FRAMES_HELD):
            state = subject.ale.cloneState()
            if subject.is_controlled(state):
                return {"frames": frames, "button": button, "hold": hold}
            subject.ale.restoreState(state)
            for _ in range(FRAMES_HELD):
                subject.act(subject.noop)
    return None


def random_games(subject: Subject, intro: dict[str, int], seed: int = 0) -> Games:
    """Play games with random actions, each held for a while; every second one has a favourite."""
    rng = np.random.default_rng(seed)
    rams: list[npt.NDArray[np.uint8]] = []
    first: list[bool] = []
    paid: list[bool] = []
    died: list[bool] = []
    states: list[ale_py.ALEState] = []
    height, width = subject.ale.getScreenDims()
    moved = np.zeros((height, width))
    n_seen = 0
    favourite = -1
    while len(rams) < FRAMES_PLAYED:
        favourite = (favourite + 1) % len(subject.names)
        share = 0.0 if favourite == subject.noop else float(rng.choice((0.0, 0.7, 0.95)))
        subject.reset(intro)
        lives, action, frames_left = subject.ale.lives(), 0, 0
        screen = subject.ale.getScreen()
        for frame in range(LONGEST_GAME):
            if frames_left == 0:
                drawn = int(rng.integers(len(subject.names)))
                action = favourite if rng.random() < share else drawn
                frames_left = int(rng.integers(2, 24))
            frames_left -= 1
            paid.append(subject.act(action) != 0)
            rams.append(subject.ale.getRAM())
            first.append(frame == 0)
            died.append(subject.ale.lives() < lives)
            lives = subject.ale.lives()
            if frame % 4 == 0:
                before, screen = screen, subject.ale.getScreen()
                moved += before != screen
                n_seen += 1
            if frame % 97 == 0:
                states.append(subject.ale.cloneState())
            if subject.ale.game_over(with_truncation=False):
                break
    return Games(
        np.array(rams), np.array(first), np.array(paid), np.array(died), states, moved / n_seen
    )


def event_bytes(events: Mask, games: Games) -> dict[int, float]:
    """Return the bytes of memory that change almost only at events, with their recall."""
    changed = games.rams[1:] != games.rams[:-1]
    changed[games.first[1:]] = False
    at = np.flatnonzero(events)
    near_events = np.zeros(len(events), np.bool_)
    for shift in range(-NEAR, NEAR + 1):
        near_events[np.clip(at + shift, 0, len(events) - 1)] = True
    n_changes = changed.sum(0)
    precision = changed[near_events[1:]].sum(0) / np.maximum(n_changes, 1)
    hits = np.zeros(changed.shape[1])
    for frame in at:
        hits += changed[max(0, frame - NEAR - 1) : frame + NEAR].any(0)
    chosen = np.flatnonzero((precision >= PRECISION) & (n_changes > 0))
    return {int(byte): float(hits[byte] / max(len(at), 1)) for byte in chosen}


def pixels_of(subject: Subject, states: Sequence[ale_py.ALEState], byte: int) -> Box | None:
    """Return the pixels that change with a byte of memory, in at least half of the states."""
    picked = [states[n] for n in np.linspace(0, len(states) - 1, 10).astype(int)]
    share = np.mean([_changed_pixels(subject, state, byte) for state in picked], axis=0)
    return _box(share >= 0.5)


def _changed_pixels(subject: Subject, state: ale_py.ALEState, byte: int) -> Mask:
    subject.ale.restoreState(state)
    value = int(subject.ale.getRAM()[byte])
    plain = _two_screens(subject)
    changed = np.zeros(plain[0].shape, np.bool_)
    for changed_value in (value ^ 0x01, value ^ 0x10, value + 1, value - 1, value + 0x11):
        subject.ale.restoreState(state)
        subject.ale.setRAM(byte, changed_value % 256)
        for screen, plain_screen in zip(_two_screens(subject), plain, strict=True):
            changed |= screen != plain_screen
    return changed


def _two_screens(subject: Subject) -> list[npt.NDArray[np.uint8]]:
    subject.act(subject.noop)
    screens = []
    for _ in range(2):
        subject.act(subject.noop)
        screens.append(subject.ale.getScreen())
    return screens


def _box(mask: Mask) -> Box | None:
    rows, columns = np.flatnonzero(mask.any(1)), np.flatnonzero(mask.any(0))
    if len(rows) == 0:
        return None
    return int(columns[0]), int(rows[0]), int(columns[-1]) + 1, int(rows[-1]) + 1


def areas_of(subject: Subject, events: Mask, games: Games) -> list[Box]:
    """Return the areas of the screen that change at events: digits, and those beside them."""
    height, width = games.moved.shape
    boxes: dict[int, Box] = {}
    recalls = event_bytes(events, games)
    for byte in recalls:
        box = pixels_of(subject, games.states, byte)
        if box is not None and _area(box) <= LARGEST_AREA * height * width:
            boxes[byte] = box
    seeds = [box for byte, box in boxes.items() if recalls[byte] >= RECALL]
    if not seeds:
        return []
    beside = [box for box in boxes.values() if any(_same_rows(box, seed) for seed in seeds)]
    return [_band(box, games) for box in _merged(beside)]


def _area(box: Box) -> int:
    left, top, right, bottom = box
    return (right - left) * (bottom - top)


def _same_rows(box: Box, other_box: Box) -> bool:
    overlap = min(box[3], other_box[3]) - max(box[1], other_box[1])
    return 2 * overlap >= min(box[3] - box[1], other_box[3] - other_box[1])


def _merged(boxes: Sequence[Box]) -> list[Box]:
    """Join boxes that share rows."""
    joined: list[Box] = []
    for box in sorted(boxes, key=lambda box: box[1]):
        if joined and _same_rows(joined[-1], box):
            last = joined.pop()
            box = (
                min(last[0], box[0]),
                min(last[1], box[1]),
                max(last[2], box[2]),
                max(last[3], box[3]),
            )
        joined.append(box)
    return joined


def _band(box: Box, games: Games) -> Box:
    """Widen a box to the whole width near an edge of the screen, where nothing else moves.

    Digits that did not change in the random games are hidden with it.
    """
    left, top, right, bottom = box
    height, width = games.moved.shape
    outside = games.moved[top:bottom].copy()
    outside[:, left:right] = 0
    is_at_edge = bottom <= EDGE * height or top >= (1 - EDGE) * height
    if is_at_edge and (outside > 0.02).mean() < 0.02:
        return 0, max(0, top - 1), width, min(height, bottom + 1)
    return max(0, left - 1), max(0, top - 1), min(width, right + 1), min(height, bottom + 1)


def entry_of(rom: str) -> dict[str, Any]:
    """Return a game's entry of the catalogue."""
    subject = Subject(rom)
    height, width = subject.ale.getScreenDims()
    intro = intro_of(subject)
    games = random_games(subject, intro or {"frames": 0, "button": subject.noop, "hold": 0})
    subject.ale.restoreState(games.states[len(games.states) // 2])
    subject.act(subject.noop)
    colours = palette_rgb()[subject.ale.getScreen()]
    is_ntsc = np.array_equal(colours, subject.ale.getScreenRGB())
    score = areas_of(subject, games.paid, games)
    lives = areas_of(subject, games.died, games)
    lives = [box for box in lives if not any(_inside(box, score_box) for score_box in score)]
    subject.reset(intro)
    return {
        "md5": rom_md5(rom),
        "screen": [height, width],
        "background": background_of(subject, pal=not is_ntsc),
        "pal": not is_ntsc,
        "actions": subject.names,
        "modes": subject.modes,
        "difficulties": subject.difficulties,
        "lives": subject.ale.lives(),
        "intro": intro,
        "n_paid": int(games.paid.sum()),
        "score": score,
        "life": lives,
    }


def background_of(subject: Subject, *, pal: bool) -> int:
    """Return the gray that most of the screen shows."""
    grays = palette_grayscale(pal)[subject.ale.getScreen()]
    return int(np.bincount(grays.reshape(-1)).argmax())


def _inside(inner: Box, outer: Box) -> bool:
    return (
        outer[0] <= inner[0]
        and outer[1] <= inner[1]
        and inner[2] <= outer[2]
        and inner[3] <= outer[3]
    )


def main(roms: Sequence[str]) -> None:
    """Print entries, or write the whole catalogue."""
    if roms:
        for rom in roms:
            sys.stdout.write(json.dumps({rom: entry_of(rom)}) + "\n")
        return
    lines = [f"{json.dumps(rom)}: {json.dumps(entry_of(rom))}" for rom in sorted(get_all_rom_ids())]
    CATALOGUE.write_text("{\n" + ",\n".join(lines) + "\n}\n")


if __name__ == "__main__":
    main(sys.argv[1:])
