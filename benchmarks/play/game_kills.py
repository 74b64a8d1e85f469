"""Kill the server at random moments of games, and check what is left of them.

    python -m benchmarks.play.game_kills --games 200

Several games at a time are played over real WebSockets with random keys, pauses, rewinds and stops;
at a random moment of the countdown, the game or its end, the server is killed with SIGKILL. Then it
is started again and every game resumed and stopped a little later: it has to resume at the last
saved frame, its recording has to begin with what was saved, and a replay has to verify it. Prints a
table and a JSON line.
"""

from __future__ import annotations

import argparse
import json
import tempfile
import threading
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from websockets.exceptions import WebSocketException

from server.play.wire.protocol import Close, Ended, FrameMessage, Hello, Rewound
from testsupport.databases import corrupt_databases
from testsupport.live import GameClient, join
from testsupport.processes import server_process
from testsupport.space_invaders import Keys
from testsupport.workplace import Workplace, make_workplace
from tril.settings import Settings
from tril.store import games
from tril.store.models import RecordingState, Verification

MOST_LOST_FRAMES = 60
GO_ON_FRAMES = 20
CONNECT_WITHIN_S = 20.0
BROKEN = (WebSocketException, OSError, TimeoutError)
UNLIMITED = {"max_games": 10_000, "max_games_per_player": 10_000}


@dataclass
class Played:
    """A game before the kill.

    Attributes:
        game: The game as the API returned it.
        frame: The last frame received; None while rewinding.
        did: The player's commands.
        has_joined: Set once the page has been greeted.
    """

    game: dict[str, Any]
    frame: int | None = 0
    did: list[str] = field(default_factory=list)
    has_joined: threading.Event = field(default_factory=threading.Event)


@dataclass(frozen=True)
class Saved:
    """A game in the database after the kill."""

    actions: bytes
    is_over: bool


def play_until_killed(settings: Settings, played: Played, rng: np.random.Generator) -> None:
    """Play until the connection breaks, with random keys and commands."""
    try:
        with join(settings, played.game) as player:
            player.begin()
            played.has_joined.set()
            while not isinstance(message := player.next(), Ended):
                player.screens.clear()
                if isinstance(message, FrameMessage):
                    if played.frame is not None:
                        played.frame = message.frame
                    _act(player, played, message.frame, rng)
                elif isinstance(message, Rewound):
                    played.frame = message.frame
    except BROKEN:
        return


def _act(player: GameClient, played: Played, frame: int, rng: np.random.Generator) -> None:
    if frame % 15 == 0:
        player.hold(Keys(int(rng.integers(3))) | Keys.FIRE)
    what = rng.random()
    if what < 0.004:
        played.did.append("pause")
        player.say("pause")
        player.say("go_on")
    elif what < 0.008 and frame > 60:
        played.did.append("rewind")
        played.frame = None
        player.say("rewind")
        time.sleep(float(rng.uniform(0.05, 0.4)))
        player.say("release")
    elif what < 0.011:
        played.did.append("stop")
        player.say("stop")


def read_saved(workplace: Workplace, game_id: str) -> Saved:
    """Read a game as it was last saved."""
    with workplace.database.reading() as session:
        row = games.get(session, game_id)
        return Saved(row.recording.actions, row.ended_at is not None)


def resume(workplace: Workplace, settings: Settings, played: Played, saved: Saved) -> list[str]:
    """Resume and stop a game; returns what is wrong with it."""
    wrong = []
    n_saved = len(saved.actions)
    if played.frame is not None and not saved.is_over and played.frame - n_saved > MOST_LOST_FRAMES:
        wrong.append(f"{played.frame - n_saved} frames were lost")
    with join(settings, played.game) as player:
        if saved.is_over:
            if player.close_code() != Close.GAME_OVER:
                wrong.append("it was over and goes on")
        else:
            # A game saved at its last frame ends at once.
            hello = player.until(Hello)
            if hello.frame != n_saved:
                wrong.append(f"it went on at frame {hello.frame}, saved were {n_saved}")
            player.say("ready")
            stopped = False
            while not isinstance(message := player.next(), Ended):
                is_far = (
                    isinstance(message, FrameMessage) and message.frame >= n_saved + GO_ON_FRAMES
                )
                if is_far and not stopped:
                    player.say("stop")
                    stopped = True
    with workplace.database.reading() as session:
        recording = games.get(session, played.game["id"]).recording
    if not recording.actions.startswith(saved.actions):
        wrong.append("its recording does not begin with what was saved")
    if recording.state == RecordingState.PLAYING:
        wrong.append("it never ended")
    elif recording.verification != Verification.VERIFIED:
        wrong.append(f"it does not verify: {recording.verification_note}")
    return wrong


