"""A real server on a free port, and a player that speaks the protocol with it."""

from __future__ import annotations

import json
import threading
import time
import uuid
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

import httpx2
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection, connect
from websockets.typing import Origin

from server.app import create_app
from server.main import Server, bind, server_config
from server.play.rules import PlayRules
from server.play.session.session import WHY_PAUSED
from server.play.wire.protocol import (
    AckMessage,
    Alive,
    Ended,
    FrameMessage,
    Hello,
    InputMessage,
    Paused,
    ServerMessage,
)
from server.services import Services
from testsupport.databases import settings_on
from testsupport.protocol import FrameDecoder, client_bytes, parse_frame, parse_server
from testsupport.space_invaders import Keys
from testsupport.visitors import cookie_of
from tril.games.base import Screen
from tril.settings import Settings
from tril.store import recordings
from tril.store.database import Database, create_database
from tril.store.models import RecordingRow

QUICK = PlayRules(countdown=2, countdown_second_s=0.02, max_games=4, leaving_s=2.0)
"""A short countdown and few games at once; all other times as people have them."""

TIMEOUT_S = 60.0

Message = TypeVar("Message")


@dataclass
class LiveServer:
    """A running server.

    Attributes:
        settings: Its settings, with the port it has.
        database: A connection of the test's own to its database.
        http: A client that is signed in.
        services: What the server works with.
    """

    settings: Settings
    database: Database
    http: httpx2.Client
    services: Services

    @property
    def authority(self) -> str:
        """Host and port."""
        return f"127.0.0.1:{self.settings.port}"

    def new_game(self, behaviour_id: int = 1, **more: Any) -> dict[str, Any]:
        """Begin a game."""
        return begin_game(self.http, behaviour_id, **more)

    def play(
        self, game: dict[str, Any], tab: str | None = None
    ) -> AbstractContextManager[GameClient]:
        """Join a game from a tab."""
        return join(self.settings, game, tab)

    @contextmanager
    def playing(self, frame: int, **more: Any) -> Iterator[GameClient]:
        """Begin a new game and play it up to a frame."""
        with self.play(self.new_game(**more)) as player:
            player.begin()
            player.until_frame(frame)
            yield player

    def recording(self, recording_id: int) -> dict[str, Any]:
        """Return a recording as the API shows it."""
        shown: dict[str, Any] = self.http.get(f"/api/recordings/{recording_id}").json()
        return shown

    def row(self, recording_id: int) -> RecordingRow:
        """Return a recording as it is stored."""
        with self.database.reading() as session:
            return recordings.get(session, recording_id)


@contextmanager
def join(
    settings: Settings,
    game: dict[str, Any],
    tab: str | None = None,
    cookie_header: str | None = None,
) -> Iterator[GameClient]:
    """Join a game from a tab, signed in, by default as the owner."""
    path = f"{game['stream_path']}?tab={tab or uuid.uuid4()}"
    with connect_to(settings, path, cookie_header) as socket:
        yield GameClient(socket)


def connect_to(settings: Settings, path: str, cookie_header: str | None = None) -> ClientConnection:
    """Open a stream of the server as its own page does, signed in, by default as the owner."""
    return connect(
        f"ws://{settings.host}:{settings.port}{path}",
        additional_headers={"Cookie": cookie_header or cookie(settings)},
        origin=Origin(f"http://{settings.host}:{settings.port}"),
        compression=None,
        max_size=2**20,
    )


def begin_game(http: httpx2.Client, behaviour_id: int = 1, **more: Any) -> dict[str, Any]:
    """Begin a game by a client that is signed in."""
    answer = http.post("/api/games", json={"behaviour_id": behaviour_id, **more})
    assert answer.status_code == 201, answer.text
    game: dict[str, Any] = answer.json()
    return game


def cookie(settings: Settings) -> str:
    """Return the Cookie header of a browser that is signed in."""
    return "=".join(cookie_of(settings))


