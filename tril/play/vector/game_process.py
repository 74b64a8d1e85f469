"""A process that plays a group of a vector's games: its main function and its parent's side.

It is a plain subprocess that imports neither the parent's main module nor torch, ignores Ctrl-C
(the parent closes it), and ends when the parent's end of the channel closes for any reason.
"""

import mmap
import os
import pickle
import signal
import socket
import subprocess
import sys
import traceback
from collections.abc import Sequence

import cv2

from tril.play.vector.channel import Channel, ChannelClosed
from tril.play.vector.game_group import Command, GameGroup, GroupConfig, Reply, SharedArrays

PARENT_CHECK_S = 2
CLOSE_TIMEOUT_S = 5.0

# Kinds of messages besides the commands.
_ASSIGN, _DONE, _ERROR = b"A", b"D", b"E"

# Not -m: the classes of a main module differ from those pickled by the parent.
_PROGRAM = "import sys; from tril.play.vector.game_process import main; sys.exit(main(sys.argv))"


class GameProcessFailed(RuntimeError):
    """A game process failed or ended."""


class GameProcess:
    """The parent's side of a process that plays a group of games.

    Attributes:
        games: the indices of its games in the vector.
    """

    def __init__(self, config: GroupConfig, memory_fd: int) -> None:
        """Start the process; the first `receive` returns when it is ready.

        Args:
            config: the games to play.
            memory_fd: file descriptor of the vector's shared memory.
        """
        self.games = config.games
        self._channel, child_socket = Channel.pair()
        # One thread each: the processes are the parallelism.
        environment = os.environ | {
            "PYTHONPATH": os.pathsep.join(os.path.abspath(path) for path in sys.path),
            "OMP_NUM_THREADS": "1",
            "OPENBLAS_NUM_THREADS": "1",
        }
        with child_socket:
            fds = (child_socket.fileno(), memory_fd)
            self._process = subprocess.Popen(
                [sys.executable, "-c", _PROGRAM, *map(str, fds)],
                pass_fds=fds,
                env=environment,
                stdin=subprocess.DEVNULL,
            )
        self._send(_ASSIGN, pickle.dumps(config))

    def send(self, command: Command, snapshots: Sequence[bytes] | None = None) -> None:
        """Send a command; see GameGroup.execute.

        Raises:
            GameProcessFailed: the process has ended.
        """
        self._send(command.value, b"" if snapshots is None else pickle.dumps(snapshots))

    def _send(self, kind: bytes, value: bytes) -> None:
        try:
            self._channel.send(kind, value)
        except ChannelClosed:
            raise self._failure() from None

    def receive(self) -> Reply:
        """Wait for the reply to the last command.

        Raises:
            GameProcessFailed: the command failed or the process has ended.
        """
        try:
            while (message := self._channel.receive()) is None:
                pass
        except ChannelClosed:
            raise self._failure() from None
        kind, value = message
        if kind == _ERROR:
            raise GameProcessFailed(f"A game process failed:\n{value.decode()}")
        # Trusted: both ends of the channel belong to this program.
        reply: Reply = pickle.loads(value) if value else None
        return reply

    def _failure(self) -> GameProcessFailed:
        code = self._process.wait(CLOSE_TIMEOUT_S)
        return GameProcessFailed(
            f"The process of games {list(self.games)} ended with exit code {code}. It may have been"
            " killed for lack of memory; resume from the last checkpoint."
        )

    def pin_to_core(self, core: int) -> None:
        """Keep the process on one core."""
        os.sched_setaffinity(self._process.pid, {core})

    def close(self) -> None:
        """Ask the process to end; see `wait`."""
        self._channel.close()

    def wait(self) -> None:
        """Wait until the closed process has ended; kill it after a timeout."""
        try:
            self._process.wait(CLOSE_TIMEOUT_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()


def _next_message(channel: Channel, parent: int) -> tuple[bytes, bytes] | None:
    """Return the parent's next message, None once the parent has closed or ended."""
    try:
        while (message := channel.receive()) is None:
            # A fork of the parent may keep its end of the socket open.
            if os.getppid() != parent:
                return None
    except ChannelClosed:
        return None
    return message


def main(arguments: Sequence[str]) -> int:
    """Play until the parent closes the channel.

    Args:
        arguments: program name, file descriptor of the socket, file descriptor of the memory.

    Returns:
        The exit code.
    """
    parent = os.getppid()
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if hasattr(os, "SCHED_BATCH"):  # Linux.
        # Waking up for a step does not interrupt the caller, who has the other games to act for.
        os.sched_setscheduler(0, os.SCHED_BATCH, os.sched_param(0))
    cv2.setNumThreads(1)
    socket_fd, memory_fd = map(int, arguments[1:])
    channel = Channel(socket.socket(fileno=socket_fd))
    channel.set_timeout(PARENT_CHECK_S)
    memory = mmap.mmap(memory_fd, 0)
    os.close(memory_fd)
    try:
        if (first := _next_message(channel, parent)) is None:
            return 0
        config: GroupConfig = pickle.loads(first[1])
        games = GameGroup(config, SharedArrays(memory, config.n_games))
        channel.send(_DONE)
        while (message := _next_message(channel, parent)) is not None:
            kind, value = message
            reply = games.execute(Command(kind), pickle.loads(value) if value else None)
            channel.send(_DONE, b"" if reply is None else pickle.dumps(reply))
    except ChannelClosed:
        return 0
    except Exception:  # noqa: BLE001 - the parent raises it
        channel.send(_ERROR, traceback.format_exc().encode())
        return 1
    return 0
