"""Observations from screens: the only preprocessing.

An observation stacks the screens of the last four steps, oldest first. The screen of a step is the
maximum of its last two frames in grayscale (bombs are drawn on even frames only), resized to 84x84
by cv2.INTER_AREA, with the score's rows zeroed. Values are uint8 from 0 to 255.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from tril.games.atari.console import Console, Screen
from tril.games.atari.palette import palette_grayscale
from tril.games.space_invaders import memory as game

SIZE = 84
STACK = 4
OBSERVATION_SHAPE = (STACK, SIZE, SIZE)

Observation = npt.NDArray[np.uint8]
"""uint8 (4, 84, 84), oldest screen first, 0 to 255."""

Observations = npt.NDArray[np.uint8]
"""uint8 (N, 4, 84, 84), in any memory order."""

# A tile of the screen, 5 rows x 40 columns, maps to a tile of the observation, 2 rows x 21 columns,
# since their borders coincide (210 / 84 = 5 / 2 and 160 / 84 = 40 / 21). Tiles can therefore be
# resized independently, and only those that changed. The score's rows have none.
_TILE_ROWS, _TILE_COLUMNS = 5, 40
_REDUCED_ROWS, _REDUCED_COLUMNS = 2, 21
_SCORE_ROWS = game.SCORE_ROWS // _REDUCED_ROWS * _TILE_ROWS
# Frames are compared and gathered eight pixels at a time.
_WORD = np.dtype(np.uint64)
_SCORE_WORDS = _SCORE_ROWS * game.SCREEN_SHAPE[1] // _WORD.itemsize

Indices = npt.NDArray[np.intp]


def check_observations(observations: Observations) -> None:
    """Check that an array is a batch of observations.

    Raises:
        ValueError: the shape or dtype is wrong.
    """
    if observations.shape[1:] != OBSERVATION_SHAPE or observations.dtype != np.uint8:
        raise ValueError(
            f"Expected observations uint8 (N, {', '.join(map(str, OBSERVATION_SHAPE))}), got"
            f" {observations.dtype} {observations.shape}."
        )


def _tiles_of(shape: tuple[int, int], tile_shape: tuple[int, int], first_row: int) -> Indices:
    """Return flat indices of an array's items from first_row on by tile, (tiles, items)."""
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
        first: the second-to-last frame, uint8 (210, 160) grayscale.
        second: the last frame, uint8 (210, 160) grayscale.
    """
    reduced = np.zeros(SIZE * SIZE, np.uint8)
    frames = np.stack((first, second)).reshape(-1).view(_WORD)
    reduced[_TILE_PIXELS] = _reduce(frames.take(_BOTH_FRAMES_WORDS).view(np.uint8))
    return reduced.reshape(SIZE, SIZE)


def _reduce(tiles: npt.NDArray[np.uint8]) -> npt.NDArray[np.uint8]:
    """Resize grayscale tiles to tiles of an observation.

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
        first: palette values of the step's third frame, 210 x 160 bytes, if that was the last
            frame, else None.
    """

    observation: bytes
    first: bytes | None


class AgentViews:
    """Observations of several games, updated frame by frame.

    Only tiles that differ from the previous step are resized, which equals `preprocess` in a third
    of the time. This happens lazily and for all games at once, so step all games before reading an
    observation.

    Attributes:
        stacks: the observations as of the last flush, uint8 (n, 4, 84, 84).
        frames: the last two frames in palette values, uint8 (n, 2, 210, 160).
    """

    def __init__(self, n_games: int, stacks: Observation | None = None) -> None:
        """Allocate the views; call reset on each.

        Args:
            n_games: number of games.
            stacks: memory for the observations, uint8 (n, 4, 84, 84); None allocates it.
        """
        shape = (n_games, *OBSERVATION_SHAPE)
        self.stacks = np.zeros(shape, np.uint8) if stacks is None else stacks
        self._stacks_before = self.stacks
        self.frames = np.zeros((n_games, 2, *game.SCREEN_SHAPE), np.uint8)
        self._words = self.frames.reshape(-1).view(_WORD)
        # Both frames below the score; of the previous step, its second frame and where its two
        # frames differed.
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
        # Which games have a complete step to push, whose previous step is unknown, and which are
        # at their start.
        self._to_push = np.zeros(n_games, np.bool_)
        self._is_complete = True
        self._unknown = np.ones(n_games, np.bool_)
        self._at_start = np.zeros(n_games, np.bool_)
        self._any_unknown = True

    def __iter__(self) -> Iterator["AgentView"]:
        """Yield the views of the single games."""
        return (AgentView(self, index) for index in range(len(self.stacks)))

    def push(self, index: int) -> None:
        """Mark a game's frames as the last two of a step."""
        self._to_push[index] = True
        self._is_complete = False

    def reset(self, index: int) -> None:
        """Mark a game's frames as those of its start."""
        self.invalidate(index)
        self._at_start[index] = True
        self.push(index)

    def invalidate(self, index: int) -> None:
        """Discard the previous step of a game."""
        self._to_push[index] = self._at_start[index] = False
        self._unknown[index] = self._any_unknown = True

    def set_output(self, stacks: Observation) -> None:
        """Switch to other memory for the observations; the old keeps the current ones."""
        self.flush()
        self.stacks = stacks
        self._is_complete = False

    def flush_game(self, index: int) -> None:
        """Flush if this game has a pending step."""
        if self._to_push[index]:
            self.flush()

    def flush(self) -> None:
        """Push the screens of all pending steps onto their stacks."""
        if self._is_complete:
            return
        # A slice if possible: it makes views instead of copies.
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
        """Shift the stacks; the newest screen starts as a copy of the one before."""
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
        """Return the indices of the tiles to resize, _TILES per game.

        A tile is unchanged if the second frame equals that of the previous step and, in both steps,
        the first frame equals the second.
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
    """The observation of one game, updated frame by frame."""

    def __init__(self, views: AgentViews | None = None, index: int = 0) -> None:
        """Make a view; call reset.

        Args:
            views: the views that it belongs to; None makes its own.
            index: its index among them.
        """
        self._views = AgentViews(1) if views is None else views
        self._index = index
        self._first, self._second = self._views.frames[index]
        self._has_first = False

    @property
    def _stack(self) -> Observation:
        self._views.flush()
        return np.asarray(self._views.stacks[self._index], np.uint8)

    def reset(self, console: Console) -> None:
        """Begin a game: fill the stack with the start's screen."""
        console.screen_palette(self._first)
        self._second[:] = self._first
        self._has_first = False
        self._views.reset(self._index)

    def update(self, console: Console, frame: int) -> None:
        """Read the screen if the frame matters; call it after every frame.

        Args:
            console: the console that ran the frame.
            frame: number of frames executed since the start, at least 1.
        """
        frame_of_step = frame % game.FRAMES_PER_STEP
        if frame_of_step == game.FRAMES_PER_STEP - 1:
            self._views.flush_game(self._index)
            console.screen_palette(self._first)
            self._has_first = True
        elif frame_of_step == 0:
            console.screen_palette(self._second)
            self._has_first = False
            self._views.push(self._index)

    def finish_step(self, console: Console, frame: int) -> None:
        """Complete the step in which an episode ended, so that the observation shows its end.

        The rest of the step runs on the console with no key held and is not part of the episode.

        Args:
            console: the console, ahead of the episode afterwards.
            frame: the episode's last frame.
        """
        while frame % game.FRAMES_PER_STEP:
            console.act(game.Action.NOOP)
            frame += 1
            self.update(console, frame)

    @property
    def observation(self) -> Observation:
        """The observation as of the last complete step, uint8 (4, 84, 84), a fresh array."""
        return self._stack.copy()

    def observe(self, out: Observation) -> None:
        """Write the observation into out, uint8 (4, 84, 84)."""
        np.copyto(out, self._stack)

    def save(self) -> AgentViewState:
        """Return the state of the view."""
        first = self._first.tobytes() if self._has_first else None
        return AgentViewState(self._stack.tobytes(), first)

    def restore(self, state: AgentViewState) -> None:
        """Restore a saved state."""
        self._stack[:] = np.frombuffer(state.observation, np.uint8).reshape(OBSERVATION_SHAPE)
        self._has_first = state.first is not None
        if state.first is not None:
            self._first[:] = np.frombuffer(state.first, np.uint8).reshape(game.SCREEN_SHAPE)
        self._views.invalidate(self._index)
