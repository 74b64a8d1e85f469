"""The replay process: answers requests on standard input until it closes.

Requests and answers are pickled, which is safe between a process and the one that it started. Each
is pickled as bytes within a pickle, so that one that can't be read, as of a game that is not
installed any more, is read from the pipe to its end and leaves the next one as it is.
"""

from __future__ import annotations

import os
import pickle
import signal
import sys
import traceback

from server.play.replays.request import Answer, AnyRequest, execute
from tril.games import UnknownGame
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
            packed: bytes = pickle.load(requests)
        except EOFError:
            return
        pickle.dump(_answer(packed, consoles), answers)
        answers.flush()


def _answer(packed: bytes, consoles: Consoles) -> bytes:
    try:
        request: AnyRequest = pickle.loads(packed)
        answer = Answer(content=execute(request, consoles))
        return pickle.dumps(answer)
    except RecordingRefused as refusal:
        answer = Answer(refusal=str(refusal))
    except UnknownGame as unknown:
        answer = Answer(unknown_game=str(unknown))
    except Exception:  # noqa: BLE001
        answer = Answer(failure=traceback.format_exc())  # logged by the server
    return pickle.dumps(answer)


if __name__ == "__main__":
    main()
