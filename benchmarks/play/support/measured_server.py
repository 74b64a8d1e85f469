"""A server process with measurements: ``python -m benchmarks.play.support.measured_server``.

The server itself with one more route; at SIGUSR1 it writes its measurements to a file.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import logging.config
import os
import signal
import socket
import sys
import tracemalloc
from pathlib import Path

from fastapi import FastAPI

from benchmarks.play.support import jpeg
from benchmarks.play.support.memory import memory_use
from server.app import create_app
from server.heap import keep_heap_small
from server.main import LOGGING, SWITCH_INTERVAL_S, Server, bind, server_config
from server.play.rules import PlayRules
from server.services import Services
from tril.files.artifact_store import write_whole
from tril.settings import Settings

COUNTDOWN_SECOND_S = 0.2
"""Short, so that nearly all players play nearly all the time."""


class MeasuredServer(Server):
    """The server, which writes its measurements to a file at SIGUSR1."""

    def __init__(self, app: FastAPI, settings: Settings, measures: Path) -> None:
        super().__init__(server_config(app, settings))
        self._app = app
        self._measures = measures

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Start; the signal may be sent once the log says that this is done."""
        asyncio.get_running_loop().add_signal_handler(signal.SIGUSR1, self._write)
        await super().startup(sockets)

    def _write(self) -> None:
        services: Services = self._app.state.services
        content = {
            "late": services.games.lateness.counts,
            "watched_late": services.watching.lateness.counts,
            "consoles": services.consoles.n_loaded,
            "memory": memory_use(),
        }
        write_whole(self._measures, json.dumps(content).encode())


def main() -> None:
    """Serve until SIGTERM."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--data", type=Path, required=True)
    parser.add_argument("--port", type=int, required=True)
    parser.add_argument("--measures", type=Path, required=True)
    parser.add_argument("--games", type=int, required=True, help="most games in this process")
    parser.add_argument("--niceness", type=int, default=0)
    parser.add_argument("--trace-memory", action="store_true", help="say which lines allocate")
    arguments = parser.parse_args()
    if arguments.trace_memory:
        tracemalloc.start()
    os.setpriority(os.PRIO_PROCESS, 0, arguments.niceness)
    keep_heap_small()
    logging.config.dictConfig(LOGGING)
    sys.setswitchinterval(SWITCH_INTERVAL_S)
    settings = Settings(
        data=arguments.data, port=arguments.port, max_games=10_000, max_games_per_player=10_000
    )
    rules = PlayRules(countdown=1, countdown_second_s=COUNTDOWN_SECOND_S, max_games=arguments.games)
    app = create_app(settings, rules=rules)
    app.include_router(jpeg.router)
    with bind(settings, shares_port=True) as listening:
        MeasuredServer(app, settings, arguments.measures).run(sockets=[listening])


if __name__ == "__main__":
    main()
