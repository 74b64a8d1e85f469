"""Facts about Space Invaders: addresses, geometry, times.

The addresses, positions and times were measured on the emulator (ALE 0.12.1) and are verified by
tests. Rows count from 0 at the bottom and columns from 0 at the left in all code; the page shows
them from 1.
"""

from enum import IntEnum

GAME = "space_invaders"
"""Name of the game in recordings, and of its ROM in ale_py."""

SCREEN_SHAPE = (210, 160)
"""Height and width of the screen in pixels."""

FRAME_RATE_HZ = 60
FRAMES_PER_STEP = 4
MAX_STEPS = 300
MAX_FRAMES = MAX_STEPS * FRAMES_PER_STEP

INTRO_FRAMES = 128
"""Frames after a reset in which nothing moves and keys have no effect."""

MODES = (0,)
"""Modes in which the detection of aliens is tested; the cartridge has 16."""

DIFFICULTIES = (0, 1)
"""1 doubles the width of the player's cannon."""

ROWS = 6
COLUMNS = 6
POINTS = (5, 10, 15, 20, 25, 30)
"""Points for an alien, by row from the bottom."""

BACKGROUND = 0
"""Value of the black background, as palette value and in grayscale."""

SCORE_PX = 25
"""Height of the area at the top that learning does not see, 10 rows of the observation. It shows
the score, the bonus ship and the end of a missile's flight; the topmost aliens start below it."""


class Action(IntEnum):
    """The game's minimal actions; the value is the byte in a recording and the policy's output."""

    NOOP = 0
    FIRE = 1
    RIGHT = 2
    LEFT = 3
    RIGHTFIRE = 4
    LEFTFIRE = 5


RAM_SIZE = 128
RAM_ALIEN_Y = 16
RAM_ALIENS_LEFT = 17
RAM_ALIEN_ROWS = 18
"""First of ROWS bytes, bottom row first; bit 0 is the leftmost column that still has aliens."""
RAM_LANDING = 24
RAM_LANDED_BIT = 0x80
"""Set in RAM_LANDING in the frame in which the aliens reach the ground."""
RAM_ALIEN_X = 26
RAM_PLAYER_X = 28
RAM_BONUS_SHIP_X = 30
RAM_PHASE = 42
RAM_LIVES = 73
RAM_BOMBS = ((81, 83), (82, 84))
"""Addresses of (y, x) of the two bombs; a y of 246 is none."""
RAM_MISSILE_Y = 85
RAM_MISSILE_X = 87
RAM_SCORE_HIGH = 102
RAM_SCORE_LOW = 104
"""The score as four decimal digits in BCD: two in each byte."""

PHASE_PLAY = 0
PHASE_INTRO = 1
PHASE_HIT = 4
"""The player has been hit, from the frame of the hit on."""
PHASE_CLEARED = 8

NO_MISSILE = 246
"""RAM_MISSILE_Y when no missile of the player is in the air."""

RAM_NAMES = {
    RAM_ALIEN_Y: "aliens, y",
    RAM_ALIENS_LEFT: "aliens left",
    **{RAM_ALIEN_ROWS + row: f"aliens in row {row + 1}, as bits" for row in range(ROWS)},
    RAM_LANDING: "landed (bit 7)",
    RAM_ALIEN_X: "aliens, x",
    RAM_PLAYER_X: "cannon, x",
    RAM_BONUS_SHIP_X: "bonus ship, x",
    RAM_PHASE: "phase",
    RAM_LIVES: "lives",
    **{y: f"bomb {n}, y" for n, (y, _) in enumerate(RAM_BOMBS, start=1)},
    **{x: f"bomb {n}, x" for n, (_, x) in enumerate(RAM_BOMBS, start=1)},
    RAM_MISSILE_Y: "missile, y",
    RAM_MISSILE_X: "missile, x",
    RAM_SCORE_HIGH: "score, hundreds (BCD)",
    RAM_SCORE_LOW: "score, units (BCD)",
}
"""Display names of the addresses above; rows and bombs count from 1."""

# Geometry in pixels.
COLUMN_WIDTH = 16
ROW_HEIGHT = 18
ALIEN_CENTRE = 4
"""Column c, counted from the leftmost that still has aliens, is centred at alien x + 16 c + 4."""
ALIEN_SIZE = (10, 8)
"""Height and width of an alien on the screen."""
ALIEN_LEFT = -1
"""From alien x to the left edge of the leftmost column that still has aliens."""
TOP_ROW = 31
ALIEN_Y_PX = 2
"""The top row begins at 31 + 2 times alien y; alien y counts from 0."""
MISSILE_OFFSET = 5
"""A missile leaves at about player x + 5."""
PLAYER_LEFT_WALL = 35
"""Player x at the left wall, where the player also starts."""
PLAYER_RIGHT_WALL = 117
PLAYER_SPEED_PX = 0.5
"""Pixels that the player moves in a frame."""
CANNON_TOP = 185
CANNON_HEIGHT = 10
CANNON_EDGES = ((-1, 7), (0, 14))
"""By difficulty: from player x to the cannon's left edge, and its width. A screen shows it where
player x was a frame before."""
SHIELDS = ((42, 50), (74, 82), (106, 114))
"""First and last x of the three shields; they stop missiles until they are worn through."""
