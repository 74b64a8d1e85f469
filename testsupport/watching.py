"""Runs whose policies can be watched, and a page without a person that watches them."""

from __future__ import annotations

import json
import tempfile
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from urllib.parse import urlencode

import numpy as np
import torch
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection

from server.play.wire.protocol import AckMessage, FrameMessage
from testsupport.live import TIMEOUT_S, connect_to
from testsupport.protocol import FrameDecoder, client_bytes, parse_frame
from testsupport.workplace import TINY, Workplace
from trainer.policy.networks import new_policy, save_policy
from trainer.reward.model import RewardModel, new_network
from trainer.runtime.answers import Models
from trainer.runtime.inference import LocalServer, TcpServer, new_server
from tril.files.artifact_store import ArtifactStore
from tril.games.base import Screen
from tril.recipes import Recipe
from tril.settings import Settings
from tril.store.models import RunStatus
from tril.store.training import artifacts, leases
from tril.store.training.evaluations import POLICIES


def finished_run(
    workplace: Workplace,
    recipe: Recipe = TINY,
    policies: Sequence[str] = POLICIES,
    network: str = "small",
    model: RewardModel | None = None,
) -> str:
    """Make a run that is done, with untrained networks in place of trained ones."""
    run_id = workplace.make_run(recipe)
    lease = workplace.lease(run_id)
    store = ArtifactStore(workplace.settings.artifact_root)
    with tempfile.TemporaryDirectory() as folder:
        paths = {"reward_model": Path(folder) / "reward-model.safetensors"}
        model = model or RewardModel(new_network(np.random.default_rng(0)))
        model.save(paths["reward_model"])
        for seed, policy in enumerate(policies):
            paths[policy] = Path(folder) / f"{policy}.zip"
            trained = new_policy(network, 6, 0.0, np.random.default_rng(seed))
            # Decided enough that what is selected does not hang on the last bit.
            weight = trained.action_net.weight
            assert isinstance(weight, torch.Tensor)
            weight.data.mul_(100.0)
            save_policy(trained, paths[policy])
        with workplace.database.writing() as session:
            for kind, path in paths.items():
                n_bytes = store.put(artifacts.path_of(run_id, path.name), path.read_bytes())
                media_type = "application/octet-stream"
                artifacts.save(session, run_id, kind, path.name, media_type, n_bytes)
            leases.end(session, lease, RunStatus.DONE)
    return run_id


@contextmanager
def running_inference(
    workplace: Workplace, models: Callable[..., Models] = Models
) -> Iterator[LocalServer | TcpServer]:
    """Run the inference server in a thread of this process."""
    store = ArtifactStore(workplace.settings.artifact_root)
    networks = models(workplace.database, store)
    with new_server(workplace.settings, networks) as server:
        thread = threading.Thread(target=server.serve_forever, args=(0.01,))
        thread.start()
        try:
            yield server
        finally:
            server.shutdown()
            thread.join()


@dataclass
class Watcher:
    """A page that watches: decodes the frames of each lane, and acknowledges them.

    Attributes:
        socket: The stream.
        acknowledges: Whether frames are acknowledged as they come.
        frames: The frames received, by lane.
        screens: The last screen of each frame, by lane.
        said: The text messages received.
    """

    socket: ClientConnection
    acknowledges: bool = True
    frames: dict[int, list[FrameMessage]] = field(default_factory=dict)
    screens: dict[int, dict[int, Screen]] = field(default_factory=dict)
    said: list[dict[str, Any]] = field(default_factory=list)
    _decoders: dict[int, FrameDecoder] = field(default_factory=dict)

    def next(self, timeout_s: float = TIMEOUT_S) -> dict[str, Any] | None:
        """Wait for the next message; returns it if it is a text."""
        deadline = time.monotonic() + timeout_s
        while isinstance(data := self.socket.recv(timeout=deadline - time.monotonic()), str):
            message: dict[str, Any] = json.loads(data)
            if message["type"] != "alive":
                self.said.append(message)
                return message
        lane, frame = data[0], parse_frame(data[1:])
        self.frames.setdefault(lane, []).append(frame)
        hello = self.said[0]
        channels = (3,) if hello["palette"] is None else ()
        shape = (hello["height"], hello["width"], *channels)
        decoder = self._decoders.setdefault(lane, FrameDecoder(shape))
        self.screens.setdefault(lane, {})[frame.frame] = decoder.decode(frame.encoded)
        if self.acknowledges:
            self.socket.send(bytes((lane,)) + client_bytes(AckMessage(frame.sequence)))
        return None

    def until(
        self, kind: str, accept: Callable[[dict[str, Any]], bool] = lambda _message: True
    ) -> dict[str, Any]:
        """Wait for a text message of a type."""
        while True:
            message = self.next()
            if message is not None and message["type"] == kind and accept(message):
                return message

    def until_frame(self, frame: int, lane: int = 0) -> None:
        """Wait until a lane's game has come to a frame."""
        while not any(seen.frame >= frame for seen in self.frames.get(lane, [])):
            self.next()

    def say(self, command: str, **more: int | str | None) -> None:
        """Send a command."""
        self.socket.send(json.dumps({"type": command, **more}))

    def close_code(self) -> int | None:
        """Wait until the server closes the stream; returns its code."""
        try:
            while True:
                self.next()
        except ConnectionClosed as closed:
            return None if closed.rcvd is None else closed.rcvd.code

    def of(self, kind: str, lane: int = 0) -> list[dict[str, Any]]:
        """Return a lane's messages of a type so far."""
        return [one for one in self.said if one["type"] == kind and one.get("lane") == lane]


@contextmanager
def watching(
    settings: Settings, run_id: str, *players: str, **query: int | str
) -> Iterator[Watcher]:
    """Watch players such as "imitator.greedy" for the block."""
    asked = urlencode([*(("player", player) for player in players), *query.items()])
    with connect_to(settings, f"/api/runs/{run_id}/watch?{asked}") as socket:
        yield Watcher(socket)
