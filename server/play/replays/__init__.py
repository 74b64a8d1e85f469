"""Replays of whole recordings, in a process beside the server.

A replay in a thread takes Python's lock from the event loop again and again, so that frames begin
late (docs/decisions/0011-replays-beside-the-server.md).
"""

from server.play.replays.process import ReplayProcess
from server.play.replays.request import Wanted

__all__ = ["ReplayProcess", "Wanted"]
