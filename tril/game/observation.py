"""Screens to observation: the only preprocessing.

An observation is the last four steps' screens, oldest first. The screen of a step is the maximum
of the step's last two frames in grayscale (bombs are drawn on even frames only), reduced to 84x84
by cv2.INTER_AREA, with the score's rows zeroed. Values are uint8 from 0 to 255.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from tril.game import space_invaders as game
from tril.game.console import Console, Screen
from tril.game.palette import palette_grayscale

SIZE = 84
STACK = 4
OBSERVATION_SHAPE = (STACK, SIZE, SIZE)

Observation = npt.NDArray[np.uint8]
"""uint8 (4, 84, 84), oldest screen first, 0 to 255."""

Observations = npt.NDArray[np.uint8]
"""uint8 (N, 4, 84, 84): some of them, in any order in memory."""

# A tile of the screen, 5 rows x 40 columns, makes a tile of the observation, 2 rows x 21 columns,
# whatever is around it, because the borders coincide (210 / 84 = 5 / 2 and 160 / 84 = 40 / 21). So
# tiles can be reduced apart, and those that did not change need not be reduced again. There are
# none where the score is.
_TILE_ROWS, _TILE_COLUMNS = 5, 40
_REDUCED_ROWS, _REDUCED_COLUMNS = 2, 21
_SCORE_ROWS = game.SCORE_ROWS // _REDUCED_ROWS * _TILE_ROWS
# Frames are compared and gathered eight pixels at a time.
_WORD = np.dtype(np.uint64)
_SCORE_WORDS = _SCORE_ROWS * game.SCREEN_SHAPE[1] // _WORD.itemsize

Indices = npt.NDArray[np.intp]


def check_observations(observations: Observations) -> None:
    """Refuse what is no batch of observations.

    Raises:
        ValueError: The observations have another shape or dtype.
    """
    if observations.shape[1:] != OBSERVATION_SHAPE or observations.dtype != np.uint8:
        raise ValueError(
            f"Expected observations uint8 (N, {', '.join(map(str, OBSERVATION_SHAPE))}), got"
            f" {observations.dtype} {observations.shape}."
        )


def _tiles_of(shape: tuple[int, int], tile_shape: tuple[int, int], first_row: int) -> Indices:
    """Return the flat indices of an array's items below first_row by tile, (tiles, items)."""
    rows, columns = tile_shape
    indices = np.arange(shape[0] * shape[1]).reshape(shape)[first_row:]
    tiles = indices.reshape(-1, rows, shape[1] // columns, columns).transpose(0, 2, 1, 3)
    return tiles.reshape(-1, rows * columns)


_TILE_WORDS = _tiles_of(
    (game.SCREEN_SHAPE[0], game.SCREEN_SHAPE[1] // _WORD.itemsize),
    (_TILE_ROWS, _TILE_COLUMNS // _WORD.itemsize),
    _SCORE_ROWS,
)
_TILE_PIXELS = _tiles_of((SIZE, SIZE), (_REDUCED_ROWS, _REDUCED_COLUMNS), game.SCORE_ROWS)
_TILES = len(_TILE_WORDS)
_TILE_OF_WORD = np.empty(_TILE_WORDS.size, np.intp)
_TILE_OF_WORD[_TILE_WORDS - _SCORE_WORDS] = np.arange(_TILES)[:, None]


_FRAME_WORDS = game.SCREEN_SHAPE[0] * game.SCREEN_SHAPE[1] // _WORD.itemsize
_BOTH_FRAMES_WORDS = np.concatenate((_TILE_WORDS, _TILE_WORDS + _FRAME_WORDS), axis=1)

_STACK_PIXELS = STACK * SIZE * SIZE
_NEWEST = (STACK - 1) * SIZE * SIZE


def preprocess(first: Screen, second: Screen) -> npt.NDArray[np.uint8]:
    """Return the screen of a step, uint8 (84, 84), from its last two frames.

    Args:
        first: the frame before the last, uint8 (210, 160) grayscale.
        second: the last frame, uint8 (210, 160) grayscale.
    """
    reduced = np.zeros(SIZE * SIZE, np.uint8)
    frames = np.stack((first, second)).reshape(-1).view(_WORD)
    reduced[_TILE_PIXELS] = _reduce(frames.take(_BOTH_FRAMES_WORDS).view(np.uint8))
    return reduced.reshape(SIZE, SIZE)


def _reduce(tiles: npt.NDArray[np.uint8]) -> npt.NDArray[np.uint8]:
    """Reduce tiles in grayscale to tiles of an observation.

    Args:
        tiles: uint8 (tiles, 400): the 5 x 40 pixels of the first frame, then of the second.

    Returns:
        uint8 (tiles, 42).
    """
    count, half = len(tiles), tiles.shape[1] // 2
    brightest = np.maximum(tiles[:, :half], tiles[:, half:]).reshape(-1, _TILE_COLUMNS)
    size = (_REDUCED_COLUMNS, count * _REDUCED_ROWS)
    reduced = cv2.resize(brightest, size, interpolation=cv2.INTER_AREA)
    return np.asarray(reduced.reshape(count, -1), np.uint8)


@dataclass(frozen=True)
class AgentViewState:
    """A saved AgentView.

    Attributes:
        observation: 4 x 84 x 84 bytes.
        first: palette values of the step's third frame, 210 x 160 bytes, when that frame was the
            last one watched; None otherwise.
    """

    observation: bytes
    first: bytes | None


class AgentViews:
    """What agents see of several games, kept up to date frame by frame.

    Only the tiles of a screen that differ from the step before are reduced again, which gives what
    `preprocess` gives in a third of the time. It happens when an observation is asked for, for all
    games at once: who steps several games gains by stepping them all first.

    Attributes:
        stacks: the observations as of the last completion, uint8 (n, 4, 84, 84).
        frames: the last two frames in palette values, uint8 (n, 2, 210, 160).
    """

    def __init__(self, n_games: int, stacks: Observation | None = None) -> None:
        """Make views that see nothing yet: call begin on each.

        Args:
            n_games: how many.
            stacks: memory for the observations, uint8 (n, 4, 84, 84), if it is not to be its own.
        """
        shape = (n_games, *OBSERVATION_SHAPE)
        self.stacks = np.zeros(shape, np.uint8) if stacks is None else stacks
        self._stacks_before = self.stacks
        self.frames = np.zeros((n_games, 2, *game.SCREEN_SHAPE), np.uint8)
        self._words = self.frames.reshape(-1).view(_WORD)
        # Of both frames what is below the score; of the step before, its second frame and where
        # its two frames differed.
        below = self._words.reshape(n_games, 2, -1)[:, :, _SCORE_WORDS:]
        self._first, self._second = below[:, 0], below[:, 1]
        self._second_before = np.zeros_like(self._second)
        self._differed_before = np.zeros(self._second.shape, np.bool_)
        games = np.arange(n_games)[:, None, None]
        self._tile_of_word = (_TILE_OF_WORD + games[:, 0] * _TILES).reshape(-1)
        tile_words = _BOTH_FRAMES_WORDS + games * 2 * _FRAME_WORDS
        self._tile_words = tile_words.reshape(-1, _BOTH_FRAMES_WORDS.shape[1])
        tile_pixels = _TILE_PIXELS + games * _STACK_PIXELS + _NEWEST
        self._tile_pixels = tile_pixels.reshape(-1, _TILE_PIXELS.shape[1])
        self._grays = palette_grayscale()
        # Which games have a whole step to be pushed, of which the step before is not known, and
        # which are at their start.
        self._to_push = np.zeros(n_games, np.bool_)
        self._is_complete = True
        self._unknown = np.ones(n_games, np.bool_)
        self._at_start = np.zeros(n_games, np.bool_)
        self._any_unknown = True

    def __iter__(self) -> Iterator["AgentView"]:
        """Return the views of the games one by one."""
        return (AgentView(self, index) for index in range(len(self.stacks)))

    def push(self, index: int) -> None:
        """Note that both frames of a game are the last ones of a step."""
        self._to_push[index] = True
        self._is_complete = False

    def begin(self, index: int) -> None:
        """Note that both frames of a game are its start's."""
        self.forget(index)
        self._at_start[index] = True
        self.push(index)

    def forget(self, index: int) -> None:
        """Note that what was seen of a game says nothing about what comes."""
        self._to_push[index] = self._at_start[index] = False
        self._unknown[index] = self._any_unknown = True

    def turn_to(self, stacks: Observation) -> None:
        """Write the observations into other memory from now on; the old keeps those of now."""
        self.complete()
        self.stacks = stacks
        self._is_complete = False

    def complete_of(self, index: int) -> None:
        """Complete at least this game's step, if it is whole and has not been pushed."""
        if self._to_push[index]:
            self.complete()

    def complete(self) -> None:
        """Push the screens of all whole steps that have not been pushed onto their stacks."""
        if self._is_complete:
            return
        # No indices where none are needed: slices make views instead of copies.
        pushed = slice(None) if self._to_push.all() else self._to_push.nonzero()[0]
        stacks = self._roll(pushed)
        tiles = self._changed_tiles(pushed)
        if len(tiles):
            changed = self._words.take(self._tile_words.take(tiles, axis=0))
            grays = cv2.LUT(changed.view(np.uint8), self._grays)
            pixels = self._tile_pixels.take(tiles, axis=0)
            stacks.reshape(-1)[pixels] = _reduce(np.asarray(grays, np.uint8))
        if self._any_unknown:
            starts = self._at_start
            stacks[starts, :-1] = stacks[starts, -1:]
            starts[:] = False
            self._unknown[pushed] = False
            self._any_unknown = bool(self._unknown.any())
        self._to_push[:] = False
        self._is_complete = True

    def _roll(self, pushed: slice | Indices) -> Observation:
        """Make room for the newest screens; what stands there is the screen before."""
        stacks, before = self.stacks, self._stacks_before
        self._stacks_before = stacks
        if before is not stacks and isinstance(pushed, slice):
            stacks[:, :-1] = before[:, 1:]
            stacks[:, -1] = before[:, -1]
            return stacks
        if before is not stacks:
            stacks[:] = before
        stacks[pushed, :-1] = stacks[pushed, 1:]
        return stacks

    def _changed_tiles(self, pushed: slice | Indices) -> Indices:
        """Return the indices of the tiles to reduce, _TILES for each game.

        A tile has not changed where the second frame is that of the step before and the first
        frame equals the second, in this step as in the one before.
        """
        second = self._second[pushed]
        differ = self._first[pushed] != second
        unequal = second != self._second_before[pushed]
        unequal |= differ
        unequal |= self._differed_before[pushed]
        self._second_before[pushed] = second
        self._differed_before[pushed] = differ
        changed = np.zeros((len(second), _TILES), np.bool_)
        changed.reshape(-1)[self._tile_of_word.take(unequal.reshape(-1).nonzero()[0])] = True
        if self._any_unknown:
            changed[self._unknown[pushed]] = True
        games, tiles = changed.nonzero()
        if not isinstance(pushed, slice):
            games = pushed[games]
        return np.asarray(games * _TILES + tiles, np.intp)


class AgentView:
    """What an agent sees of a game, kept up to date frame by frame."""

    def __init__(self, views: AgentViews | None = None, index: int = 0) -> None:
        """Make a view that sees nothing yet: call begin.

        Args:
            views: the views it is one of, if it is not alone.
            index: which one.
        """
        self._views = AgentViews(1) if views is None else views
        self._index = index
        self._first, self._second = self._views.frames[index]
        self._has_first = False

    @property
    def _stack(self) -> Observation:
        self._views.complete()
        return np.asarray(self._views.stacks[self._index], np.uint8)

    def begin(self, console: Console) -> None:
        """Begin a game: the stack holds the start's screen four times."""
        console.screen_palette(self._first)
        self._second[:] = self._first
        self._has_first = False
        self._views.begin(self._index)

    def watch(self, console: Console, frame: int) -> None:
        """Look at the console after a frame; call it after every frame.

        Args:
            console: the console that ran the frame.
            frame: how many frames have been executed since the start, at least 1.
        """
        frame_of_step = frame % game.FRAMES_PER_STEP
        if frame_of_step == game.FRAMES_PER_STEP - 1:
            self._views.complete_of(self._index)
            console.screen_palette(self._first)
            self._has_first = True
        elif frame_of_step == 0:
            console.screen_palette(self._second)
            self._has_first = False
            self._views.push(self._index)

    def finish_step(self, console: Console, frame: int) -> None:
        """Complete the step in which an episode ended, so that its end can be seen.

        The rest of the step runs on the console with no key held. It is no part of the episode
        and is not recorded. Nothing happens where the episode ended with a whole step.

        Args:
            console: the console; it is ahead of the episode afterwards.
            frame: the episode's last frame.
        """
        while frame % game.FRAMES_PER_STEP:
            console.act(game.Action.NOOP)
            frame += 1
            self.watch(console, frame)

    @property
    def observation(self) -> Observation:
        """The observation as of the last whole step, uint8 (4, 84, 84), a fresh array."""
        return self._stack.copy()

    def observe(self, out: Observation) -> None:
        """Write the observation into out, uint8 (4, 84, 84)."""
        np.copyto(out, self._stack)

    def save(self) -> AgentViewState:
        """Return the state of the view."""
        first = self._first.tobytes() if self._has_first else None
        return AgentViewState(self._stack.tobytes(), first)

    def restore(self, state: AgentViewState) -> None:
        """Take up a saved state."""
        self._stack[:] = np.frombuffer(state.observation, np.uint8).reshape(OBSERVATION_SHAPE)
        self._has_first = state.first is not None
        if state.first is not None:
            self._first[:] = np.frombuffer(state.first, np.uint8).reshape(game.SCREEN_SHAPE)
        self._views.forget(self._index)
