"""Limits on the number of open games, over all server processes."""

from __future__ import annotations

from dataclasses import dataclass

from sqlalchemy.orm import Session

from tril.errors import Unavailable
from tril.settings import Settings
from tril.store import games, players


class TooManyGames(Unavailable):
    """All places are taken; the message says what to do."""


@dataclass(frozen=True)
class GameLimits:
    """Limits on the number of open games, see tril.store.games.count_open.

    Attributes:
        total: Of all players together.
        per_player: Of one player.
    """

    total: int
    per_player: int

    @classmethod
    def from_settings(cls, settings: Settings, per_process: int) -> GameLimits:
        """Return the configured limits.

        Args:
            settings: The settings; max_games of 0 means as many as all processes can play.
            per_process: How many games one process can play.
        """
        total = settings.max_games or per_process * settings.server_processes
        return cls(total, settings.max_games_per_player)

    def check(self, session: Session, player_id: int | None, n_counted: int = 0) -> None:
        """Check that one more game may be opened, in the transaction that opens it.

        Args:
            session: The transaction.
            player_id: The game's player.
            n_counted: 1 if the transaction has opened the game already.

        Raises:
            TooManyGames: A limit is reached.
        """
        if player_id is not None:
            players.lock(session, player_id)
            n_own = games.count_open(session, player_id) - n_counted
            if n_own >= self.per_player:
                raise TooManyGames(
                    f"{n_own} of your games are open, and more are not allowed at the same time "
                    "(TRIL_MAX_GAMES_PER_PLAYER). Finish or stop one; a game whose tab is closed "
                    "counts for about a minute longer."
                )
        if games.count_open(session) - n_counted >= self.total:
            raise TooManyGames(
                f"All {self.total} places are taken at the moment. Games are short: try again in "
                "a minute. Whoever runs this server can allow more (TRIL_MAX_GAMES)."
            )
