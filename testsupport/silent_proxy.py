"""A TCP proxy whose connections can go silent without being closed, as when a cable is pulled."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress

from testsupport.live import TIMEOUT_S


class SilentProxy:
    """A proxy before a server of this machine.

    Args:
        port: The server's port.

    Attributes:
        port: The proxy's own port.
    """

    def __init__(self, port: int) -> None:
        self.port = 0
        self._target = port
        self._loop = asyncio.new_event_loop()
        # Replaced when connections go silent, so that later ones pass.
        self._is_silent = asyncio.Event()

    def silence(self) -> None:
        """Pass on nothing more of the present connections, and close none of them."""
        self._loop.call_soon_threadsafe(self._silence)

    def _silence(self) -> None:
        self._is_silent.set()
        self._is_silent = asyncio.Event()

    async def _serve(self, started: threading.Event) -> None:
        server = await asyncio.start_server(self._pass_on, "127.0.0.1", 0)
        self.port = server.sockets[0].getsockname()[1]
        started.set()
        await server.serve_forever()

    async def _pass_on(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        is_silent = self._is_silent
        with suppress(OSError):
            other_reader, other_writer = await asyncio.open_connection("127.0.0.1", self._target)
            await asyncio.gather(
                self._copy(reader, other_writer, is_silent),
                self._copy(other_reader, writer, is_silent),
            )

    async def _copy(
        self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter, is_silent: asyncio.Event
    ) -> None:
        with suppress(OSError):
            while data := await reader.read(2**16):
                if is_silent.is_set():
                    break
                writer.write(data)
                await writer.drain()
        if is_silent.is_set():
            await asyncio.Event().wait()
        writer.close()

    def run(self, started: threading.Event) -> None:
        """Serve in this thread until the loop is stopped."""
        serving = self._loop.create_task(self._serve(started))
        with suppress(asyncio.CancelledError):
            self._loop.run_until_complete(serving)
        tasks = asyncio.all_tasks(self._loop)
        for task in tasks:
            task.cancel()
        self._loop.run_until_complete(asyncio.gather(*tasks, return_exceptions=True))
        self._loop.close()

    def stop(self) -> None:
        """End the proxy."""
        self._loop.call_soon_threadsafe(
            lambda: [task.cancel() for task in asyncio.all_tasks(self._loop)]
        )


@contextmanager
def silent_proxy(port: int) -> Iterator[SilentProxy]:
    """Run a proxy before a server for a block."""
    proxy = SilentProxy(port)
    started = threading.Event()
    thread = threading.Thread(target=proxy.run, args=(started,), name="proxy")
    thread.start()
    assert started.wait(TIMEOUT_S)
    try:
        yield proxy
    finally:
        proxy.stop()
        thread.join(TIMEOUT_S)
