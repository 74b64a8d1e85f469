"""Replays of whole recordings, in a process beside the server.

A replay in a thread takes Python's lock from the event loop again and again: with 40 players, whose
games are checked as they end, frames began up to 33 ms late, and in a process of its own up to 5 ms
(99th percentile, docs/benchmarks.md).
"""

from server.play.replays.process import ReplayProcess
from server.play.replays.wanted import Wanted

__all__ = ["ReplayProcess", "Wanted"]
