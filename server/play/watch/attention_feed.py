"""What the networks of watched games look at, for a page that asks to see it."""

from __future__ import annotations

import asyncio
import logging
from base64 import b64encode
from collections.abc import Sequence

import numpy as np

from server.play.watch.lane import Lane
from server.play.watch.messages import LaneAttention, Watched
from server.play.watch.policy_client import PolicyClient
from server.play.watch.watch_socket import WatchSocket
from tril.errors import TrilError
from tril.inference import AttentionMap

_LOG = logging.getLogger(__name__)

REST_S = 0.05
"""Between two maps, which take about as long: the games' decisions come first."""


class AttentionFeed:
    """Sends maps of what is on the screens, one game after the other, while somebody looks.

    One map at a time is asked for, of the newest state of the game whose turn it is, by the
    gradient, which takes a fiftieth of what occlusion does.

    Args:
        lanes: The games.
        socket: The page's socket.
        client: Asks for maps, on a connection of its own, so that no action waits for them.
    """

    def __init__(self, lanes: Sequence[Lane], socket: WatchSocket, client: PolicyClient) -> None:
        self._lanes = lanes
        self._socket = socket
        self._client = client
        self._watched: Watched | None = None
        self._task: asyncio.Task[None] | None = None

    async def show(self, watched: Watched | None) -> None:
        """Begin to show what the games' policies look at, or the reward, or nothing."""
        await self.close()
        self._watched = watched
        if watched is not None:
            self._task = asyncio.create_task(self._feed(watched), name="attention")

    async def close(self) -> None:
        """Send no more maps."""
        if self._task is not None:
            self._task.cancel()
            await asyncio.gather(self._task, return_exceptions=True)
            self._task = None
        self._client.close()

    async def _feed(self, watched: Watched) -> None:
        shown_frames: dict[int, int] = {}
        while self._socket.is_open:
            for lane in self._lanes:
                frame = lane.game.observed_frame
                if shown_frames.get(lane.number) == frame:
                    continue
                try:
                    unit = await self._unit(watched)
                    attention = await self._client.attention(
                        "reward" if watched == "reward" else lane.game.actor.policy,
                        lane.game.observation,
                        lane.game.episode.game.screen.background,
                    )
                except TrilError as error:
                    # The map is left out; whether the games can go on is for their actions to say.
                    _LOG.info("No attention maps are shown: %s", error)
                    return
                shown_frames[lane.number] = frame
                await self._socket.send_message(_message(lane.number, frame, attention, unit))
                await asyncio.sleep(REST_S)
            await asyncio.sleep(REST_S)

    async def _unit(self, watched: Watched) -> float:
        """Return the unit of a map's values: of the reward, R between the levels 0 and 1."""
        if watched != "reward":
            return 1.0
        zero_level, unit_level = await self._client.scale()
        return abs(unit_level - zero_level)


def _message(lane: int, frame: int, attention: AttentionMap, unit: float) -> LaneAttention:
    peak = float(attention.values.max())
    shares = attention.values / peak if peak > 0.0 else attention.values
    return LaneAttention(
        lane=lane,
        frame=frame,
        most=peak / unit,
        action=None if attention.action is None else int(attention.action),
        shares=b64encode(np.rint(255.0 * shares).astype(np.uint8).tobytes()).decode(),
    )
