"""A process that plays a group of a vector's games: its program, and its parent's side.

The process is a plain subprocess: it imports neither the parent's main module nor torch, ignores
Ctrl-C (the parent closes it) and ends when the parent's end of the channel closes, however the
parent ended.
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

from tril.game.vector.channel import Channel, ChannelClosed
from tril.game.vector.game_group import Answer, Assignment, Command, GameGroup, SharedArrays

PARENT_CHECK_S = 2
CLOSE_TIMEOUT_S = 5.0

# Kinds of messages besides the commands.
_ASSIGN, _DONE, _ERROR = b"A", b"D", b"E"

# Not -m: run as a main module, its classes would be others than the ones pickled by the parent.
_PROGRAM = "import sys; from tril.game.vector.game_process import main; sys.exit(main(sys.argv))"


class GameProcessFailed(RuntimeError):
    """A process that plays games ended or failed; the message says how."""


class GameProcess:
    """The parent's side of a process that plays a group of games.

    Attributes:
        games: the indices of its games in the vector.
    """

    def __init__(self, assignment: Assignment, memory_fd: int) -> None:
        """Start the process; the first `receive` returns when it is ready.

        Args:
            assignment: what it plays.
            memory_fd: file descriptor of the memory of the vector's SharedArrays.
        """
        self.games = assignment.games
        self._channel, theirs = Channel.pair()
        # One thread each: the parallelism is in the processes.
        environment = os.environ | {
            "PYTHONPATH": os.pathsep.join(os.path.abspath(path) for path in sys.path),
            "OMP_NUM_THREADS": "1",
            "OPENBLAS_NUM_THREADS": "1",
        }
        with theirs:
            fds = (theirs.fileno(), memory_fd)
            self._process = subprocess.Popen(
                [sys.executable, "-c", _PROGRAM, *map(str, fds)],
                pass_fds=fds,
                env=environment,
                stdin=subprocess.DEVNULL,
            )
        self._send(_ASSIGN, pickle.dumps(assignment))

    def send(self, command: Command, snapshots: Sequence[bytes] | None = None) -> None:
        """Begin a command; see GameGroup.answer.

        Raises:
            GameProcessFailed: the process has ended.
        """
        self._send(command.value, b"" if snapshots is None else pickle.dumps(snapshots))

    def _send(self, kind: bytes, value: bytes) -> None:
        try:
            self._channel.send(kind, value)
        except ChannelClosed:
            raise self._failure() from None

    def receive(self) -> Answer:
        """Wait for the answer to the last command.

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
            raise GameProcessFailed(f"A process that plays games failed:\n{value.decode()}")
        # Both ends of the channel are this program's own.
        answer: Answer = pickle.loads(value) if value else None
        return answer

    def _failure(self) -> GameProcessFailed:
        code = self._process.wait(CLOSE_TIMEOUT_S)
        return GameProcessFailed(
            f"A process that plays games {list(self.games)} ended with exit code {code}. It may"
            " have been killed for want of memory; go on from the last checkpoint."
        )

    def run_on(self, core: int) -> None:
        """Keep the process on one core."""
        os.sched_setaffinity(self._process.pid, {core})

    def close(self) -> None:
        """Tell the process to end; `wait` waits until it has."""
        self._channel.close()

    def wait(self) -> None:
        """Wait until the closed process has ended; a process that does not end is killed."""
        try:
            self._process.wait(CLOSE_TIMEOUT_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()


def _next_message(channel: Channel, parent: int) -> tuple[bytes, bytes] | None:
    """Wait for the parent's next message; None when the parent has closed or is gone."""
    try:
        while (message := channel.receive()) is None:
            # A process that the parent forked may hold its end of the socket open.
            if os.getppid() != parent:
                return None
    except ChannelClosed:
        return None
    return message


def main(arguments: Sequence[str]) -> int:
    """Play until the parent closes the channel.

    Args:
        arguments: the program's name, the socket's and the shared memory's file descriptor.

    Returns:
        The exit code.
    """
    parent = os.getppid()
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    cv2.setNumThreads(1)
    socket_fd, memory_fd = map(int, arguments[1:])
    channel = Channel(socket.socket(fileno=socket_fd))
    channel.wake_after(PARENT_CHECK_S)
    memory = mmap.mmap(memory_fd, 0)
    os.close(memory_fd)
    try:
        if (first := _next_message(channel, parent)) is None:
            return 0
        assignment: Assignment = pickle.loads(first[1])
        games = GameGroup(assignment, SharedArrays(memory, assignment.n_games))
        channel.send(_DONE)
        while (message := _next_message(channel, parent)) is not None:
            kind, value = message
            answer = games.answer(Command(kind), pickle.loads(value) if value else None)
            channel.send(_DONE, b"" if answer is None else pickle.dumps(answer))
    except ChannelClosed:
        return 0
    except Exception:  # noqa: BLE001 - the parent raises it
        channel.send(_ERROR, traceback.format_exc().encode())
        return 1
    return 0
