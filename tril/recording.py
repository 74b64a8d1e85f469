"""Recordings of episodes and their replay.

A recording holds actions, not pixels. The game is a deterministic function of its start and
actions, so a replay gives the same frames, items and observations; a hash of the console's memory
once a second verifies this.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np
import numpy.typing as npt
from numpy.lib.stride_tricks import sliding_window_view

from tril.errors import Invalid
from tril.games.base import Cell, Console, Game, Start, Taken, cell_name
from tril.games.measures import Measure
from tril.games.measuring import Played, Values, check_measures, measure, reads_memory
from tril.play.episode import Episode, EpisodeState
from tril.play.observation import OBSERVATION_SHAPE, AgentView

LEVEL_STEPS = 25
"""Observations at a trajectory's beginning and end whose mean R is its first and its last level."""


def hash_interval(game: Game) -> int:
    """Return the number of frames between hashes of the console's memory: one second."""
    return game.clock.frame_rate_hz


class RecordingRefused(Invalid):
    """A recording that is invalid or does not replay as recorded."""


@dataclass(frozen=True)
class Recording:
    """A recorded episode.

    Attributes:
        game: The game.
        start: Start of the game.
        actions: The action executed at every frame, one byte each: an index of the game's actions.
        hashes: Console.state_hash() after every second; empty if they were not recorded.
        version: Version of the game that it was played on; "" for the one that is installed.
        end_rule: Name of the rule by which a loss ended it, and ends its replays; "" for the
            game's default.
    """

    game: Game
    start: Start
    actions: bytes
    hashes: tuple[str, ...] = ()
    version: str = ""
    end_rule: str = ""

    def __post_init__(self) -> None:
        """Fill in the defaults; check the actions, the end rule and the number of hashes.

        Raises:
            RecordingRefused: An action is unknown or the number of hashes is wrong.
        """
        object.__setattr__(self, "version", self.version or self.game.version)
        end_rule = self.game.check_end_rule(self.end_rule or self.game.end_rule)
        object.__setattr__(self, "end_rule", end_rule)
        n_actions = self.game.controls.n_actions
        if self.actions.translate(None, bytes(range(n_actions))):  # ten times as fast as max()
            frame = next(f for f, a in enumerate(self.actions) if a >= n_actions)
            raise RecordingRefused(
                f"Expected actions 0 to {n_actions - 1}, got {self.actions[frame]} at frame"
                f" {frame + 1}."
            )
        interval = hash_interval(self.game)
        n_hashes = self.n_frames // interval
        if self.hashes and len(self.hashes) != n_hashes:
            raise RecordingRefused(
                f"Expected {n_hashes} hashes of the memory, one after every {interval} of"
                f" {self.n_frames} frames, got {len(self.hashes)}."
            )

    @property
    def n_frames(self) -> int:
        """Number of frames after the start."""
        return len(self.actions)

    @property
    def n_steps(self) -> int:
        """Number of agent steps, including one cut short by the end."""
        return self.game.clock.n_steps(len(self.actions))

    def with_hidden_areas_of(self, game: Game) -> Recording:
        """Return the recording with the areas that a behaviour's game hides from learning."""
        settings = replace(self.game.settings, hidden=game.settings.hidden)
        return replace(self, game=self.game.with_settings(settings))

    def until(self, frame: int) -> Recording:
        """Return the recording up to a frame."""
        hashes = self.hashes[: frame // hash_interval(self.game)]
        return replace(self, actions=self.actions[:frame], hashes=hashes)


@dataclass(frozen=True)
class Replay:
    """What happened in a replay.

    Attributes:
        taken: The items taken, in order of time.
        end: Name of the end, None where the actions ended before.
        n_frames: Number of frames; actions after the end are not executed.
        counters: Counts, by name.
        score: Rewards of the game itself.
        hashes: Hash of the console's memory after every second.
        measured: Values of measures, by their keys.
    """

    taken: tuple[Taken, ...]
    end: str | None
    n_frames: int
    counters: dict[str, int]
    score: float
    hashes: tuple[str, ...]
    measured: Values = field(default_factory=dict)


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
        self._interval = hash_interval(episode.game)
        self._hashes: list[str] = []

    @classmethod
    def resume(
        cls,
        recording: Recording,
        console: Console,
        max_frames: int | None = None,
        nearest_state: EpisodeState | None = None,
    ) -> Self:
        """Resume a recording by replaying it on a console.

        Args:
            recording: The game so far.
            console: The console to play on.
            max_frames: Maximum length of the episode; None for the game's.
            nearest_state: State of the same game, not after the recording's last frame, to replay
                from instead of the start. The recording must have hashes then.

        Raises:
            RecordingRefused: The replay differs from the recording.
        """
        _check_version(recording)
        console = _console(recording, console)
        recorder = cls(Episode(console, recording.start, recording.end_rule, max_frames))
        if nearest_state is not None:
            recorder.episode.restore(nearest_state)
            before = recorder.episode.frame // recorder._interval
            recorder._hashes = list(recording.hashes[:before])
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
        if self.episode.frame % self._interval == 0:
            self._hashes.append(self.episode.console.state_hash())

    def recording(self) -> Recording:
        """Return the recording so far."""
        episode = self.episode
        return Recording(
            episode.game,
            episode.start,
            episode.actions,
            tuple(self._hashes),
            end_rule=episode.end_rule,
        )

    def replay(self) -> Replay:
        """Return the outcome so far, as a replay of the recording will give."""
        episode = self.episode
        return Replay(
            episode.taken,
            episode.end,
            episode.frame,
            episode.counters,
            episode.score,
            tuple(self._hashes),
        )


def replay(
    recording: Recording,
    console: Console | None = None,
    on_frame: Callable[[Episode], None] | None = None,
) -> Replay:
    """Replay a recording until the episode or the actions end.

    Args:
        recording: Recording to replay.
        console: A console of its game to replay on; None makes one.
        on_frame: Called at the start and after every frame.
    """
    console = _console(recording, console)
    recorder = Recorder(Episode(console, recording.start, recording.end_rule))
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


def exact_replay(
    recording: Recording,
    console: Console | None = None,
    on_frame: Callable[[Episode], None] | None = None,
) -> Replay:
    """Replay a recording as ``replay`` does, and compare its hashes.

    Raises:
        RecordingRefused: It was played on another version of the game, or the replay differs.
    """
    _check_version(recording)
    played = replay(recording, console, on_frame)
    _check_hashes(recording, played.hashes)
    return played


def _console(recording: Recording, console: Console | None) -> Console:
    """Return a console with the recording's game as it was set."""
    if console is None:
        return recording.game.make_console()
    if console.game.name != recording.game.name:
        raise ValueError(f"Expected a console of {recording.game.name}, got {console.game.name}.")
    console.game = recording.game
    return console


def verify(
    recording: Recording,
    taken: Sequence[Cell] | None = None,
    console: Console | None = None,
    rewards: Sequence[float] | None = None,
    measures: Sequence[Measure] = (),
    on_frame: Callable[[Episode], None] | None = None,
) -> Verified:
    """Verify a recording by replaying it.

    Args:
        recording: The recording; its hashes are compared if it has any.
        taken: The expected items, in order of time; None skips the comparison.
        console: A console of its game to replay on; None makes one.
        rewards: Expected reward of every frame; None skips the comparison.
        measures: Measures to take in the same replay.
        on_frame: Called at the start and after every frame; not together with ``rewards``.

    Raises:
        RecordingRefused: It was played on another version of the game, or the replay differs.
        Invalid: The game can't be measured so.
    """
    _check_version(recording)
    if rewards is not None:
        on_frame = _RewardCheck(rewards)
    played = _measured_replay(recording, console, measures, on_frame)
    _check_hashes(recording, played.hashes)
    cells = [item.cell for item in played.taken]
    if taken is not None and cells != [tuple(cell) for cell in taken]:
        raise RecordingRefused(
            f"The replay takes {_names(cells)}, but the recording says {_names(taken)}."
        )
    verified = replace(
        recording, actions=recording.actions[: played.n_frames], hashes=played.hashes
    )
    return Verified(verified, played, recording.n_frames - played.n_frames)


def _measured_replay(
    recording: Recording,
    console: Console | None,
    measures: Sequence[Measure],
    on_frame: Callable[[Episode], None] | None,
) -> Replay:
    game = recording.game
    check_measures(game, measures)
    memory: list[npt.NDArray[np.uint8]] = []

    def keep_memory(episode: Episode) -> None:
        memory.append(np.frombuffer(episode.console.ram_bytes(), np.uint8))
        if on_frame:
            on_frame(episode)

    needs_memory = any(reads_memory(game, measure) for measure in measures)
    played = replay(recording, console, keep_memory if needs_memory else on_frame)
    episode = Played(
        memory=np.array(memory, np.uint8),
        actions=recording.actions[: played.n_frames],
        taken=played.taken,
        counters=played.counters,
        score=played.score,
        end=played.end,
    )
    measured = {
        measured.measure.key: measured.value for measured in measure(game, measures, episode)
    }
    return replace(played, measured=measured)


@dataclass(frozen=True, eq=False)
class Trajectory:
    """An agent's observations and actions in a recorded episode of T steps.

    Attributes:
        observations: uint8 (T + 1, 4, 84, 84), 0 to 255: at the start and after every step.
        actions: int64 (T,), indices of the game's actions; see step_actions.
        taken: The items taken, in order of time.
        end: Name of the end, None if the recording ended before.
    """

    observations: npt.NDArray[np.uint8]
    actions: npt.NDArray[np.int64]
    taken: tuple[Taken, ...] = ()
    end: str | None = None

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
        console: A console of its game to replay on; None makes one.

    Raises:
        RecordingRefused: It was played on another version of the game, or the replay differs.
    """
    console = _console(recording, console)
    view = AgentView(recording.game)
    frames_per_step = recording.game.clock.frames_per_step
    screens = _Screens(recording.n_steps)

    def look(episode: Episode) -> None:
        if episode.frame == 0:
            view.reset(console)
        else:
            view.update(console, episode.frame)
        if episode.frame % frames_per_step == 0:
            screens.add(view, episode.frame // frames_per_step)

    played = exact_replay(recording, console, look)
    complete = replace(recording, actions=recording.actions[: played.n_frames], hashes=())
    if played.n_frames % frames_per_step:
        view.finish_step(console, played.n_frames)
        screens.add(view, complete.n_steps)
    return Trajectory(
        screens.observations[: complete.n_steps + 1],
        step_actions(complete.actions, frames_per_step),
        played.taken,
        played.end,
    )


class _Screens:
    """The screens of a game, each kept once; an observation has the last four of them.

    Args:
        n_steps: Steps of the game.
    """

    def __init__(self, n_steps: int) -> None:
        n_stacked, *size = OBSERVATION_SHAPE
        self._observation = np.empty(OBSERVATION_SHAPE, np.uint8)
        self._screens = np.zeros((n_stacked + n_steps, *size), np.uint8)

    def add(self, view: AgentView, step: int) -> None:
        """Keep what a view shows after a step; step 0 is the start, where the stack is full."""
        view.observe(self._observation)
        n_stacked = len(self._observation)
        if step == 0:
            self._screens[:n_stacked] = self._observation
        else:
            self._screens[n_stacked - 1 + step] = self._observation[-1]

    @property
    def observations(self) -> npt.NDArray[np.uint8]:
        """View of the observations, uint8 (n_steps + 1, 4, 84, 84); the start is the first."""
        # (n_steps + 1, 84, 84, 4), the stacked screens last. Writable, as torch warns of others.
        n_stacked = len(self._observation)
        stacks = sliding_window_view(self._screens, n_stacked, axis=0, writeable=True)
        observations: npt.NDArray[np.uint8] = np.moveaxis(stacks, -1, 1)
        return observations


def step_actions(actions: bytes, frames_per_step: int) -> npt.NDArray[np.int64]:
    """Return the action of each step, int64 (T,).

    It is the action executed most often in the step; ties go to the one executed last, since a
    person's keys follow what was seen before.
    """
    steps = [actions[at : at + frames_per_step] for at in range(0, len(actions), frames_per_step)]
    return np.array(
        [max(step, key=lambda a: (step.count(a), step.rindex(a))) for step in steps],
        np.int64,
    )


def _check_version(recording: Recording) -> None:
    if recording.version != recording.game.version:
        raise RecordingRefused(
            f"The recording was played on another version of {recording.game.title}"
            f" ({recording.version}); {recording.game.version} is installed."
        )


class _RewardCheck:
    """Compares what a replayed game pays with what was recorded, frame by frame."""

    def __init__(self, rewards: Sequence[float]) -> None:
        self._rewards = rewards
        self._score = 0.0

    def __call__(self, episode: Episode) -> None:
        """Look at the start or the frame that was executed."""
        paid, self._score = episode.score - self._score, episode.score
        if episode.frame == 0:
            return
        recorded = self._rewards[episode.frame - 1]
        if not math.isclose(paid, recorded, rel_tol=1e-6, abs_tol=1e-6):
            raise RecordingRefused(
                f"The replay leaves the recorded rewards at frame {episode.frame:,}: the game pays"
                f" {paid:g}, the recording says {recorded:g}. It was played from another start, or"
                " on another version of the game or its emulator. If its rewards were clipped,"
                " leave them out."
            )


def _check_hashes(recording: Recording, replayed: Sequence[str]) -> None:
    """Compare the recorded hashes with those of a replay."""
    if not recording.hashes:
        return
    interval = hash_interval(recording.game)
    for second, (recorded_hash, replayed_hash) in enumerate(
        zip(recording.hashes, replayed, strict=False), start=1
    ):
        if recorded_hash != replayed_hash:
            raise RecordingRefused(
                f"The replay differs from the recording: the memory after frame"
                f" {second * interval} has the hash {replayed_hash}, the recording says"
                f" {recorded_hash}. Its start or actions were changed or are incomplete."
            )


def _names(cells: Sequence[Cell]) -> str:
    return "; ".join(cell_name(cell) for cell in cells) or "nothing"
