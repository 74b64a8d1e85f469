"""How many games may be open at the same time, over all server processes."""

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
    """How many games may be open, see tril.store.games.count_open.

    Attributes:
        in_all: Of everybody together.
        per_player: Of one player.
    """

    in_all: int
    per_player: int

    @classmethod
    def of(cls, settings: Settings, per_process: int) -> GameLimits:
        """Read them from the settings.

        Args:
            settings: Where 0 games in all stands for as many as all processes together can play.
            per_process: How many one process can play.
        """
        in_all = settings.max_games or per_process * settings.server_processes
        return cls(in_all, settings.max_games_per_player)

    def check(self, session: Session, player_id: int | None, n_counted: int = 0) -> None:
        """Make sure that one more game may be opened, in the transaction that opens it.

        Args:
            session: The transaction.
            player_id: Whose game it is.
            n_counted: 1 if the transaction has opened it already.

        Raises:
            TooManyGames: There is no place left.
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
        if games.count_open(session) - n_counted >= self.in_all:
            raise TooManyGames(
                f"All {self.in_all} places are taken at the moment. Games are short: try again in "
                "a minute. Whoever runs this server can allow more (TRIL_MAX_GAMES)."
            )
