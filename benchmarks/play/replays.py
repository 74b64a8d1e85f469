"""Record many games, replay them in other processes, and count those that verify.

    python -m benchmarks.play.replays --games 1000

Half of the games are played with random keys, half by the person-like scripted player, of all
behaviours in turn. Each is written in the exchange format with its hits and a RAM hash per second,
and read and replayed by a fresh process. As a control, every game that hit something is replayed
once more without the keys of the second before its first hit, which has to fail. Prints a table and
a JSON line.
"""

from __future__ import annotations

import argparse
import base64
import json
import time
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from functools import cache
from multiprocessing import get_context
from typing import TypeVar

import numpy as np

from testsupport.space_invaders import Keys, action_for
from tril.cores import core_count
from tril.demonstrators import example_plans
from tril.demonstrators.error_model import HUMAN
from tril.demonstrators.space_invaders.human_like import HumanLikePlayer
from tril.demonstrators.space_invaders.plans import draw_hits
from tril.demonstrators.space_invaders.player import PlayStyle
from tril.exchange.formats.recording_file import dump_recording, load_recording
from tril.games.atari.starts import TRAINING_IDLE_FRAMES, AtariStart
from tril.games.base import Console
from tril.games.space_invaders import SPACE_INVADERS
from tril.games.space_invaders.behaviours import BUILT_IN
from tril.games.space_invaders.memory import Action
from tril.play.consoles import Consoles
from tril.play.episode import Episode
from tril.recording import Recorder, RecordingRefused

KEYS_HELD_FRAMES = 20
_In = TypeVar("_In")
_Out = TypeVar("_Out")


@cache
def _console() -> Console:
    return SPACE_INVADERS.make_console()


def record(number: int) -> str:
    """Play a game and return it in the exchange format."""
    rng = np.random.default_rng(number)
    recorder = Recorder(Episode(_console(), AtariStart(int(rng.choice(TRAINING_IDLE_FRAMES)))))
    if number % 2:
        _play_as_a_person(recorder, number // 2, rng)
    else:
        _hold_random_keys(recorder, rng)
    played = recorder.replay()
    return json.dumps(dump_recording(recorder.recording(), taken=played.taken, end=played.end))


def _hold_random_keys(recorder: Recorder, rng: np.random.Generator) -> None:
    keys = Keys.FIRE
    while recorder.episode.end is None:
        if recorder.episode.frame % KEYS_HELD_FRAMES == 0:
            keys = Keys(int(rng.integers(3))) | (Keys.FIRE if rng.random() < 0.7 else Keys(0))
        recorder.advance(action_for(keys))


def _play_as_a_person(recorder: Recorder, number: int, rng: np.random.Generator) -> None:
    behaviour = BUILT_IN[number % len(BUILT_IN)]
    plans = example_plans(behaviour)
    plan = plans[number // len(BUILT_IN) % len(plans)]
    HumanLikePlayer(recorder, draw_hits(plan, rng), PlayStyle(), HUMAN, rng).play()


def replays(line: str) -> int | None:
    """Replay a recording; returns its frames, None if it does not verify."""
    try:
        return load_recording(json.loads(line), Consoles(_console())).recording.n_frames
    except RecordingRefused:
        return None


def without_a_second(line: str) -> str | None:
    """Return a recording without the keys of the second before its first hit.

    None if nothing was hit or no key was held then.
    """
    content = json.loads(line)
    shot = load_recording(content, Consoles(_console())).replay.taken
    if not shot:
        return None
    actions = bytearray(base64.b64decode(content["actions"]))
    last = shot[0].frame
    first = max(0, last - 60)
    if not any(actions[first:last]):
        return None
    actions[first:last] = bytes([Action.NOOP]) * (last - first)
    content["actions"] = base64.b64encode(actions).decode("ascii")
    return json.dumps(content)


def spoiled_replays(line: str) -> tuple[bool, bool]:
    """Return whether a recording could be spoiled, and whether it then verifies."""
    spoiled = without_a_second(line)
    return spoiled is not None, spoiled is not None and replays(spoiled) is not None


def in_fresh_processes(
    work: Callable[[_In], _Out], items: Iterable[_In], n_processes: int
) -> Iterator[_Out]:
    """Map a function over items in spawned processes."""
    with ProcessPoolExecutor(n_processes, mp_context=get_context("spawn")) as pool:
        yield from pool.map(work, items, chunksize=4)


def main() -> None:
    """Record, replay, and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--games", type=int, default=1000)
    parser.add_argument("--processes", type=int, default=core_count())
    arguments = parser.parse_args()
    n = arguments.processes
    lines = list(in_fresh_processes(record, range(arguments.games), n))
    began = time.monotonic()
    found = list(in_fresh_processes(replays, lines, n))
    took_s = time.monotonic() - began
    spoiled = list(in_fresh_processes(spoiled_replays, lines, n))
    frames = sum(one for one in found if one is not None)
    figures = {
        "verified": sum(one is not None for one in found),
        "frames": frames,
        "games_per_s": round(len(found) / took_s, 2),
        "frames_per_s": round(frames / took_s),
        "bytes_per_game": round(sum(map(len, lines)) / len(lines)),
        "spoiled": sum(is_spoiled for is_spoiled, _ in spoiled),
        "spoiled_that_verified": sum(verifies for _, verifies in spoiled),
    }
    print(f"{arguments.games} games, replayed in {n} processes")
    for name, value in figures.items():
        print(f"{name.replace('_', ' '):<24}{value:>12}")
    print(json.dumps({"benchmark": "replays", **vars(arguments), **figures}))


if __name__ == "__main__":
    main()
