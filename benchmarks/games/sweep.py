"""Every game: does it start, play by keys, record, replay and yield observations, and at what cost?

    python -m benchmarks.games.sweep                  # all games of the catalogue, a table
    python -m benchmarks.games.sweep pong gym:CartPole-v1 --json

Each game is played for ten seconds by buttons that a person could hold, its screens pass the
codec, and the recording is verified on a fresh console. Starts are compared by what follows the
same actions: two starts that lead to the same screens are one. A game that fails has the reason in
its row; the exit status says whether all that the catalogue names passed.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass

import numpy as np

from server.play.wire.codec import FrameEncoder
from testsupport.protocol import FrameDecoder
from tril.errors import TrilError
from tril.games import game_named, game_titles
from tril.games.base import Console, Game, spread_starts
from tril.play.episode import Episode
from tril.play.observation import OBSERVATION_SHAPE, AgentView
from tril.recording import Recorder, verify

PLAYED_S = 10
LONGEST_HOLD = 24
N_STARTS = 8
HEAD = (
    "game",
    "load ms",
    "actions",
    "frames",
    "end",
    "us/frame",
    "bytes/frame",
    "starts",
    "hidden",
)


@dataclass(frozen=True)
class Row:
    """A game in the table.

    Attributes:
        game: Its name.
        problem: Why it can't be taught, or what differed; "" if nothing did.
        load_ms: From nothing to a console with a first frame.
        actions: Number of actions.
        frames: Frames played until the end or ten seconds.
        end: How it ended, None if it went on.
        frame_us: Time of one frame with its observation, without the codec.
        frame_bytes: Size of a frame on the wire, on average.
        starts: Different games among so many starts, of N_STARTS.
        hidden: Areas hidden from learning.
        score: What the game paid.
    """

    game: str
    problem: str = ""
    load_ms: float = 0.0
    actions: int = 0
    frames: int = 0
    end: str | None = None
    frame_us: float = 0.0
    frame_bytes: float = 0.0
    starts: int = 0
    hidden: int = 0
    score: float = 0.0


def row_of(name: str) -> Row:
    """Play a game and return its row."""
    try:
        game = game_named(name)
        began = time.perf_counter()
        console = game.make_console()
        console.start(game.starts.training[0])
        console.screen()
        load_ms = 1e3 * (time.perf_counter() - began)
        return _played(game, console, load_ms)
    except TrilError as refusal:
        return Row(name, problem=str(refusal))


def _played(game: Game, console: Console, load_ms: float) -> Row:
    actions = held_actions(game, PLAYED_S)
    recorder = Recorder(Episode(console, game.starts.training[0]))
    view = AgentView(game)
    view.reset(console)
    encoder, decoder = FrameEncoder(game.screen.shape), FrameDecoder(game.screen.shape)
    observation = np.empty(OBSERVATION_SHAPE, np.uint8)
    stepping = 0.0
    sizes = []
    problem = ""
    for action in actions:
        began = time.perf_counter()
        recorder.advance(action)
        view.update(console, recorder.episode.frame)
        if recorder.episode.frame % game.clock.frames_per_step == 0:
            view.observe(observation)
        stepping += time.perf_counter() - began
        screen = console.screen()
        encoded = encoder.encode(screen)
        sizes.append(len(encoded.payload))
        if not np.array_equal(decoder.decode(encoded), screen):
            problem = "the codec changes its screens"
        if recorder.episode.end is not None:
            break
    verified = verify(recorder.recording(), None, game.make_console())
    if verified.replay != recorder.replay():
        problem = "its replay differs"
    return Row(
        game.name,
        problem,
        round(load_ms),
        game.controls.n_actions,
        recorder.episode.frame,
        recorder.episode.end,
        round(1e6 * stepping / len(sizes)),
        round(float(np.mean(sizes))),
        n_different_starts(game, console),
        len(game.screen.hidden),
        recorder.episode.score,
    )


def held_actions(game: Game, seconds: float, seed: int = 0) -> list[int]:
    """Return the actions of random buttons, each combination held for a while."""
    rng = np.random.default_rng(seed)
    actions: list[int] = []
    while len(actions) < seconds * game.clock.frame_rate_hz:
        held = int(rng.choice(game.controls.held))
        action = game.controls.action_for(held)
        actions += [action] * int(rng.integers(1, LONGEST_HOLD))
    return actions[: round(seconds * game.clock.frame_rate_hz)]


def n_different_starts(game: Game, console: Console) -> int:
    """Return how many of N_STARTS starts lead to different screens, for the same actions."""
    actions = held_actions(game, 2)
    seen = set()
    for start in spread_starts(game.starts.training, N_STARTS):
        episode = Episode(console, start)
        screens = []
        for action in actions:
            if episode.end is not None:
                break
            episode.advance(action)
            if episode.frame % game.clock.frames_per_step == 0:
                screens.append(console.screen().tobytes())
        seen.add(b"".join(screens[len(screens) // 2 :]))
    return len(seen)


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the table, or one JSON object per game."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("games", nargs="*", help="names; all of the catalogue without any")
    parser.add_argument("--json", action="store_true", help="print one object per game")
    options = parser.parse_args(arguments)
    rows = []
    if not options.json:
        print(f"| {' | '.join(HEAD)} |")
        print("|---" * len(HEAD) + "|")
    for name in options.games or game_titles():
        row = row_of(name)
        rows.append(row)
        if options.json:
            print(json.dumps(asdict(row)), flush=True)
        elif row.problem:
            print(f"| {row.game} | {row.problem} | | | | | | | |", flush=True)
        else:
            print(
                f"| {row.game} | {row.load_ms:.0f} | {row.actions} | {row.frames} |"
                f" {row.end or ''} | {row.frame_us:.0f} | {row.frame_bytes:.0f} |"
                f" {row.starts} | {row.hidden} |",
                flush=True,
            )
    return 1 if any(row.problem for row in rows) else 0


if __name__ == "__main__":
    sys.exit(main())
