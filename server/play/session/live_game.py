"""A game in memory: how far it is, how it was played, and what of it is saved."""

from __future__ import annotations

from dataclasses import dataclass, field

from server.play.conditions import PlayConditions
from server.play.session.frame_cost import FrameCost
from server.play.session.rewind import Checkpoints
from server.play.wire.messages import all_hits, greeting, hits_after, outcome
from server.play.wire.protocol import Ended, Hello, HitMessage, Rewound
from server.play.wire.scene import Scene
from tril.games.base import Console
from tril.games.behaviours import Behaviour
from tril.play.episode import Episode
from tril.recording import Recorder
from tril.store.games import Progress


@dataclass(frozen=True)
class GameInfo:
    """What does not change about a game: ids, and the behaviour to demonstrate."""

    game_id: str
    recording_id: int
    behaviour: Behaviour


@dataclass(eq=False)
class LiveGame:
    """A game in memory.

    Attributes:
        info: Constant facts of the game.
        epoch: The owner's epoch.
        recorder: The game itself, on a console of its own.
        conditions: Conditions of play so far.
        checkpoints: States to rewind to.
    """

    info: GameInfo
    epoch: int
    recorder: Recorder
    conditions: PlayConditions
    checkpoints: Checkpoints = field(default_factory=Checkpoints)

    def __post_init__(self) -> None:
        """Take the game for saved as it is."""
        self._saved = self.episode.actions
        self._cost = FrameCost()
        self._before_frame: Progress | None = None

    @property
    def episode(self) -> Episode:
        """The episode being played."""
        return self.recorder.episode

    @property
    def is_dirty(self) -> bool:
        """Whether frames were played that are not saved."""
        return bool(self.episode.actions != self._saved)

    async def advance(self, buttons: int) -> tuple[list[HitMessage], Scene]:
        """Execute one frame with these buttons held, as bits.

        Returns:
            What was taken in it, and what the page is shown.
        """
        if self._cost.is_slow:
            # What is saved while a thread executes the frame is the game before it.
            self._before_frame = self.progress()
        try:
            return await self._cost.execute(lambda: self._advance(buttons))
        finally:
            self._before_frame = None

    def _advance(self, buttons: int) -> tuple[list[HitMessage], Scene]:
        n_taken = len(self.episode.taken)
        self.checkpoints.add_if_due(self.episode)
        self.recorder.advance(self.episode.game.controls.action_for(buttons))
        hits = hits_after(self.info.behaviour, self.episode, n_taken)
        return hits, Scene.of(self.episode)

    def rewind(self, recorder: Recorder, recording_id: int) -> tuple[Rewound, Console]:
        """Continue from an earlier frame.

        Args:
            recorder: The game up to that frame.
            recording_id: The recording of the game as it was.

        Returns:
            The message to the page, and the console that is free now.
        """
        before, self.recorder = self.recorder, recorder
        frame = self.episode.frame
        self._saved = self.episode.actions
        self.conditions = self.conditions.until(frame)
        self.checkpoints.discard_after(frame)
        hits = all_hits(self.info.behaviour, self.episode)
        message = Rewound(frame=frame, hits=hits, recording_id=recording_id)
        return message, before.episode.console

    def progress(self) -> Progress:
        """Return the game's progress, to be saved."""
        return self._before_frame or self._progress(self.recorder, self.conditions)

    def progress_after_rewind(self, recorder: Recorder) -> Progress:
        """Return the progress to save once the game continues with this recorder."""
        return self._progress(recorder, self.conditions.until(recorder.episode.frame))

    def mark_saved(self, progress: Progress) -> None:
        """Note what was committed."""
        self._saved = progress.recording.actions

    def greeting(self) -> Hello:
        """Return the first message to a page that joins."""
        speed = self.conditions.speed_percent
        return greeting(self.info.behaviour, self.episode, self.epoch, speed)

    def outcome(self, refusal: str | None) -> Ended:
        """Return the last message; ``refusal`` says why the game does not replay, if so."""
        return outcome(self.info.behaviour, self.episode, self.info.recording_id, refusal)

    def _progress(self, recorder: Recorder, conditions: PlayConditions) -> Progress:
        return Progress(
            self.info.game_id,
            self.epoch,
            recorder.recording(),
            recorder.replay(),
            conditions.to_conditions(),
        )
