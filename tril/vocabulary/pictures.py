"""A picture of each kind of things: a part of the game's screen with one of them."""

from __future__ import annotations

import io
import zipfile
import zlib
from collections import defaultdict
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from PIL import Image

from tril.files.artifact_store import write_whole
from tril.games.base import Console, Game, Screen
from tril.play.episode import Episode
from tril.recording import Recording, replay
from tril.vocabulary.blobs import Blobs, box_of
from tril.vocabulary.facts import Vocabulary
from tril.vocabulary.formations import FORMATION
from tril.vocabulary.lasting import Mask
from tril.vocabulary.pieces import PIECES
from tril.vocabulary.trace import colours_of, rgb_of, trace

SIZE_PX = 32
"""Width and height of a picture, in pixels of the game; twice as much for a larger thing."""
MARGIN_PX = 4
"""Least distance of a thing from the edge of a picture of this size."""
DIMMED = 0.4
"""Brightness of what is around the thing."""
MOST_GAMES = 8
"""Varied games in which the kinds are looked for."""


def pictures_of(
    words: Vocabulary, recordings: Sequence[Recording], console: Console
) -> dict[int, bytes]:
    """Return a PNG of each kind of things that some games show, of the pieces and the formation.

    The key is the kind's index, PIECES or FORMATION.

    Args:
        words: The game's vocabulary.
        recordings: The games, looked at until each kind has a picture.
        console: A console of the game.
    """
    pictures: dict[int, bytes] = {}
    for recording in recordings:
        missing = [index for index in range(len(words.kinds)) if index not in pictures]
        if not missing:
            break
        played = trace(recording, console, words.scene)
        shown: dict[int, list[tuple[int, Blobs]]] = defaultdict(list)
        for kind in missing:
            members = played.blobs[words.kinds[kind].members(played.blobs)]
            if len(members):
                blob = _typical(members, words.scene.background.shape)
                shown[int(blob["step"])].append((kind, blob))
        pictures |= _cut(recording, console, shown)
    formation = words.scene.formation
    of_items = None if formation is None else formation.items > 0
    for index, pixels in ((PIECES, words.pieces), (FORMATION, of_items)):
        if pixels is not None:
            game = recordings[0].game
            pictures[index] = _picture_of_pixels(words.scene.beginning, pixels, game)
    return pictures


def write_pictures(path: Path, pictures: dict[int, bytes]) -> None:
    """Write pictures as a zip of PNGs named by their kinds."""
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w") as archive:
        for kind, picture in pictures.items():
            archive.writestr(f"{kind}.png", picture)
    path.parent.mkdir(parents=True, exist_ok=True)
    write_whole(path, file.getvalue())


def pictured_kinds(path: Path) -> frozenset[int]:
    """Return the kinds whose pictures `write_pictures` wrote; none if there is no such file."""
    try:
        with zipfile.ZipFile(path) as archive:
            return frozenset(int(Path(name).stem) for name in archive.namelist())
    except (OSError, zipfile.BadZipFile):
        return frozenset()


def read_picture(path: Path, kind: int) -> bytes | None:
    """Return the PNG of a kind that `write_pictures` wrote; None if there is none."""
    try:
        with zipfile.ZipFile(path) as archive:
            return archive.read(f"{kind}.png")
    except (OSError, KeyError, zipfile.BadZipFile, zlib.error):
        return None


def _typical(members: Blobs, shape: tuple[int, ...]) -> Blobs:
    """Return the blob of the most usual size that lies far enough from the screen's edges."""
    edge_px = np.minimum.reduce(
        [members["x"], members["y"], shape[1] - members["x"], shape[0] - members["y"]]
    )
    distance = np.abs(members["area"] - np.median(members["area"]))
    typical: Blobs = members[np.lexsort((distance, edge_px < SIZE_PX / 2))[0]]
    return typical


def _cut(
    recording: Recording, console: Console, shown: dict[int, list[tuple[int, Blobs]]]
) -> dict[int, bytes]:
    """Replay a recording and return the pictures of what it shows after some steps."""
    game, per_step = recording.game, recording.game.clock.frames_per_step
    pictures: dict[int, bytes] = {}
    amount: dict[int, int] = {}

    def look(episode: Episode) -> None:
        left = -episode.frame % per_step
        step = (episode.frame + left) // per_step - 1
        # What flickers is on one of a step's last two frames.
        if left > 1 or step not in shown:
            return
        screen = console.screen()
        for kind, blob in shown[step]:
            box = _box(blob)
            n_pixels = int((colours_of(screen, game)[box] == blob["colour"]).sum())
            if n_pixels > amount.get(kind, 0):
                amount[kind] = n_pixels
                pictures[kind] = _png(_rgb(screen, game), box)

    replay(recording, console, look)
    return pictures


def _box(blob: Blobs) -> tuple[slice, slice]:
    left, top = (int(place) for place in box_of(blob))
    return slice(top, top + int(blob["height"])), slice(left, left + int(blob["width"]))


def _rgb(screen: Screen, game: Game) -> Screen:
    palette = game.screen.palette
    rgb: Screen = screen if palette is None else palette[screen]
    return rgb


def lit(colours: Screen, pieces: Mask, game: Game) -> Screen:
    """Return a screen on which all but the pieces is dimmed, uint8 (height, width, 3).

    Args:
        colours: Colour numbers of the screen, uint8 (height, width).
        pieces: Which pixels are pieces, bool (height, width).
        game: The game.
    """
    rgb = np.rint(rgb_of(colours, game))
    shown: Screen = np.where(pieces[..., None], rgb, rgb * DIMMED).astype(np.uint8)
    return shown


def _picture_of_pixels(colours: Screen, lit_pixels: Mask, game: Game) -> bytes:
    """Return a PNG of the part of a screen in which pixels are lit, at least SIZE_PX each way."""
    parts: list[slice] = []
    for axis, length in enumerate(lit_pixels.shape):
        covered = np.flatnonzero(lit_pixels.any(1 - axis))
        extent = slice(int(covered[0]), int(covered[-1]) + 1)
        parts.append(_around(extent, max(SIZE_PX, extent.stop - extent.start), length))
    file = io.BytesIO()
    Image.fromarray(lit(colours, lit_pixels, game)[tuple(parts)]).save(file, "PNG", optimize=True)
    return file.getvalue()


def _png(rgb: Screen, box: tuple[slice, slice]) -> bytes:
    picture = (rgb * DIMMED).astype(np.uint8)
    picture[box] = rgb[box]
    longest = max(extent.stop - extent.start for extent in box)
    size_px = SIZE_PX if longest + 2 * MARGIN_PX <= SIZE_PX else 2 * SIZE_PX
    parts = tuple(
        _around(extent, size_px, length) for extent, length in zip(box, rgb.shape, strict=False)
    )
    file = io.BytesIO()
    Image.fromarray(picture[parts]).save(file, "PNG", optimize=True)
    return file.getvalue()


def _around(extent: slice, size_px: int, length: int) -> slice:
    """Return a slice of a size around an extent, within a length; all of it if that is shorter."""
    size = min(length, size_px)
    begin = (extent.start + extent.stop - size) // 2
    begin = min(max(begin, 0), length - size)
    return slice(begin, begin + size)
