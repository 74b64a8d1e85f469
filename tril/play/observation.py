"""Observations from screens: the only preprocessing.

An observation stacks the screens of the last four steps, oldest first. The screen of a step is the
maximum of its last two frames in grayscale (bombs are drawn on even frames only), resized to 84x84
by cv2.INTER_AREA, with the score's rows zeroed. Values are uint8 from 0 to 255.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol

import cv2
import numpy as np
import numpy.typing as npt

from tril.games.base import Console, Game, Screen, ScreenSpec

SIZE = 84
STACK = 4
OBSERVATION_SHAPE = (STACK, SIZE, SIZE)

Observation = npt.NDArray[np.uint8]
"""uint8 (4, 84, 84), oldest screen first, 0 to 255."""

Observations = npt.NDArray[np.uint8]
"""uint8 (N, 4, 84, 84), in any memory order."""

# A tile of a screen of 210 x 160, 5 rows x 40 columns, maps to a tile of the observation, 2 rows x
# 21 columns, since their borders coincide (210 / 84 = 5 / 2 and 160 / 84 = 40 / 21). Tiles can
# therefore be resized independently, and only those that changed.
_TILED_SHAPE = (210, 160)
_TILE_ROWS, _TILE_COLUMNS = 5, 40
_REDUCED_ROWS, _REDUCED_COLUMNS = 2, 21
# Frames are compared and gathered eight pixels at a time.
_WORD = np.dtype(np.uint64)

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


def _tiles_of(shape: tuple[int, int], tile_shape: tuple[int, int]) -> Indices:
    """Return flat indices of an array's items by tile, (tiles, items)."""
    rows, columns = tile_shape
    indices = np.arange(shape[0] * shape[1]).reshape(shape)
    tiles = indices.reshape(-1, rows, shape[1] // columns, columns).transpose(0, 2, 1, 3)
    return tiles.reshape(-1, rows * columns)


_TILE_WORDS = _tiles_of(
    (_TILED_SHAPE[0], _TILED_SHAPE[1] // _WORD.itemsize),
    (_TILE_ROWS, _TILE_COLUMNS // _WORD.itemsize),
)
_TILE_PIXELS = _tiles_of((SIZE, SIZE), (_REDUCED_ROWS, _REDUCED_COLUMNS))
_FRAME_WORDS = _TILED_SHAPE[0] * _TILED_SHAPE[1] // _WORD.itemsize

_STACK_PIXELS = STACK * SIZE * SIZE
_NEWEST = (STACK - 1) * SIZE * SIZE


def visible_pixels(screen: ScreenSpec) -> npt.NDArray[np.bool_]:
    """Return the pixels of an observation that learning sees, bool (84, 84).

    A pixel is hidden if any part of its area on the screen is.
    """
    visible = np.ones((SIZE, SIZE), np.bool_)
    for area in screen.hidden:
        rows = slice(area.top * SIZE // screen.height, -(-area.bottom * SIZE // screen.height))
        columns = slice(area.left * SIZE // screen.width, -(-area.right * SIZE // screen.width))
        visible[rows, columns] = False
    return visible


def _gray(frame: Screen, screen: ScreenSpec) -> npt.NDArray[np.uint8]:
    if screen.grayscale is None:
        return np.asarray(cv2.cvtColor(frame, cv2.COLOR_RGB2GRAY), np.uint8)
    return np.asarray(cv2.LUT(frame, screen.grayscale), np.uint8)


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
        first: the step's second-to-last frame, if that was the last frame, else None.
    """

    observation: bytes
    first: bytes | None


class AgentViews(Protocol):
    """Observations of several games, updated frame by frame.

    They are made lazily and for all games at once, so step all games before reading one.

    Attributes:
        stacks: the observations as of the last flush, uint8 (n, 4, 84, 84).
        frames: the last two frames, uint8 (n, 2, ...) as the console yields them.
        game: the game that they are of.
    """

    stacks: Observation
    frames: npt.NDArray[np.uint8]
    game: Game

    def __iter__(self) -> Iterator["AgentView"]:
        """Yield the views of the single games."""

    def push(self, index: int) -> None:
        """Mark a game's frames as the last two of a step."""

    def reset(self, index: int) -> None:
        """Mark a game's frames as those of its start."""

    def invalidate(self, index: int) -> None:
        """Discard the previous step of a game."""

    def set_output(self, stacks: Observation) -> None:
        """Switch to other memory for the observations; the old keeps the current ones."""

    def flush_game(self, index: int) -> None:
        """Flush if this game has a pending step."""

    def flush(self) -> None:
        """Push the screens of all pending steps onto their stacks."""


def agent_views(game: Game, n_games: int = 1, stacks: Observation | None = None) -> AgentViews:
    """Return the views of n games; call reset on each.

    Args:
        game: The game.
        n_games: Number of games.
        stacks: Memory for the observations, uint8 (n, 4, 84, 84); None allocates it.
    """
    if stacks is None:
        stacks = np.zeros((n_games, *OBSERVATION_SHAPE), np.uint8)
    tiled = game.screen.shape == _TILED_SHAPE and game.clock.frames_per_step > 1
    return _TiledViews(game, stacks) if tiled else _WholeViews(game, stacks)


class _WholeViews:
    """Views of games whose screens do not fall into tiles: every step's screen is resized whole."""

    def __init__(self, game: Game, stacks: Observation) -> None:
        self.game = game
        self.stacks = stacks
        self.frames = np.zeros((len(stacks), 2, *game.screen.shape), np.uint8)
        self._visible = visible_pixels(game.screen)
        self._pending = np.zeros(len(stacks), np.bool_)
        self._at_start = np.zeros(len(stacks), np.bool_)

    def __iter__(self) -> Iterator["AgentView"]:
        return (AgentView(self.game, self, index) for index in range(len(self.stacks)))

    def push(self, index: int) -> None:
        self._pending[index] = True

    def reset(self, index: int) -> None:
        self._pending[index] = self._at_start[index] = True

    def invalidate(self, index: int) -> None:
        self._pending[index] = self._at_start[index] = False

    def set_output(self, stacks: Observation) -> None:
        self.flush()
        stacks[:] = self.stacks
        self.stacks = stacks

    def flush_game(self, index: int) -> None:
        if self._pending[index]:
            self.flush()

    def flush(self) -> None:
        for index in self._pending.nonzero()[0]:
            first, second = self.frames[index]
            brightest = np.maximum(_gray(first, self.game.screen), _gray(second, self.game.screen))
            stack = self.stacks[index]
            stack[:-1] = stack[1:]
            reduced = cv2.resize(brightest, (SIZE, SIZE), interpolation=cv2.INTER_AREA)
            np.multiply(reduced, self._visible, out=stack[-1])
            if self._at_start[index]:
                stack[:-1] = stack[-1]
        self._pending[:] = self._at_start[:] = False


class _TiledViews:
    """Views of games whose screens fall into tiles, of which only those that changed are resized.

    A tile is compared with the previous step's. This equals resizing the whole in a third of the
    time.
    """

    def __init__(self, game: Game, stacks: Observation) -> None:
        if game.screen.grayscale is None:
            raise ValueError("Expected a screen of palette values, got RGB.")
        n_games = len(stacks)
        self.game = game
        self.stacks = stacks
        self._stacks_before = self.stacks
        self.frames = np.zeros((n_games, 2, *_TILED_SHAPE), np.uint8)
        self._words = self.frames.reshape(-1).view(_WORD)
        # Rows of tiles at the top that are hidden, the score of most games, have no tiles at all.
        visible = visible_pixels(game.screen)
        shown_rows = np.flatnonzero(visible.reshape(-1, _REDUCED_ROWS * SIZE).max(1))
        hidden_rows = int(shown_rows[0]) if len(shown_rows) else SIZE // _REDUCED_ROWS - 1
        tiles = slice(hidden_rows * (SIZE // _REDUCED_COLUMNS), None)
        tile_words, pixels = _TILE_WORDS[tiles], _TILE_PIXELS[tiles]
        self._n_tiles = len(tile_words)
        skipped = hidden_rows * _TILE_ROWS * _TILED_SHAPE[1] // _WORD.itemsize
        tile_of_word = np.empty(tile_words.size, np.intp)
        tile_of_word[tile_words - skipped] = np.arange(self._n_tiles)[:, None]
        # What is hidden elsewhere is zeroed after resizing.
        masks = visible.reshape(-1)[pixels].astype(np.uint8)
        self._masks = None if masks.all() else masks
        # Both frames below the hidden rows; of the previous step, its second frame and where its
        # two frames differed.
        below = self._words.reshape(n_games, 2, -1)[:, :, skipped:]
        self._first, self._second = below[:, 0], below[:, 1]
        self._second_before = np.zeros_like(self._second)
        self._differed_before = np.zeros(self._second.shape, np.bool_)
        games = np.arange(n_games)[:, None, None]
        self._tile_of_word = (tile_of_word + games[:, 0] * self._n_tiles).reshape(-1)
        words = np.concatenate((tile_words, tile_words + _FRAME_WORDS), axis=1)
        self._tile_words = (words + games * 2 * _FRAME_WORDS).reshape(-1, words.shape[1])
        tile_pixels = pixels + games * _STACK_PIXELS + _NEWEST
        self._tile_pixels = tile_pixels.reshape(-1, pixels.shape[1])
        self._grays = game.screen.grayscale
        # Which games have a complete step to push, whose previous step is unknown, and which are
        # at their start.
        self._to_push = np.zeros(n_games, np.bool_)
        self._is_complete = True
        self._unknown = np.ones(n_games, np.bool_)
        self._at_start = np.zeros(n_games, np.bool_)
        self._any_unknown = True

    def __iter__(self) -> Iterator["AgentView"]:
        """Yield the views of the single games."""
        return (AgentView(self.game, self, index) for index in range(len(self.stacks)))

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
            reduced = _reduce(np.asarray(grays, np.uint8))
            if self._masks is not None:
                reduced *= self._masks[tiles % self._n_tiles]
            stacks.reshape(-1)[pixels] = reduced
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
        """Return the indices of the tiles to resize, counted through all games.

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
        changed = np.zeros((len(second), self._n_tiles), np.bool_)
        changed.reshape(-1)[self._tile_of_word.take(unequal.reshape(-1).nonzero()[0])] = True
        if self._any_unknown:
            changed[self._unknown[pushed]] = True
        games, tiles = changed.nonzero()
        if not isinstance(pushed, slice):
            games = pushed[games]
        return np.asarray(games * self._n_tiles + tiles, np.intp)


class AgentView:
    """The observation of one game, updated frame by frame."""

    def __init__(self, game: Game, views: AgentViews | None = None, index: int = 0) -> None:
        """Make a view; call reset.

        Args:
            game: the game that it is of.
            views: the views that it belongs to; None makes its own.
            index: its index among them.
        """
        self._game = game
        self._frames_per_step = game.clock.frames_per_step
        self._views = agent_views(game) if views is None else views
        self._index = index
        self._first, self._second = self._views.frames[index]
        self._has_first = False

    @property
    def _stack(self) -> Observation:
        self._views.flush()
        return np.asarray(self._views.stacks[self._index], np.uint8)

    def reset(self, console: Console) -> None:
        """Begin a game: fill the stack with the start's screen."""
        console.screen(self._first)
        self._second[:] = self._first
        self._has_first = False
        self._views.reset(self._index)

    def update(self, console: Console, frame: int) -> None:
        """Read the screen if the frame matters; call it after every frame.

        Args:
            console: the console that ran the frame.
            frame: number of frames executed since the start, at least 1.
        """
        frame_of_step = frame % self._frames_per_step
        if frame_of_step == 0:
            if self._frames_per_step == 1:
                self._views.flush_game(self._index)
            console.screen(self._second)
            if self._frames_per_step == 1:
                self._first[:] = self._second
            self._has_first = False
            self._views.push(self._index)
        elif frame_of_step == self._frames_per_step - 1:
            self._views.flush_game(self._index)
            console.screen(self._first)
            self._has_first = True

    def finish_step(self, console: Console, frame: int) -> None:
        """Complete the step in which an episode ended, so that the observation shows its end.

        The rest of the step runs on the console with no key held and is not part of the episode.

        Args:
            console: the console, ahead of the episode afterwards.
            frame: the episode's last frame.
        """
        while frame % self._frames_per_step:
            console.act(self._game.controls.noop)
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
            self._first[:] = np.frombuffer(state.first, np.uint8).reshape(self._first.shape)
        self._views.invalidate(self._index)
