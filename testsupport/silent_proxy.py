"""A TCP proxy whose connections can go silent without being closed, as when a cable is pulled."""

from __future__ import annotations

import socket
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress

HOST = "127.0.0.1"


class SilentProxy:
    """A proxy before a server of this machine.

    Args:
        port: The server's port.

    Attributes:
        port: The proxy's own port.
    """

    def __init__(self, port: int) -> None:
        self._target = port
        self._listening = socket.create_server((HOST, 0))
        self.port: int = self._listening.getsockname()[1]
        # Replaced when connections go silent, so that later ones pass.
        self._is_silent = threading.Event()
        self._sockets: list[socket.socket] = []
        self._threads: list[threading.Thread] = []
        self._run(self._accept)

    def silence(self) -> None:
        """Pass on nothing more of the present connections, and close none of them."""
        before, self._is_silent = self._is_silent, threading.Event()
        before.set()

    def stop(self) -> None:
        """Close everything."""
        for open_socket in (self._listening, *self._sockets):
            with suppress(OSError):
                open_socket.shutdown(socket.SHUT_RDWR)
        for thread in self._threads:
            thread.join()
        for open_socket in (self._listening, *self._sockets):
            open_socket.close()

    def _run(self, work: Callable[..., None], *arguments: object) -> None:
        thread = threading.Thread(target=work, args=arguments, name="proxy")
        self._threads.append(thread)
        thread.start()

    def _accept(self) -> None:
        with suppress(OSError):
            while True:
                near, _ = self._listening.accept()
                self._sockets.append(near)
                far = socket.create_connection((HOST, self._target))
                self._sockets.append(far)
                self._run(self._copy, near, far, self._is_silent)
                self._run(self._copy, far, near, self._is_silent)

    @staticmethod
    def _copy(source: socket.socket, sink: socket.socket, is_silent: threading.Event) -> None:
        with suppress(OSError):
            while (data := source.recv(2**16)) and not is_silent.is_set():
                sink.sendall(data)
            if not is_silent.is_set():
                sink.shutdown(socket.SHUT_WR)


@contextmanager
def silent_proxy(port: int) -> Iterator[SilentProxy]:
    """Run a proxy before a server for a block."""
    proxy = SilentProxy(port)
    try:
        yield proxy
    finally:
        proxy.stop()