@dataclass
class GameClient:
    """A page without a person: decodes frames, acknowledges them, holds keys.

    Attributes:
        socket: The stream.
        acknowledges: Whether frames are acknowledged as they come.
        screens: The last screen seen of each frame of the game.
        frames: The frame messages received, in order.
    """

    socket: ClientConnection
    acknowledges: bool = True
    screens: dict[int, Screen] = field(default_factory=dict)
    frames: list[FrameMessage] = field(default_factory=list)
    _decoder: FrameDecoder = field(init=False)
    _inputs: int = 0

    def next(self, timeout_s: float = TIMEOUT_S) -> FrameMessage | ServerMessage:
        """Wait for the next message that says more than that the server is alive."""
        deadline = time.monotonic() + timeout_s
        while isinstance(data := self.socket.recv(timeout=deadline - time.monotonic()), str):
            message = parse_server(data)
            if isinstance(message, Hello):
                channels = (3,) if message.palette is None else ()
                self._decoder = FrameDecoder((message.height, message.width, *channels))
            if not isinstance(message, Alive):
                return message
        frame = parse_frame(data)
        self.frames.append(frame)
        self.screens[frame.frame] = self._decoder.decode(frame.encoded)
        if self.acknowledges:
            self.acknowledge(frame.sequence)
        return frame

    def until(
        self, kind: type[Message], accept: Callable[[Message], bool] = lambda _message: True
    ) -> Message:
        """Wait for a message of a kind; what comes before it is taken in."""
        while True:
            message = self.next()
            if isinstance(message, kind) and accept(message):
                return message

    def until_frame(self, frame: int) -> FrameMessage:
        """Wait until the game has come to a frame; a pause by the server is ended."""
        while True:
            message = self.next()
            if isinstance(message, Paused) and message.why != WHY_PAUSED:
                self.say("ready")
            elif isinstance(message, FrameMessage) and message.frame >= frame:
                return message

    def begin(self) -> Hello:
        """Wait for the greeting, then start the countdown."""
        hello = self.until(Hello)
        self.say("ready")
        return hello

    def say(self, command: str, **more: int) -> None:
        """Send a command."""
        self.socket.send(json.dumps({"type": command, **more}))

    def hold(self, keys: Keys) -> int:
        """Hold keys from now on; returns the input's sequence."""
        self._inputs += 1
        self.socket.send(client_bytes(InputMessage(keys, self._inputs)))
        return self._inputs

    def acknowledge(self, sequence: int, latency_ms: float | None = None) -> None:
        """Say that a frame was drawn, and how long after a key's event."""
        with suppress(ConnectionClosed):  # what was sent before the close can still be read
            self.socket.send(client_bytes(AckMessage(sequence, latency_ms)))

    def stop(self) -> Ended:
        """End the game and wait for how it came out."""
        self.say("stop")
        return self.until(Ended)

    def close_code(self) -> int | None:
        """Wait until the server closes the stream; returns its code."""
        try:
            while True:
                self.next()
        except ConnectionClosed as closed:
            return None if closed.rcvd is None else closed.rcvd.code


@contextmanager
def live_server(
    data: Path,
    rules: PlayRules = QUICK,
    frontend: Path | None = None,
    port: int = 0,
    **more: Any,
) -> Iterator[LiveServer]:
    """Run a server in a thread of this process, with more settings by name."""
    listening = bind(settings_on(data, port=port))
    many = {"max_games": 1000, "max_games_per_player": 1000}
    settings = settings_on(data, port=listening.getsockname()[1], **{**many, **more})
    app = create_app(settings, rules=rules, **({"frontend": frontend} if frontend else {}))
    server = Server(server_config(app, settings))
    thread = threading.Thread(target=server.run, kwargs={"sockets": [listening]})
    thread.start()
    database = create_database(settings.application_url)
    base_url = f"http://127.0.0.1:{settings.port}"
    try:
        with httpx2.Client(base_url=base_url, timeout=TIMEOUT_S) as http:
            assert http.get("/api/health").json() == {"status": "ok"}
            http.headers["Cookie"] = cookie(settings)
            yield LiveServer(settings, database, http, app.state.services)
    finally:
        server.should_exit = True
        thread.join(TIMEOUT_S)
        listening.close()
        database.close()
    assert not thread.is_alive()
