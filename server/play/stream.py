"""The WebSocket of a game: receives a page's messages and passes them to its session."""

from __future__ import annotations

import re
from typing import Annotated
from uuid import uuid4

from fastapi import APIRouter, Query
from starlette.websockets import WebSocket

from server.dependencies import services_of
from server.play.session.session import PlaySession
from server.play.wire.connection import Connection
from server.play.wire.heartbeat import heartbeat
from server.play.wire.protocol import BadMessage, Close, Command, SetSpeed, parse_client
from tril.errors import NotFound, Unavailable
from tril.store.games import GameOver

router = APIRouter()

_TAB = re.compile(r"[0-9A-Za-z-]{1,36}")


@router.websocket("/games/{game_id}/stream")
async def play(
    websocket: WebSocket, game_id: str, tab: Annotated[str | None, Query()] = None
) -> None:
    """Play a game; the newest tab that joins has it."""
    await play_over(websocket, Connection(websocket), game_id, tab)


async def play_over(
    websocket: WebSocket, connection: Connection, game_id: str, tab: str | None
) -> None:
    """Play a game over a WebSocket and a connection on top of it, until it closes."""
    await websocket.accept()
    async with heartbeat(connection.send):
        await _play(websocket, connection, game_id, tab or str(uuid4()))


async def _play(websocket: WebSocket, connection: Connection, game_id: str, tab: str) -> None:
    if not _TAB.fullmatch(tab):
        await connection.close(Close.BAD_MESSAGE, "Expected the tab's UUID.")
        return
    try:
        session = await services_of(websocket).games.join(game_id, tab, connection)
    except NotFound:
        await connection.close(Close.NO_SUCH_GAME, "There is no such game.")
    except GameOver as error:
        await connection.close(Close.GAME_OVER, str(error))
    except Unavailable as error:
        await connection.close(Close.TRY_AGAIN_LATER, str(error))
    else:
        try:
            await _receive(websocket, connection, session)
        finally:
            connection.is_open = False
            await session.detach(connection)


async def _receive(websocket: WebSocket, connection: Connection, session: PlaySession) -> None:
    while True:
        event = await websocket.receive()
        if event["type"] == "websocket.disconnect":
            return
        data = event.get("bytes")
        try:
            message = parse_client(event.get("text") or "" if data is None else data)
            if isinstance(message, Command):
                await session.handle(message)
            elif isinstance(message, SetSpeed):
                session.set_speed(message.percent)
            else:
                connection.receive(message)
                await session.acknowledge()
        except BadMessage as error:
            await connection.close(Close.BAD_MESSAGE, str(error))
            return
