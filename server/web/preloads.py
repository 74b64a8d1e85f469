"""Preload links of pages: scripts, styles and first API responses.

Without it they would come one after the other: the page, its entry, the code of what it shows, and
then the data.
"""

from __future__ import annotations

import json
import re
from dataclasses import dataclass
from html import escape
from pathlib import Path

PRELOADS = "preloads.json"
"""Where the build writes which files a page needs; see ``frontend/vite.config.ts``."""


@dataclass(frozen=True)
class Preload:
    """What a page needs.

    Attributes:
        path: Matches its addresses; the group, if any, is the id of what it shows.
        files: Links to its scripts and styles, as HTML.
        data: Paths of the API; ``{id}`` stands for the id.
    """

    path: re.Pattern[str]
    files: str
    data: tuple[str, ...]

    def links(self, path: str, with_data: bool) -> str | None:
        """Return HTML for the head of the page at a path, None if it is another page."""
        match = self.path.fullmatch(path)
        if match is None:
            return None
        shown = match[1] if self.path.groups else ""
        data = [url.replace("{id}", shown) for url in self.data] if with_data else []
        return self.files + "".join(
            f'<link rel="preload" as="fetch" crossorigin href="{escape(url)}">' for url in data
        )


def read_preloads(folder: Path) -> list[Preload]:
    """Return what the pages of a build need, empty if the build does not say."""
    file = folder / PRELOADS
    if not file.is_file():
        return []
    return [
        Preload(
            re.compile(page["path"]),
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
