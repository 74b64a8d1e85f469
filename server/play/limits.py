"""Limits on the number of open games, over all server processes."""

from __future__ import annotations

from dataclasses import dataclass, field

from sqlalchemy.orm import Session

from tril.errors import Unavailable
from tril.settings import Settings
from tril.store import games, players, recordings


class TooManyGames(Unavailable):
    """All places are taken; the message says what to do."""


@dataclass
class WatchedGames:
    """Counts the watched games of this process, which no row of the database tells of.

    Attributes:
        n_open: How many there are.
    """

    n_open: int = 0


@dataclass(frozen=True)
class GameLimits:
    """Limits on the number of open games, see tril.store.games.count_open.

    Attributes:
        total: Of all players together.
        per_player: Of one player.
        watched: The watched games of this process, which count as well.
        recordings_per_player: How many recordings of one player are stored at most.
    """

    total: int
    per_player: int
    watched: WatchedGames = field(default_factory=WatchedGames)
    recordings_per_player: int | None = None

    @classmethod
    def from_settings(cls, settings: Settings, per_process: int) -> GameLimits:
        """Return the configured limits.

        Args:
            settings: The settings; max_games of 0 means as many as all processes can play.
            per_process: How many games one process can play.
        """
        total = settings.max_games or per_process * settings.server_processes
        return cls(
            total,
            settings.max_games_per_player,
            recordings_per_player=settings.max_recordings_per_player,
        )

    def check(
        self, session: Session, player_id: int | None, n_counted: int = 0, n_new: int = 1
    ) -> None:
        """Check that more games may be opened, in the transaction that opens them.

        Args:
            session: The transaction.
            player_id: The games' player.
            n_counted: Games that count already but need no place beside the new ones: the new
                game itself, or games that end with its opening.
            n_new: Number of new games.

        Raises:
            TooManyGames: A limit is reached.
            Conflict: The player has too many recordings.
        """
        if player_id is not None:
            players.lock(session, player_id)
            n_own = games.count_open(session, player_id) + self.watched.n_open - n_counted
            if n_own + n_new > self.per_player:
                raise TooManyGames(
                    f"{n_own} of your games are open, and more are not allowed at the same time "
                    "(TRIL_MAX_GAMES_PER_PLAYER). Finish or stop one; a game whose tab is closed "
                    "counts for about a minute longer."
                )
            if self.recordings_per_player is not None and n_new > 0:
                recordings.refuse_too_many(session, player_id, self.recordings_per_player, n_new)
        n_open = games.count_open(session) + self.watched.n_open - n_counted
        if n_open + n_new > self.total:
            raise TooManyGames(
                f"All {self.total} places are taken at the moment. Games are short: try again in "
                "a minute. Whoever runs this server can allow more (TRIL_MAX_GAMES)."
            )