def kill_once(
    workplace: Workplace, n_games: int, longest_s: float, rng: np.random.Generator
) -> tuple[list[Played], list[Saved], Settings]:
    """Play games until the server is killed; returns them, what was saved, and the settings."""
    with (
        server_process(workplace.settings.data, **UNLIMITED) as server,
        ThreadPoolExecutor(n_games) as threads,
    ):
        played = [Played(server.new_game()) for _ in range(n_games)]
        playing = [
            threads.submit(play_until_killed, server.settings, one, generator)
            for one, generator in zip(played, rng.spawn(n_games), strict=True)
        ]
        for one in played:
            one.has_joined.wait(CONNECT_WITHIN_S)
        time.sleep(float(rng.uniform(0, longest_s)))
        server.process.kill()
        server.process.wait()
        for player in playing:
            player.result()
    return played, [read_saved(workplace, one.game["id"]) for one in played], server.settings


def resume_all(
    workplace: Workplace, port: int, played: Sequence[Played], saved: Sequence[Saved]
) -> list[str]:
    """Restart the server and resume every game; returns what is wrong."""
    with (
        server_process(workplace.settings.data, port=port, **UNLIMITED) as server,
        ThreadPoolExecutor(len(played)) as threads,
    ):
        checks = [
            threads.submit(resume, workplace, server.settings, one, left)
            for one, left in zip(played, saved, strict=True)
        ]
        return [
            f"game {one.game['id']} ({', '.join(one.did) or 'played'}): {what}"
            for one, check in zip(played, checks, strict=True)
            for what in check.result()
        ]


def main() -> None:
    """Kill, resume, and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--games", type=int, default=200)
    parser.add_argument("--at-once", type=int, default=8, help="games on the server at a kill")
    parser.add_argument("--longest", type=float, default=12.0, help="seconds until a kill, at most")
    parser.add_argument("--seed", type=int, default=0, help="of the moments and the keys")
    arguments = parser.parse_args()
    rng = np.random.default_rng(arguments.seed)
    wrong: list[str] = []
    corrupt: list[str] = []
    lost: list[int] = []
    left, kills, saved_frames, over = arguments.games, 0, 0, 0
    began = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="tril-game-kills-") as folder:
        workplace = make_workplace(Path(folder) / "data")
        while left > 0:
            n = min(left, arguments.at_once)
            played, saved, settings = kill_once(workplace, n, arguments.longest, rng)
            corrupt += corrupt_databases(workplace.settings.data)
            for one, found in zip(played, saved, strict=True):
                saved_frames += len(found.actions)
                over += found.is_over
                if one.frame is not None and not found.is_over:
                    lost.append(max(0, one.frame - len(found.actions)))
            wrong += resume_all(workplace, settings.port, played, saved)
            corrupt += corrupt_databases(workplace.settings.data)
            left -= n
            kills += 1
        workplace.database.close()
    figures = {
        "kills": kills,
        "frames_saved_at_kills": saved_frames,
        "over_at_kills": over,
        "frames_lost_p50": float(np.median(lost)) if lost else 0.0,
        "frames_lost_most": max(lost, default=0),
        "wrong": len(wrong),
        "corrupt_databases": len(corrupt),
        "seconds": round(time.monotonic() - began),
    }
    print(f"{arguments.games} games, {arguments.at_once} at a time")
    for name, value in figures.items():
        print(f"{name.replace('_', ' '):<24}{value:>10}")
    for what in wrong + corrupt:
        print(f"  {what}")
    print(json.dumps({"benchmark": "game_kills", **vars(arguments), **figures}))


if __name__ == "__main__":
    main()
