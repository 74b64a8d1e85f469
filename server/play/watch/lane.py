"""One of the games that are watched side by side."""

from __future__ import annotations

from server.play.session.frame_cost import FrameCost
from server.play.watch.messages import LaneEnded, LaneHit, lane_ended, lane_hits_after
from server.play.watch.policy_game import PolicyGame
from server.play.watch.watch_socket import LaneSocket, WatchSocket
from server.play.wire.connection import Connection
from server.play.wire.protocol import AckMessage
from server.play.wire.scene import Scene
from tril.games.behaviours import Behaviour


class Lane:
    """One of the games that are watched side by side.

    Args:
        number: Number of the lane, from 0.
        game: The game.
        behaviour: Behaviour that the policy was taught.
        socket: The page's socket.
    """

    def __init__(
        self, number: int, game: PolicyGame, behaviour: Behaviour, socket: WatchSocket
    ) -> None:
        self.number = number
        self.game = game
        self.connection = Connection(LaneSocket(socket, number))
        self._behaviour = behaviour
        self._cost = FrameCost()

    async def advance(self) -> tuple[list[LaneHit], Scene]:
        """Execute one frame; returns what was taken in it, and what the page is shown."""
        return await self._cost.execute(self._advance)

    def _advance(self) -> tuple[list[LaneHit], Scene]:
        episode = self.game.episode
        n_taken = len(episode.taken)
        self.game.advance()
        return lane_hits_after(self.number, self._behaviour, episode, n_taken), Scene.of(episode)

    def ended(self) -> LaneEnded:
        """Return the last message of the game, which is over."""
        return lane_ended(self.number, self._behaviour, self.game.episode)

    async def show(self) -> bool:
        """Send the screen; returns whether the page is not too far behind."""
        return await self.connection.show(Scene.of(self.game.episode))

    async def acknowledge(self, ack: AckMessage, is_playing: bool) -> None:
        """Handle an acknowledgement: show a frame that was dropped, if no other follows.

        Raises:
            BadMessage: It acknowledges a frame that was not sent.
        """
        self.connection.receive(ack)
        shown_frame = self.connection.shown_frame
        if shown_frame != self.game.episode.frame and (self.game.is_over or not is_playing):
            await self.show()
