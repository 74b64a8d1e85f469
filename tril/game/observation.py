"""Screens to observation: the only preprocessing.

An observation is the last four steps' screens, oldest first. The screen of a step is the maximum
of the step's last two frames in grayscale (bombs are drawn on even frames only), reduced to 84x84
by cv2.INTER_AREA, with the score's rows zeroed. Values are uint8 from 0 to 255.
"""

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

# Five rows of the screen make two rows of the observation, whatever the other rows hold. So a
# screen can be reduced band by band, and a band that did not change need not be reduced again.
_BAND = 5
_BAND_REDUCED = 2
_BANDS = game.SCREEN_SHAPE[0] // _BAND
_SCORE_BANDS = game.SCORE_ROWS // _BAND_REDUCED
_WORD = np.dtype(np.uint64)
_BAND_WORDS = _BAND * game.SCREEN_SHAPE[1] // _WORD.itemsize


def preprocess(first: Screen, second: Screen) -> npt.NDArray[np.uint8]:
    """Return the screen of a step, uint8 (84, 84), from its last two frames.

    Args:
        first: the frame before the last, uint8 (210, 160) grayscale.
        second: the last frame, uint8 (210, 160) grayscale.
    """
    reduced = np.zeros((SIZE, SIZE), np.uint8)
    below_score = slice(_SCORE_BANDS * _BAND, None)
    _reduce(first[below_score], second[below_score], reduced[game.SCORE_ROWS :])
    return reduced


def _reduce(first: Screen, second: Screen, out: npt.NDArray[np.uint8]) -> None:
    """Reduce the same whole bands of two grayscale frames into those rows of an observation."""
    cv2.resize(np.maximum(first, second), (SIZE, len(out)), dst=out, interpolation=cv2.INTER_AREA)


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


class AgentView:
    """What an agent sees of a game: the observation, kept up to date frame by frame.

    Only bands of the screen that differ from the step before are reduced again, which gives what
    `preprocess` gives and takes about a third of the time.
    """

    def __init__(self) -> None:
        """Make a view that sees nothing yet: call begin."""
        self._stack = np.zeros(OBSERVATION_SHAPE, np.uint8)
        # The last two frames, in palette values, of the step under way and of the step before.
        self._frames = np.zeros((2, *game.SCREEN_SHAPE), np.uint8)
        self._frames_before = np.zeros_like(self._frames)
        self._all_changed = True
        self._has_first = False
        self._differs = np.empty((2, _BANDS, _BAND_WORDS), np.bool_)
        # One more at either end, never set, so that every run of changed bands has two edges.
        self._changed = np.zeros(_BANDS + 2, np.bool_)

    def begin(self, console: Console) -> None:
        """Begin a game: the stack holds the start's screen four times."""
        console.screen_palette(self._frames[0])
        self._frames[1] = self._frames[0]
        self._all_changed = True
        self._complete_step()
        self._stack[:-1] = self._stack[-1]
        self._has_first = False

    def watch(self, console: Console, frame: int) -> None:
        """Look at the console after a frame; call it after every frame.

        Args:
            console: the console that ran the frame.
            frame: how many frames have been executed since the start, at least 1.
        """
        frame_of_step = frame % game.FRAMES_PER_STEP
        if frame_of_step == game.FRAMES_PER_STEP - 1:
            console.screen_palette(self._frames[0])
            self._has_first = True
        elif frame_of_step == 0:
            console.screen_palette(self._frames[1])
            self._complete_step()

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

    def _complete_step(self) -> None:
        """Push the screen of the step's last two frames onto the stack."""
        self._stack[:-1] = self._stack[1:]
        grays = palette_grayscale()
        reduced = self._stack[-1]
        for begin, end in self._changed_bands():
            rows = slice(begin * _BAND, end * _BAND)
            first = cv2.LUT(self._frames[0, rows], grays)
            second = cv2.LUT(self._frames[1, rows], grays)
            out = reduced[begin * _BAND_REDUCED : end * _BAND_REDUCED]
            _reduce(np.asarray(first, np.uint8), np.asarray(second, np.uint8), out)
        self._frames, self._frames_before = self._frames_before, self._frames
        self._all_changed = False
        self._has_first = False

    def _changed_bands(self) -> list[tuple[int, int]]:
        """Return the runs of changed bands, from the first of each to behind its last."""
        if self._all_changed:
            return [(_SCORE_BANDS, _BANDS)]
        words = (2, _BANDS, _BAND_WORDS)
        np.not_equal(
            self._frames.view(_WORD).reshape(words),
            self._frames_before.view(_WORD).reshape(words),
            out=self._differs,
        )
        differs = np.any(self._differs, axis=2)
        np.logical_or(differs[0], differs[1], out=self._changed[1:-1])
        self._changed[1 : 1 + _SCORE_BANDS] = False
        edges = np.flatnonzero(self._changed[1:] != self._changed[:-1]).tolist()
        return list(zip(edges[0::2], edges[1::2], strict=True))

    @property
    def observation(self) -> Observation:
        """The observation as of the last whole step, uint8 (4, 84, 84), a fresh array."""
        return self._stack.copy()

    def observe(self, out: Observation) -> None:
        """Write the observation into out, uint8 (4, 84, 84)."""
        np.copyto(out, self._stack)

    def save(self) -> AgentViewState:
        """Return the state of the view."""
        first = self._frames[0].tobytes() if self._has_first else None
        return AgentViewState(self._stack.tobytes(), first)

    def restore(self, state: AgentViewState) -> None:
        """Take up a saved state."""
        self._stack[:] = np.frombuffer(state.observation, np.uint8).reshape(OBSERVATION_SHAPE)
        self._has_first = state.first is not None
        if state.first is not None:
            self._frames[0] = np.frombuffer(state.first, np.uint8).reshape(game.SCREEN_SHAPE)
        self._all_changed = True
