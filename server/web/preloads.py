"""Preload links of pages: scripts, styles and first API responses.

Without them, these would load one after the other: the page, its entry, the code of what it shows,
and then the data.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from html import escape
from pathlib import Path
from urllib.parse import quote

from sqlalchemy import select
from sqlalchemy.orm import Session

from server.dependencies import MAX_ID
from tril.store.models import BehaviourRow, RecordingRow, RunRow

Subject = Mapping[str, str]
"""Values for a page's data paths: "behaviour", "game", "run" and "recording", as far as known."""

PRELOADS = "preloads.json"
"""Where the build writes which files a page needs; see ``frontend/vite.config.ts``."""


@dataclass(frozen=True)
class Preload:
    """What a page needs.

    Attributes:
        path: Matches its addresses; the group, if any, is the id of what it shows.
        shows: What has the id: "behaviour", "run" or "recording"; None without one.
        files: Links to its scripts and styles, as HTML.
        data: Paths of the API; names in braces stand for the values of a ``Subject``.
    """

    path: re.Pattern[str]
    shows: str | None
    files: str
    data: tuple[str, ...]

    def links(self, subject: Subject) -> str:
        """Return HTML for the head of the page, without data that the subject does not name."""
        data = []
        for path in self.data:
            with suppress(KeyError):
                data.append(path.format_map(subject))
        return self.files + "".join(
            f'<link rel="preload" as="fetch" crossorigin href="{escape(path)}">' for path in data
        )


def subject_of(session: Session, shows: str | None, shown: str) -> Subject:
    """Return the values for a page's data paths: its id, and its behaviour and game, if known.

    Args:
        session: Database session.
        shows: See Preload.
        shown: The id of it in the page's address.
    """
    if shows is None:
        return {}
    subject = {shows: shown}
    behaviour_id: int | None
    if shows == "run":
        behaviour_id = session.scalar(select(RunRow.behaviour_id).where(RunRow.id == shown))
    elif len(shown) > len(str(MAX_ID)) or int(shown) > MAX_ID:
        return subject
    elif shows == "recording":
        of_recording = select(RecordingRow.behaviour_id).where(RecordingRow.id == int(shown))
        behaviour_id = session.scalar(of_recording)
    else:
        behaviour_id = int(shown)
    behaviour = session.get(BehaviourRow, behaviour_id) if behaviour_id else None
    if behaviour is None:
        return subject
    return subject | {"behaviour": str(behaviour.id), "game": quote(behaviour.game, safe="")}


def read_preloads(folder: Path) -> list[Preload]:
    """Return what the pages of a build need, empty if the build does not say."""
    file = folder / PRELOADS
    if not file.is_file():
        return []
    return [
        Preload(
            re.compile(page["path"]),
            page.get("shows"),
            "".join(
                [
                    *(
                        f'<link rel="modulepreload" crossorigin href="/{script}">'
                        for script in page["scripts"]
                    ),
                    *(
                        f'<link rel="preload" as="style" crossorigin href="/{style}">'
                        for style in page["styles"]
                    ),
                ]
            ),
            tuple(page["data"]),
        )
        for page in json.loads(file.read_text(encoding="utf-8"))
    ]
