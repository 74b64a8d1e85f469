"""Limits on the number of open games, over all server processes."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field

from sqlalchemy.orm import Session

from tril.errors import Unavailable
from tril.settings import Settings
from tril.store import games, players, processes, recordings


class TooManyGames(Unavailable):
    """All places are taken; the message says what to do."""


@dataclass
class WatchedGames:
    """Counts the watched games of this process, which no row of the database tells of.

    The process's heartbeat tells the other processes.

    Attributes:
        process: Name of this process.
        of_players: Number of watched games of each player.
    """

    process: str = ""
    of_players: Counter[int] = field(default_factory=Counter)

    @property
    def n_open(self) -> int:
        """How many there are."""
        return self.of_players.total()

    def details(self) -> dict[str, dict[str, int]]:
        """Return the details for the heartbeat, JSON-serialisable."""
        counts = {str(player): count for player, count in dict(self.of_players).items() if count}
        return {_DETAIL: counts} if counts else {}

    def count_all_processes(self, session: Session, player_id: int | None = None) -> int:
        """Count watched games of all processes, of one player or of all."""
        counts = [dict(self.of_players)] + [
            {int(player): count for player, count in status.details.get(_DETAIL, {}).items()}
            for status in processes.statuses(session)
            if status.alive and status.kind == "server" and status.name != self.process
        ]
        if player_id is None:
            return sum(sum(counts_of_process.values()) for counts_of_process in counts)
        return sum(counts_of_process.get(player_id, 0) for counts_of_process in counts)


_DETAIL = "watched"


@dataclass(frozen=True)
class GameLimits:
    """Limits on the number of open games, see tril.store.games.count_open.

    Attributes:
        total: Most games of all players together.
        per_player: Most games of one player.
        watched: The watched games, which count as well.
        recordings_per_player: Most stored recordings of one player.
    """

    total: int
    per_player: int
    watched: WatchedGames = field(default_factory=WatchedGames)
    recordings_per_player: int | None = None

    @classmethod
    def from_settings(cls, settings: Settings, per_process: int, process: str = "") -> GameLimits:
        """Return the configured limits.

        Args:
            settings: The settings; max_games of 0 means as many as all processes can play.
            per_process: Most games of one process.
            process: Name of this process.
        """
        total = settings.max_games or per_process * settings.server_processes
        return cls(
            total,
            settings.max_games_per_player,
            WatchedGames(process),
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
            n_watched = self.watched.count_all_processes(session, player_id)
            n_own = games.count_open(session, player_id) + n_watched - n_counted
            if n_own + n_new > self.per_player:
                raise TooManyGames(
                    f"{n_own} of your games are open, and more are not allowed at the same time "
                    "(TRIL_MAX_GAMES_PER_PLAYER). Finish or stop one; a game whose tab is closed "
                    "counts for about a minute longer."
                )
            self.check_recordings(session, player_id, n_new)
        n_watched = self.watched.count_all_processes(session)
        n_open = games.count_open(session) + n_watched - n_counted
        if n_open + n_new > self.total:
            raise TooManyGames(
                f"All {self.total} places are taken at the moment. Games are short: try again in "
                "a minute. Whoever runs this server can allow more (TRIL_MAX_GAMES)."
            )

    def check_recordings(self, session: Session, player_id: int | None, n_new: int = 1) -> None:
        """Raise Conflict if a player may not store more recordings."""
        if player_id is not None and self.recordings_per_player is not None and n_new > 0:
            recordings.refuse_too_many(session, player_id, self.recordings_per_player, n_new)
