"""Replays of whole recordings and games of varied play, in a process beside the server.

A replay in a thread would hold Python's lock again and again, which delays frames
(docs/decisions/18-clips-and-replays.md).
"""

from server.play.replays.process import ReplayProcess
from server.play.replays.request import ReplayTask

__all__ = ["ReplayProcess", "ReplayTask"]
