"""Replay what is asked for over standard input, until it closes.

Requests and answers are pickled, which is safe between a process and the one that it started.
"""

from __future__ import annotations

import os
import pickle
import signal
import sys
import traceback

from server.play.replays.answer import Answer
from server.play.replays.request import Request, carry_out
from tril.game.console import Console
from tril.recording import RecordingRefused

NICENESS = 5
"""Whoever plays comes first, and learning last."""


def main() -> None:
    """Answer one request after the other."""
    # Ctrl-C reaches all processes of a terminal; this one ends with the server's end of the pipe.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if hasattr(os, "nice"):
        os.nice(NICENESS)
    asked, answered = sys.stdin.buffer, sys.stdout.buffer
    # What else is printed, by the emulator for one, is no answer.
    sys.stdout = sys.stderr
    console = Console()
    while True:
        try:
            request: Request = pickle.load(asked)
        except EOFError:
            return
        pickle.dump(_answer(request, console), answered)
        answered.flush()


def _answer(request: Request, console: Console) -> Answer:
    try:
        return Answer(content=carry_out(request, console))
    except RecordingRefused as refusal:
        return Answer(refusal=str(refusal))
    except Exception:  # noqa: BLE001
        # The server says it in its log, and goes on.
        return Answer(failure=traceback.format_exc())


if __name__ == "__main__":
    main()
