"""Recordings of episodes and their replay.

A recording holds actions, not pixels. The game is a deterministic function of its start and
actions, so a replay gives the same frames, hits and observations; a hash of the RAM once a second
verifies this.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np
import numpy.typing as npt

from tril.errors import Invalid
from tril.games.atari.console import Console
from tril.games.space_invaders import memory as game
from tril.play.episode import Ending, EndReason, Episode, EpisodeState, Hit, Start
from tril.play.observation import OBSERVATION_SHAPE, AgentView

HASH_EVERY_FRAMES = game.FRAME_RATE_HZ
"""Frames between hashes of the RAM: one second."""

LEVEL_STEPS = 25
"""Observations at a trajectory's beginning and end whose mean R is its first and its last level."""

_ACTIONS = bytes(game.Action)


class RecordingRefused(Invalid):
    """A recording that is invalid or does not replay as recorded."""


@dataclass(frozen=True)
class Recording:
    """A recorded episode.

    Attributes:
        start: How the game began.
        actions: The action executed at every frame, one byte each, see tril.game's Action.
        ram_hashes: Console.ram_hash() after every 60th frame; empty if they were not recorded.
        rom_md5: MD5 of the ROM it was played on, in hexadecimal.
        ending: Which rule for the player's death ended it, and ends its replays.
    """

    start: Start
    actions: bytes
    ram_hashes: tuple[str, ...] = ()
    rom_md5: str = field(default_factory=game.rom_md5)
    ending: Ending = Ending.HIT

    def __post_init__(self) -> None:
        """Check the actions and the number of hashes.

        Raises:
            RecordingRefused: An action is unknown or the number of hashes is wrong.
        """
        if self.actions.translate(None, _ACTIONS):  # ten times as fast as max()
            frame = next(f for f, a in enumerate(self.actions) if a >= len(game.Action))
            raise RecordingRefused(
                f"Expected actions 0 to {len(game.Action) - 1}, got {self.actions[frame]} at"
                f" frame {frame + 1}."
            )
        n_hashes = self.n_frames // HASH_EVERY_FRAMES
        if self.ram_hashes and len(self.ram_hashes) != n_hashes:
            raise RecordingRefused(
                f"Expected {n_hashes} RAM hashes, one after every {HASH_EVERY_FRAMES} of"
                f" {self.n_frames} frames, got {len(self.ram_hashes)}."
            )

    @property
    def n_frames(self) -> int:
        """Number of frames after the start."""
        return len(self.actions)

    @property
    def n_steps(self) -> int:
        """Number of agent steps, including one cut short by the end."""
        return -(-len(self.actions) // game.FRAMES_PER_STEP)

    def until(self, frame: int) -> Recording:
        """Return the recording up to a frame."""
        hashes = self.ram_hashes[: frame // HASH_EVERY_FRAMES]
        return replace(self, actions=self.actions[:frame], ram_hashes=hashes)


@dataclass(frozen=True)
class Replay:
    """What happened in a replay.

    Attributes:
        hits: The aliens shot, in order of time.
        end: Why the episode ended, None where the actions ended before.
        n_frames: Number of frames; actions after the end are not executed.
        shots: Missiles that left the cannon.
        ram_hashes: Hash of the RAM after every 60th frame.
    """

    hits: tuple[Hit, ...]
    end: EndReason | None
    n_frames: int
    shots: int
    ram_hashes: tuple[str, ...]


@dataclass(frozen=True)
class Verified:
    """A verified recording.

    Attributes:
        recording: The recording with all RAM hashes, cut at the end of its episode.
        replay: The outcome of the replay.
        n_cut: Number of actions after the end of the episode.
    """

    recording: Recording
    replay: Replay
    n_cut: int


class Recorder:
    """Records an episode while it is played.

    Attributes:
        episode: The episode, to be advanced by the recorder only.
    """

    def __init__(self, episode: Episode) -> None:
        """Begin to record an episode at its start.

        Raises:
            ValueError: The episode has begun; use resume.
        """
        if episode.frame:
            raise ValueError(f"Expected an episode at its start, got one at frame {episode.frame}.")
        self.episode = episode
        self._hashes: list[str] = []

    @classmethod
    def resume(
        cls,
        recording: Recording,
        console: Console,
        max_frames: int = game.MAX_FRAMES,
        near: EpisodeState | None = None,
    ) -> Self:
        """Resume a recording by replaying it on a console.

        Args:
            recording: The game so far.
            console: The console to play on.
            max_frames: Maximum length of the episode.
            near: A state of the same game, not after the recording's last frame, to replay from
                instead of the start. The recording must have RAM hashes then.

        Raises:
            RecordingRefused: The replay differs from the recording.
        """
        _check_rom(recording)
        recorder = cls(Episode(console, recording.start, recording.ending, max_frames))
        if near is not None:
            recorder.episode.restore(near)
            before = recorder.episode.frame // HASH_EVERY_FRAMES
            recorder._hashes = list(recording.ram_hashes[:before])
        for action in recording.actions[recorder.episode.frame :]:
            if recorder.episode.end is not None:
                raise RecordingRefused(
                    f"The game to resume ended at frame {recorder.episode.frame}, but"
                    f" {recording.n_frames} frames were recorded."
                )
            recorder.advance(action)
        _check_hashes(recording, recorder._hashes)
        return recorder

    def advance(self, action: int) -> None:
        """Run and record one frame with this action; see Episode.advance."""
        self.episode.advance(action)
        if self.episode.frame % HASH_EVERY_FRAMES == 0:
            self._hashes.append(self.episode.console.ram_hash())

    def recording(self) -> Recording:
        """Return the recording so far."""
        episode = self.episode
        return Recording(episode.start, episode.actions, tuple(self._hashes), ending=episode.ending)

    def replay(self) -> Replay:
        """Return the outcome so far, as a replay of the recording will give."""
        episode = self.episode
        return Replay(episode.hits, episode.end, episode.frame, episode.shots, tuple(self._hashes))


def replay(
    recording: Recording,
    console: Console | None = None,
    on_frame: Callable[[Episode], None] | None = None,
) -> Replay:
    """Replay a recording until the episode or the actions end.

    Args:
        recording: What to replay.
        console: The console to replay on; None loads one, which takes 0.1 s.
        on_frame: Called at the start and after every frame.
    """
    recorder = Recorder(Episode(console or Console(), recording.start, recording.ending))
    episode = recorder.episode
    if on_frame:
        on_frame(episode)
    for action in recording.actions:
        if episode.end is not None:
            break
        recorder.advance(action)
        if on_frame:
            on_frame(episode)
    return recorder.replay()


def verify(
    recording: Recording,
    hits: Sequence[tuple[int, int]] | None = None,
    console: Console | None = None,
) -> Verified:
    """Verify a recording by replaying it.

    Args:
        recording: The recording; its RAM hashes are compared if it has any.
        hits: The expected hits as (row, column), in order of time; None skips the comparison.
        console: The console to replay on; None loads one.

    Raises:
        RecordingRefused: It was played on another ROM, or the replay differs.
    """
    _check_rom(recording)
    played = replay(recording, console)
    _check_hashes(recording, played.ram_hashes)
    cells = [(hit.row, hit.column) for hit in played.hits]
    if hits is not None and cells != [tuple(cell) for cell in hits]:
        raise RecordingRefused(
            f"The replay hits {_cells(cells)}, but the recording says {_cells(hits)}"
            " ([row from the bottom, column from the left], from 0)."
        )
    kept = replace(
        recording, actions=recording.actions[: played.n_frames], ram_hashes=played.ram_hashes
    )
    return Verified(kept, played, recording.n_frames - played.n_frames)


@dataclass(frozen=True, eq=False)
class Trajectory:
    """An agent's observations and actions in a recorded episode of T steps.

    Attributes:
        observations: uint8 (T + 1, 4, 84, 84), 0 to 255: at the start and after every step.
        actions: int64 (T,), 0 to 5; see step_actions.
        hits: The aliens shot, in order of time.
        end: Why the episode ended, None if the recording ended before.
    """

    observations: npt.NDArray[np.uint8]
    actions: npt.NDArray[np.int64]
    hits: tuple[Hit, ...] = ()
    end: EndReason | None = None

    def __post_init__(self) -> None:
        """Check the shapes."""
        expected = (len(self.actions) + 1, *OBSERVATION_SHAPE)
        if self.observations.shape != expected or self.observations.dtype != np.uint8:
            raise ValueError(
                f"Expected uint8 observations {expected}, got {self.observations.dtype}"
                f" {self.observations.shape}."
            )

    @property
    def n_steps(self) -> int:
        """Number of steps T."""
        return len(self.actions)


def trajectory(recording: Recording, console: Console | None = None) -> Trajectory:
    """Replay a recording as an agent's trajectory.

    A step cut short by the episode's end counts as a step; see AgentView.finish_step for its
    observation.

    Args:
        recording: A verified recording.
        console: The console to replay on; None loads one.

    Raises:
        RecordingRefused: It was played on another ROM, or the replay differs.
    """
    _check_rom(recording)
    console = console or Console()
    view = AgentView()
    observations = np.empty((recording.n_steps + 1, *OBSERVATION_SHAPE), np.uint8)

    def look(episode: Episode) -> None:
        if episode.frame == 0:
            view.reset(console)
        else:
            view.update(console, episode.frame)
        if episode.frame % game.FRAMES_PER_STEP == 0:
            view.observe(observations[episode.frame // game.FRAMES_PER_STEP])

    played = replay(recording, console, look)
    _check_hashes(recording, played.ram_hashes)
    kept = replace(recording, actions=recording.actions[: played.n_frames], ram_hashes=())
    if played.n_frames % game.FRAMES_PER_STEP:
        view.finish_step(console, played.n_frames)
        view.observe(observations[kept.n_steps])
    return Trajectory(
        observations[: kept.n_steps + 1], step_actions(kept.actions), played.hits, played.end
    )


def step_actions(actions: bytes) -> npt.NDArray[np.int64]:
    """Return the action of each step of four frames, int64 (T,).

    It is the action executed most often in the step; ties go to the one executed last, since a
    person's keys follow what was seen before.
    """
    length = game.FRAMES_PER_STEP
    steps = [actions[at : at + length] for at in range(0, len(actions), length)]
    return np.array(
        [max(step, key=lambda a: (step.count(a), step.rindex(a))) for step in steps],
        np.int64,
    )


def _check_rom(recording: Recording) -> None:
    if recording.rom_md5 != game.rom_md5():
        raise RecordingRefused(
            f"The recording was played on another ROM (MD5 {recording.rom_md5}); expected"
            f" {game.rom_md5()}, the Space Invaders of ale-py."
        )


def _check_hashes(recording: Recording, replayed: Sequence[str]) -> None:
    """Compare the recorded RAM hashes with those of a replay."""
    if not recording.ram_hashes:
        return
    for second, (recorded, seen) in enumerate(
        zip(recording.ram_hashes, replayed, strict=False), start=1
    ):
        if recorded != seen:
            raise RecordingRefused(
                f"The replay differs from the recording: the RAM after frame"
                f" {second * HASH_EVERY_FRAMES} has the hash {seen}, the recording says"
                f" {recorded}. Its start or actions were changed or are incomplete."
            )


def _cells(cells: Sequence[tuple[int, int]]) -> str:
    return ", ".join(f"[{row}, {column}]" for row, column in cells) or "no alien"
