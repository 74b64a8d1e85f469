"""Streaming as CrowdPlay does: every frame as JPEG, base64, in a JSON message."""

from __future__ import annotations

import base64
import json
from functools import cache
from typing import Annotated

import cv2
import numpy as np
import numpy.typing as npt
from fastapi import APIRouter, Query
from starlette.websockets import WebSocket

from server.play.stream import play_over
from server.play.wire.connection import Connection
from server.play.wire.scene import Scene
from tril.games.atari.palette import palette_rgb
from tril.games.base import Screen

QUALITY = 75

router = APIRouter()


def jpeg(screen: Screen) -> bytes:
    """Return a screen, uint8 (210, 160) of palette values, as JPEG."""
    pixels: npt.NDArray[np.uint8] = np.take(_blue_green_red(), screen, axis=0)
    _, data = cv2.imencode(".jpg", pixels, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])
    return bytes(data)


@cache
def _blue_green_red() -> npt.NDArray[np.uint8]:
    cv2.setNumThreads(1)
    return np.ascontiguousarray(palette_rgb()[:, ::-1])


class JpegConnection(Connection):
    """A connection that encodes frames as JPEG."""

    def _encode(self, scene: Scene, sequence: int) -> str:
        image = base64.b64encode(jpeg(scene.screen)).decode()
        return json.dumps({"frame": scene.frame, "sequence": sequence, "image": image})


@router.websocket("/api/games/{game_id}/jpeg")
async def play(
    websocket: WebSocket, game_id: str, tab: Annotated[str | None, Query()] = None
) -> None:
    """Play a game."""
    await play_over(websocket, JpegConnection(websocket), game_id, tab)
