"""Recordings as GIF, WebP and MP4, encoded in a process of their own at the lowest priority."""

from server.clips.maker import ClipMaker
from server.clips.request import MEDIA_TYPES, ClipKind

__all__ = ["MEDIA_TYPES", "ClipKind", "ClipMaker"]
