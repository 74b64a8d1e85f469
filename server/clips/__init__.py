"""Recordings as moving pictures to take away: GIF, WebP and MP4.

They are made in a process of their own at the lowest priority, so that nobody's game waits for
them, whatever a codec does.
"""

from server.clips.maker import ClipMaker
from server.clips.request import MEDIA_TYPES, ClipKind

__all__ = ["MEDIA_TYPES", "ClipKind", "ClipMaker"]
