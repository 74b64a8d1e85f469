"""The inference process: evaluates reward models for the server over a local socket."""

from __future__ import annotations

import contextlib
import fcntl
import logging
import os
import signal
import socket
import socketserver
import threading
from collections import OrderedDict
from collections.abc import Hashable
from pathlib import Path
from typing import Any

import numpy as np
import torch
from sqlalchemy.exc import SQLAlchemyError

from trainer.reward.model import RewardModel
from trainer.runtime.logs import set_up_logging
from trainer.runtime.priority import learning_threads
from tril.errors import Invalid, NotFound, TrilError, Unavailable
from tril.files.artifact_store import ArtifactStore
from tril.game.observation import OBSERVATION_SHAPE
from tril.heartbeat import Heartbeat
from tril.inference import (
    OBSERVATION_BYTES,
    Disconnected,
    address_of,
    receive_message,
    send_message,
)
from tril.settings import Settings
from tril.store.database import Database, create_database
from tril.store.schema import check_schema
from tril.store.training import artifacts

log = logging.getLogger(__name__)

MAX_MODELS = 16
"""Reward models kept in memory; the least recently used one is dropped."""

THREADS = 2
MESSAGE_TIMEOUT_S = 30.0
SOCKET_MODE = 0o600


def run_inference(settings: Settings) -> None:
    """Run the inference process until it is told to stop (SIGTERM or Ctrl-C).

    Raises:
        Unavailable: Another process serves this data folder, or the database is of another
            version.
    """
    set_up_logging()
    torch.set_num_threads(min(THREADS, learning_threads(0)))
    database = create_database(settings.application_url)
    try:
        check_schema(database)
        models = RewardModels(database, ArtifactStore(settings.artifact_root))
        server = InferenceServer(settings.inference_socket, models)
        for number in (signal.SIGINT, signal.SIGTERM):
            # shutdown waits for the loop that this thread runs.
            signal.signal(number, lambda *_: threading.Thread(target=server.shutdown).start())
        with server, Heartbeat(database, f"inference-{os.getpid()}", "inference"):
            log.info("Inference answers on %s.", settings.inference_socket)
            server.serve_forever(poll_interval=0.2)
    finally:
        database.close()


class RewardModels:
    """Trained reward models, loaded from the artifact store at the first request.

    Args:
        database: The application's database.
        store: The artifact store.
        max_kept: Models kept in memory.
    """

    def __init__(
        self, database: Database, store: ArtifactStore, max_kept: int = MAX_MODELS
    ) -> None:
        self._database = database
        self._store = store
        self._max_kept = max_kept
        self._kept: OrderedDict[Hashable, RewardModel] = OrderedDict()
        self._lock = threading.Lock()

    def get(self, run_id: str) -> RewardModel:
        """Return a run's reward model; raises NotFound if it has none."""
        with self._database.reading() as session:
            row = artifacts.of_kind(session, run_id, "reward_model")
        # A resumed run may replace its file.
        key = (row.id, row.created_at)
        with self._lock:
            if key not in self._kept:
                with self._store.local(row.path) as path:
                    self._kept[key] = RewardModel.load(path)
                while len(self._kept) > self._max_kept:
                    self._kept.popitem(last=False)
            self._kept.move_to_end(key)
            return self._kept[key]


class InferenceServer(socketserver.ThreadingUnixStreamServer):
    """Answers requests (see tril.inference) on a local socket that only its owner may use.

    Args:
        path: The socket; one that a dead process left is replaced.
        models: The models.

    Raises:
        Unavailable: Another process answers on it.
    """

    daemon_threads = True

    def __init__(self, path: Path, models: RewardModels) -> None:
        self.models = models
        self._path = path
        path.parent.mkdir(parents=True, exist_ok=True)
        self._lock_file = path.with_suffix(".lock").open("a")
        try:
            # Not flock: its lock would pass on to processes that inherit the descriptor.
            fcntl.lockf(self._lock_file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as problem:
            self._lock_file.close()
            raise Unavailable("Another inference process serves this data folder.") from problem
        path.unlink(missing_ok=True)
        earlier = os.umask(0o777 & ~SOCKET_MODE)
        try:
            with address_of(path) as address:
                super().__init__(address, _Handler)
        finally:
            os.umask(earlier)

    def server_close(self) -> None:
        """Close and remove the socket."""
        super().server_close()
        self._path.unlink(missing_ok=True)
        self._lock_file.close()


class _Handler(socketserver.BaseRequestHandler):
    """One connection: one request, one answer."""

    server: InferenceServer
    request: socket.socket

    def handle(self) -> None:
        self.request.settimeout(MESSAGE_TIMEOUT_S)
        # The client may have disconnected.
        with contextlib.suppress(ConnectionError, TimeoutError):
            try:
                header, body = receive_message(self.request)
                reply, values = reply_to(self.server.models, header, body)
            except Disconnected:
                return
            except (TrilError, SQLAlchemyError) as problem:
                reply, values = _error_reply(problem), b""
            except Exception as problem:
                log.exception("A request failed.")
                reply, values = _error_reply(problem), b""
            send_message(self.request, reply, values)


def reply_to(
    models: RewardModels, header: dict[str, Any], body: bytearray
) -> tuple[dict[str, Any], bytes]:
    """Return the header and the values, as bytes, of the reply to a request.

    Raises:
        Invalid: The request is malformed.
        NotFound: The run has no reward model.
    """
    op, run_id = header.get("op"), header.get("run_id")
    if op == "ping":
        return {"ok": True}, b""
    if op != "reward":
        raise Invalid(f"There is no operation {op!r}; choose ping or reward.")
    if not isinstance(run_id, str):
        raise Invalid("The request lacks 'run_id'.")
    if len(body) % OBSERVATION_BYTES:
        raise Invalid(
            f"Expected whole observations of {OBSERVATION_BYTES} bytes, got {len(body)} bytes."
        )
    observations = np.frombuffer(body, np.uint8).reshape(-1, *OBSERVATION_SHAPE)
    return {"ok": True}, models.get(run_id).score(observations).tobytes()


def _error_reply(problem: Exception) -> dict[str, Any]:
    kinds = {Invalid: "invalid", NotFound: "not_found"}
    kind = next((name for cls, name in kinds.items() if isinstance(problem, cls)), "unavailable")
    detail = str(problem)
    if not isinstance(problem, TrilError):
        detail = f"The inference process failed ({type(problem).__name__}: {detail})."
    return {"ok": False, "kind": kind, "detail": detail}
