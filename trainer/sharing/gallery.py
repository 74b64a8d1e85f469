"""A folder of share pages, with an index of the behaviours that they show."""

from __future__ import annotations

import io
from collections.abc import Mapping
from pathlib import Path

from PIL import Image

from trainer.reporting.rendering import render
from trainer.sharing.films import png
from trainer.sharing.page import Parts, SharePage, make_share_page, write_share_page
from tril import __version__
from tril.files.artifact_store import ArtifactStore, write_whole
from tril.store.database import Database

CARD_WIDTH = 600


def write_gallery(
    database: Database,
    store: ArtifactStore,
    run_ids: Mapping[str, str],
    data: Path,
    parts: Parts,
    folder: Path,
) -> Path:
    """Write a page with its poster for each behaviour, and ``index.html``; return its path.

    Args:
        database: The application's database.
        store: The artifact store.
        run_ids: Run that each behaviour is shown by, keyed by its short name.
        data: The data folder.
        parts: Style and script of the pages.
        folder: Made if it isn't there; files of the same names are replaced.

    Raises:
        NotFound: No such run, or its behaviour was deleted.
        Conflict: A run is not finished.
    """
    folder.mkdir(parents=True, exist_ok=True)
    cards = []
    for slug, run_id in run_ids.items():
        page = make_share_page(database, store, run_id, data, parts)
        # A behaviour may have the index's name.
        name = f"{slug}.html" if slug != "index" else "index-.html"
        write_share_page(page, folder / name)
        cards.append((name, page.contents, _card(page)))
    index = folder / "index.html"
    html = render("gallery.html.j2", parts=parts, tril=__version__, cards=cards)
    write_whole(index, html.encode())
    return index


def _card(page: SharePage) -> bytes:
    """Return a page's poster as large as a card, a PNG."""
    poster = Image.open(io.BytesIO(page.poster)).convert("RGB")
    size = CARD_WIDTH, poster.height * CARD_WIDTH // poster.width
    small = poster.resize(size, Image.Resampling.LANCZOS)
    return png(small.quantize(128, dither=Image.Dither.NONE))
