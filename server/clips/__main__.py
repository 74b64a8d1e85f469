"""Makes one clip: reads the request from standard input, writes the file to standard output."""

from __future__ import annotations

import os
import sys

# Before the heavy imports, so that games come first.
os.nice(19)

from server.clips.maker import REFUSED  # noqa: E402
from server.clips.render import render  # noqa: E402
from server.clips.request import read_request  # noqa: E402
from tril.recording import RecordingRefused  # noqa: E402

if __name__ == "__main__":
    try:
        recording, kind = read_request(sys.stdin.buffer.read())
    except RecordingRefused as refusal:
        sys.stderr.write(str(refusal))
        raise SystemExit(REFUSED) from None
    sys.stdout.buffer.write(render(recording, kind))
