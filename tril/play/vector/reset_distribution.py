"""Reset distributions: where the episodes of a vector's games begin."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from tril.games.base import Game, Opening, Start, start_of


@dataclass(frozen=True)
class DemonstrationLog:
    """The executed actions of a demonstration, from which its states are replayed.

    By the rule that ends the vector's games, which must not end it before its last frame.

    Attributes:
        game: the game.
        start: how the demonstration began.
        actions: the action executed at every frame, one byte each.
    """

    game: Game
    start: Start
    actions: bytes

    def __post_init__(self) -> None:
        """Check that there are actions."""
        if not self.actions:
            raise ValueError("Expected a demonstration of at least one frame, got none.")

    @property
    def steps(self) -> int:
        """Number of steps that begin within the demonstration."""
        return self.game.clock.n_steps(len(self.actions))


@dataclass(frozen=True)
class DemonstrationStep:
    """The state of a demonstration before one of its steps.

    Attributes:
        demonstration: index into the distribution's demonstrations.
        step: from 0, the demonstration's start.
    """

    demonstration: int
    step: int


class ResetDistribution(Protocol):
    """Where the episodes of a vector's games begin."""

    @property
    def demonstrations(self) -> tuple[DemonstrationLog, ...]:
        """The demonstrations in whose states episodes may begin."""

    @property
    def possible_starts(self) -> set[Start]:
        """The starts that episodes may begin from."""

    def check(self, n_games: int) -> None:
        """Check that the distribution fits a vector of n games; raises ValueError."""

    def sample(
        self, rng: np.random.Generator, game_index: int, games_before: int
    ) -> Start | Opening | DemonstrationStep | None:
        """Return the beginning of the game's next episode, None if it has none.

        Args:
            rng: the game's own generator.
            game_index: the game.
            games_before: number of episodes it has finished.
        """

    def rng_key(self, game_index: int) -> tuple[int, ...]:
        """Return the part of the sticky-action seed that identifies a game."""


@dataclass(frozen=True)
class TrainingStarts:
    """Episodes begin at a uniformly drawn start, after an opening, or at a demonstration's step.

    An episode from a demonstration's step counts the steps before it towards the limit.

    Attributes:
        game: the game.
        starts: the starts to draw from; none is an evaluation start by default.
        demonstrations: the demonstrations in whose states episodes may begin.
        demonstration_share: share of the episodes that do, 0 to 1.
        opening_share: share of the other episodes that begin after an opening, 0 to 1.
    """

    game: Game
    starts: tuple[Start, ...] = ()
    demonstrations: tuple[DemonstrationLog, ...] = ()
    demonstration_share: float = 0.0
    opening_share: float = 0.0

    def __post_init__(self) -> None:
        """Check the values."""
        if not self.starts:
            object.__setattr__(self, "starts", tuple(self.game.starts.training))
        for share in (self.demonstration_share, self.opening_share):
            if not 0.0 <= share <= 1.0:
                raise ValueError(f"Expected a share from 0 to 1, got {share}.")
        if self.demonstration_share > 0.0 and not self.demonstrations:
            raise ValueError("Expected demonstrations for a share of games to begin in, got none.")

    @property
    def possible_starts(self) -> set[Start]:
        """All starts that are drawn from."""
        return set(self.starts)

    def check(self, n_games: int) -> None:
        """Accept any number of games."""

    def sample(
        self, rng: np.random.Generator, game_index: int, games_before: int
    ) -> Start | Opening | DemonstrationStep | None:
        """Draw a start, an opening or a step of a demonstration."""
        if self.demonstration_share > 0.0 and rng.random() < self.demonstration_share:
            demonstration = int(rng.integers(len(self.demonstrations)))
            step = int(rng.integers(self.demonstrations[demonstration].steps))
            return DemonstrationStep(demonstration, step)
        start = self.starts[int(rng.integers(len(self.starts)))]
        if self.opening_share > 0.0 and rng.random() < self.opening_share:
            return self.game.starts.draw_opening(start, rng)
        return start

    def rng_key(self, game_index: int) -> tuple[int, ...]:
        """Return the game's index."""
        return (game_index,)


@dataclass(frozen=True)
class FixedStarts:
    """Every game plays one episode from its own start and is inactive afterwards.

    Attributes:
        starts: one for each game, with an opening or without.
    """

    starts: tuple[Start | Opening, ...]

    @property
    def demonstrations(self) -> tuple[DemonstrationLog, ...]:
        """None."""
        return ()

    @property
    def possible_starts(self) -> set[Start]:
        """The games' starts."""
        return {start_of(start) for start in self.starts}

    def check(self, n_games: int) -> None:
        """Check that there is one start per game."""
        if len(self.starts) != n_games:
            raise ValueError(f"Expected {n_games} starts, one per game, got {len(self.starts)}.")

    def sample(
        self, rng: np.random.Generator, game_index: int, games_before: int
    ) -> Start | Opening | DemonstrationStep | None:
        """Return the game's start, None once it has been played."""
        return self.starts[game_index] if games_before == 0 else None

    def rng_key(self, game_index: int) -> tuple[int, ...]:
        """Return the game's start and the number of games before it with the same start.

        A game then does not depend on the other games of the vector.
        """
        start = start_of(self.starts[game_index])
        earlier = sum(start_of(begin) == start for begin in self.starts[:game_index])
        return (*start.key, earlier)
