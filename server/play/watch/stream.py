"""The WebSocket of a page that watches policies play."""

from __future__ import annotations

from typing import Annotated
from uuid import UUID

from fastapi import APIRouter, Query
from starlette.websockets import WebSocket

from server.dependencies import identity_of, services_of
from server.play.watch.messages import (
    LaneAck,
    Refused,
    parse_request,
    parse_watcher,
)
from server.play.watch.session import WatchSession
from server.play.watch.watch_socket import WatchSocket
from server.play.wire.heartbeat import heartbeat
from server.play.wire.protocol import BadMessage, Close, SetSpeed
from tril.errors import Invalid, NotFound, Unavailable

router = APIRouter()

Text = Annotated[str | None, Query()]


@router.websocket("/runs/{run_id}/watch")
async def watch(
    websocket: WebSocket,
    run_id: UUID,
    player: Annotated[list[str], Query()] = [],  # noqa: B006
    start: Text = None,
    draw: Text = None,
    take: Text = None,
) -> None:
    """Watch the policies of a run play, side by side."""
    await websocket.accept()
    socket = WatchSocket(websocket)
    watching = services_of(websocket).watching
    async with heartbeat(socket.send_message):
        try:
            request = parse_request(str(run_id), player, start, draw, take)
            session = await watching.open(request, socket, identity_of(websocket).player_id)
        except (Invalid, NotFound, Unavailable) as error:
            await socket.close(_code_of(error), "", Refused(why=str(error)))
            return
        try:
            await session.greet()
            await _receive(websocket, session)
        finally:
            socket.is_open = False
            await watching.close(session)


def _code_of(error: Exception) -> Close:
    if isinstance(error, Unavailable):
        return Close.TRY_AGAIN_LATER
    return Close.NO_SUCH_GAME if isinstance(error, NotFound) else Close.BAD_MESSAGE


async def _receive(websocket: WebSocket, session: WatchSession) -> None:
    while True:
        event = await websocket.receive()
        if event["type"] == "websocket.disconnect":
            return
        data = event.get("bytes")
        try:
            message = parse_watcher(
                event.get("text") or "" if data is None else data, len(session.lanes)
            )
            if isinstance(message, LaneAck):
                lane = session.lanes[message.lane]
                await lane.acknowledge(message.ack, session.is_playing)
            elif isinstance(message, SetSpeed):
                session.speed_percent = message.percent
            else:
                await session.handle(message)
        except BadMessage as error:
            await session.socket.close(Close.BAD_MESSAGE, str(error))
            return
