"""Bytes and microseconds per frame: our codec compared with common encodings.

    python -m benchmarks.play.streaming

The frames are those of games in which a scripted player moves and fires. All encodings get every
frame, alternating by blocks of frames so that other load on the machine affects all alike; reported
are the mean number of bytes and the median over the blocks of the mean time. A second table gives
the lateness of frames with several sessions and their emulators in one process. Prints tables and a
JSON line.
"""

import argparse
import asyncio
import io
import itertools
import json
import statistics
import time
import zlib
from collections.abc import Callable

import numpy as np
from PIL import Image

from benchmarks.play.support import jpeg
from server.play.conditions import PlayConditions
from server.play.consoles import ConsolePool
from server.play.lateness import Lateness
from server.play.rules import PlayRules
from server.play.session.live_game import GameInfo, LiveGame
from server.play.session.session import PlaySession, SessionEvents, SessionResources
from server.play.wire.codec import FrameEncoder
from server.play.wire.connection import Connection
from server.play.wire.protocol import AckMessage, Command, InputMessage
from testsupport.protocol import parse_frame
from testsupport.space_invaders import Keys, action_for
from tril.games.atari.palette import palette_rgb
from tril.games.atari.starts import AtariStart
from tril.games.base import Screen
from tril.games.space_invaders import SPACE_INVADERS
from tril.games.space_invaders.behaviours import BUILT_IN
from tril.games.space_invaders.memory import SCREEN_SHAPE
from tril.play.episode import Episode
from tril.recording import Recorder

BLOCK_FRAMES = 30
Encode = Callable[[Screen], bytes]


def played_frames(n_games: int, n_frames: int) -> list[Screen]:
    """Return the screens of games in which the player moves about and fires."""
    rng = np.random.default_rng(0)
    console = SPACE_INVADERS.make_console()
    screens = []
    for number in range(n_games):
        episode = Episode(console, AtariStart(2 + 3 * number))
        keys = Keys.FIRE
        for frame in range(n_frames):
            if frame % 20 == 0:
                keys = Keys(int(rng.integers(3))) | Keys.FIRE
            episode.advance(action_for(keys))
            screens.append(console.screen())
            if episode.end is not None:
                break
    return screens


def encodings() -> dict[str, Encode]:
    """Return the encodings to compare, ours first."""
    encoder = FrameEncoder(SCREEN_SHAPE)
    palette = palette_rgb().tobytes()

    def png(screen: Screen) -> bytes:
        file = io.BytesIO()
        image = Image.frombuffer("P", screen.shape[::-1], screen.tobytes(), "raw", "P", 0, 1)
        image.putpalette(palette)
        image.save(file, "PNG", compress_level=1)
        return file.getvalue()

    return {
        "XOR with the last frame + zlib 1 (ours)": lambda screen: encoder.encode(screen).payload,
        "zlib 1 of palette values": lambda screen: zlib.compress(screen.tobytes(), 1),
        "zlib 6 of palette values": lambda screen: zlib.compress(screen.tobytes(), 6),
        "PNG with palette": png,
        f"JPEG, quality {jpeg.QUALITY}": jpeg.jpeg,
    }


def compare(screens: list[Screen]) -> list[dict[str, float | str]]:
    """Encode every screen in every way; returns a row per encoding."""
    ways = encodings()
    sizes = dict.fromkeys(ways, 0)
    times: dict[str, list[float]] = {name: [] for name in ways}
    for begin in range(0, len(screens), BLOCK_FRAMES):
        block = screens[begin : begin + BLOCK_FRAMES]
        for name, encode in ways.items():
            began = time.perf_counter()
            encoded = [encode(screen) for screen in block]
            times[name].append((time.perf_counter() - began) / len(block))
            sizes[name] += sum(map(len, encoded))
    return [
        {
            "encoding": name,
            "bytes_per_frame": round(sizes[name] / len(screens), 1),
            "us_per_frame": round(1e6 * statistics.median(times[name]), 1),
        }
        for name in ways
    ]


class ReadingPage:
    """A page in this process that acknowledges every frame at once and records arrival times."""

    def __init__(self) -> None:
        self.connection = Connection(self)
        self.arrived_s: list[float] = []

    async def send_bytes(self, data: bytes) -> None:
        """Acknowledge a frame."""
        self.arrived_s.append(time.perf_counter())
        self.connection.receive(AckMessage(parse_frame(data).sequence))

    async def send_text(self, data: str) -> None:
        """Ignore a message."""

    async def close(self, code: int = 1000, reason: str | None = None) -> None:
        """Ignore a close."""


async def lateness_ms(n_sessions: int, seconds: float) -> list[float]:
    """Play games side by side; returns the lateness of each frame."""

    async def on_event(_session: PlaySession) -> None:
        return None

    async def on_rewind(_session: PlaySession, _frame: int) -> None:
        return None

    resources = SessionResources(ConsolePool(), PlayRules(countdown=0), Lateness())
    pages = [ReadingPage() for _ in range(n_sessions)]
    sessions = []
    for number, page in enumerate(pages):
        recorder = Recorder(Episode(SPACE_INVADERS.make_console(), AtariStart(number)))
        info = GameInfo(str(number), number, BUILT_IN[0])
        game = LiveGame(info, 1, recorder, PlayConditions())
        session = PlaySession(game, resources, SessionEvents(on_rewind, on_event, on_event))
        await session.attach(page.connection)
        page.connection.receive(InputMessage(Keys.RIGHT | Keys.FIRE, 1))
        sessions.append(session)
    for session in sessions:
        await session.handle(Command(type="ready"))
    await asyncio.sleep(seconds)
    late = []
    for page, session in zip(pages, sessions, strict=True):
        await session.shut_down()
        # The earliest frame relative to its deadline defines zero lateness.
        offsets = [1000 * at - 1000 * n / 60 for n, at in enumerate(page.arrived_s[1:])]
        late += [offset - min(offsets) for offset in offsets]
    return late


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--games", type=int, default=4)
    parser.add_argument("--frames", type=int, default=600, help="most frames of a game")
    parser.add_argument("--sessions", type=int, default=8, help="games played side by side")
    parser.add_argument("--seconds", type=float, default=8.0, help="how long they are played")
    arguments = parser.parse_args()
    screens = played_frames(arguments.games, arguments.frames)
    same = sum(np.array_equal(a, b) for a, b in itertools.pairwise(screens))
    rows = compare(screens)
    print(f"{len(screens)} frames, {same / len(screens):.0%} equal to the one before\n")
    print(f"{'encoding':42} {'bytes/frame':>12} {'us/frame':>10}")
    for row in rows:
        print(f"{row['encoding']:42} {row['bytes_per_frame']:12} {row['us_per_frame']:10}")
    late = asyncio.run(lateness_ms(arguments.sessions, arguments.seconds))
    percentiles = {str(p): round(float(np.percentile(late, p)), 2) for p in (50, 99, 100)}
    print(f"\n{arguments.sessions} games in one process: a frame is late by")
    print("  " + ", ".join(f"p{p} {value} ms" for p, value in percentiles.items()))
    print(
        json.dumps(
            {
                "benchmark": "streaming",
                "n_frames": len(screens),
                "encodings": rows,
                "sessions": arguments.sessions,
                "late_ms": percentiles,
            }
        )
    )


if __name__ == "__main__":
    main()
