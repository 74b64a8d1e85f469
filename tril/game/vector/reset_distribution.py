"""Where the games of a vector begin."""

from dataclasses import dataclass

import numpy as np

from tril.game import space_invaders as game
from tril.game.starts import TRAINING_IDLE_FRAMES, Start, UnknownStart


@dataclass(frozen=True)
class DemonstrationLog:
    """What a demonstration executed, from which its states are replayed.

    Attributes:
        start: how the demonstration began.
        actions: the action executed at every frame, one byte each.
    """

    start: Start
    actions: bytes

    def __post_init__(self) -> None:
        """Check that there is something to replay."""
        if not self.actions:
            raise ValueError("Expected a demonstration of at least one frame, got none.")

    @property
    def steps(self) -> int:
        """How many steps begin within the demonstration."""
        return -(-len(self.actions) // game.FRAMES_PER_STEP)


@dataclass(frozen=True)
class DemonstrationStep:
    """The state of a demonstration before one of its steps.

    Attributes:
        demonstration: index into the source's demonstrations.
        step: from 0, the demonstration's start.
    """

    demonstration: int
    step: int


@dataclass(frozen=True)
class TrainingStarts:
    """Every game begins anew at a drawn start, or within a drawn demonstration.

    A game that begins at a step of a demonstration has the rest of the 300 steps left.

    Attributes:
        idle_frames: the idle frames to draw from; by default none of an evaluation start.
        demonstrations: whose states games may begin in.
        demonstration_share: share of the games that do, 0 to 1.
    """

    idle_frames: tuple[int, ...] = TRAINING_IDLE_FRAMES
    demonstrations: tuple[DemonstrationLog, ...] = ()
    demonstration_share: float = 0.0

    def __post_init__(self) -> None:
        """Check the values."""
        if not self.idle_frames:
            raise UnknownStart("Expected at least one number of idle frames to start from.")
        for idle_frames in self.idle_frames:
            Start(idle_frames)
        if not 0.0 <= self.demonstration_share <= 1.0:
            raise ValueError(f"Expected a share from 0 to 1, got {self.demonstration_share}.")
        if self.demonstration_share > 0.0 and not self.demonstrations:
            raise ValueError("Expected demonstrations for a share of games to begin in, got none.")

    @property
    def possible_starts(self) -> set[Start]:
        """The starts that games may begin from."""
        return {Start(idle_frames) for idle_frames in self.idle_frames}

    def beginning(
        self, rng: np.random.Generator, game_index: int, games_before: int
    ) -> Start | DemonstrationStep | None:
        """Return where a game's next episode begins, drawn from the game's own generator."""
        if self.demonstration_share > 0.0 and rng.random() < self.demonstration_share:
            demonstration = int(rng.integers(len(self.demonstrations)))
            step = int(rng.integers(self.demonstrations[demonstration].steps))
            return DemonstrationStep(demonstration, step)
        return Start(self.idle_frames[int(rng.integers(len(self.idle_frames)))])

    def generator_key(self, game_index: int) -> tuple[int, ...]:
        """Return what tells a game's generator of repeated actions from the other games'."""
        return (game_index,)


@dataclass(frozen=True)
class FixedStarts:
    """Every game is played once, from its own start, and rests when it has ended.

    Attributes:
        starts: one for each game.
    """

    starts: tuple[Start, ...]

    @property
    def demonstrations(self) -> tuple[DemonstrationLog, ...]:
        """No game begins in a demonstration."""
        return ()

    @property
    def possible_starts(self) -> set[Start]:
        """The starts that games may begin from."""
        return set(self.starts)

    def beginning(
        self, rng: np.random.Generator, game_index: int, games_before: int
    ) -> Start | DemonstrationStep | None:
        """Return the game's start, or None when it has been played."""
        return self.starts[game_index] if games_before == 0 else None

    def generator_key(self, game_index: int) -> tuple[int, ...]:
        """Return what tells a game's generator of repeated actions from the other games'.

        It is the game's start, and how many games before it have the same one, so that a game does
        not depend on which others are played beside it.
        """
        start = self.starts[game_index]
        earlier = self.starts[:game_index].count(start)
        return (start.idle_frames, start.mode, start.difficulty, earlier)


StartSource = TrainingStarts | FixedStarts
