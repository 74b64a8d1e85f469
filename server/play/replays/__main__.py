"""The replay process: answers requests on standard input until it closes.

Requests and answers are pickled, which is safe between a process and the one that it started.
"""

from __future__ import annotations

import os
import pickle
import signal
import sys
import traceback

from server.play.replays.request import Answer, AnyRequest, execute
from tril.play.consoles import Consoles
from tril.recording import RecordingRefused

NICENESS = 5
"""Below the games being played, above training."""


def main() -> None:
    """Answer requests one after the other."""
    # Ctrl-C reaches all processes of a terminal; this one ends when the server closes the pipe.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if hasattr(os, "nice"):
        os.nice(NICENESS)
    requests, answers = sys.stdin.buffer, sys.stdout.buffer
    # Keep other output, the emulator's for one, out of the answers.
    sys.stdout = sys.stderr
    consoles = Consoles()
    while True:
        try:
            request: AnyRequest = pickle.load(requests)
        except EOFError:
            return
        pickle.dump(_answer(request, consoles), answers)
        answers.flush()


def _answer(request: AnyRequest, consoles: Consoles) -> Answer:
    try:
        return Answer(content=execute(request, consoles))
    except RecordingRefused as refusal:
        return Answer(refusal=str(refusal))
    except Exception:  # noqa: BLE001
        return Answer(failure=traceback.format_exc())  # logged by the server


if __name__ == "__main__":
    main()
