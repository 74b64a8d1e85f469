"""Players of any behaviour in any game with saved states: they look ahead in the emulator.

    python -m benchmarks.learning.behaviours.players FOLDER [--games pong freeway]

A player decides every fifth of a second, late, by the truth of the behaviour, and now and then at
random. Nothing of it is Tril's: it stands in for a person.
"""

from __future__ import annotations

import argparse
import json
import zlib
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from benchmarks.learning.behaviours.games import path_of, to_row
from benchmarks.learning.behaviours.suite import TASKS, Task
from tril.games import game_named
from tril.games.base import Console, draw_start
from tril.play.episode import Episode

LAG_FRAMES = 8
LOOK_AHEAD_FRAMES = {"breakout": 60, "pong": 40}
"""By game, where it is not that of the others."""
LOOK_AHEAD = 56
HOLD_FRAMES = {"breakout": (3, 9), "pong": (4, 12)}
"""For how many frames an action is held, by game: a ball is followed all the time."""
HOLD = (8, 18)
MAX_OPTIONS = 5
N_PAIRS = 4
HISTORY = 60
"""Steps of the past that a plan is judged with: a patrol depends on where it turned."""
BEST_SKILL = 0.95
MOST_SKILL = 0.9
GUIDE = 0.2
"""How much a guide's step counts beside one that is worth something."""
DEATH = 6.0
"""What a death takes off a plan."""


@dataclass
class Steps:
    """What a game was like after each step; the first entry is its start.

    Attributes:
        memory: The console's memory.
        held: The buttons held, as bits.
    """

    memory: list[npt.NDArray[np.uint8]] = field(default_factory=list)
    held: list[int] = field(default_factory=list)

    def last(self, n_steps: int) -> Steps:
        """Return a copy of the last steps."""
        return Steps(self.memory[-n_steps:], self.held[-n_steps:])

    def worth(self, task: Task) -> npt.NDArray[np.float64]:
        """Return the worth of each step."""
        return task.worth(np.array(self.memory), np.array(self.held))

    def promise(self, task: Task) -> npt.NDArray[np.float64]:
        """Return the worth of each step as a player sees it, with the guide's."""
        worth = self.worth(task)
        if task.guide:
            worth = worth + GUIDE * task.guide(np.array(self.memory), np.array(self.held))
        return worth


class Player:
    """Plays one game.

    Args:
        task: The behaviour.
        console: The console to play on.
        skill: Probability that a decision is a good one, 0 to 1.
        rng: Source of starts and errors.
    """

    def __init__(
        self, task: Task, console: Console, skill: float, rng: np.random.Generator
    ) -> None:
        self._task = task
        self._console = console
        self._controls = console.game.controls
        self._skill = skill
        self._rng = rng
        self.episode = Episode(console, draw_start(console.game.starts, rng))
        self._steps = Steps([np.frombuffer(console.ram_bytes(), np.uint8)], [0])
        self._action = self._controls.noop
        self._hold = HOLD_FRAMES.get(console.game.name, HOLD)
        self._ahead = LOOK_AHEAD_FRAMES.get(console.game.name, LOOK_AHEAD)

    def play(self) -> None:
        """Play to the end."""
        rng = self._rng
        while self.episode.end is None:
            hold, lag = int(rng.integers(*self._hold)), int(rng.integers(2, LAG_FRAMES))
            if rng.random() < self._skill:
                chosen, hold = self._plan(hold, lag)
            else:
                chosen = int(rng.integers(self._controls.n_actions))
                hold *= int(rng.integers(1, 4))
            self._advance(self._action, lag + int(rng.integers(-1, 2)), self._steps)
            self._action = chosen
            self._advance(chosen, hold, self._steps)

    @property
    def worth(self) -> float:
        """Worth of the game as a share of a whole one."""
        max_steps = self._console.game.clock.max_steps
        return float(self._steps.worth(self._task)[1:].sum() / max_steps)

    def _advance(self, action: int, n_frames: int, steps: Steps) -> None:
        per_step = self._console.game.clock.frames_per_step
        for _ in range(n_frames):
            if self.episode.end is not None:
                return
            self.episode.advance(action)
            if self.episode.frame % per_step == 0:
                steps.memory.append(np.frombuffer(self._console.ram_bytes(), np.uint8))
                steps.held.append(self._controls.held[action])

    def _plan(self, hold: int, lag: int) -> tuple[int, int]:
        """Return the action that begins the best plan, and for how many frames it is held."""
        rng, n_actions = self._rng, self._controls.n_actions
        # Plans of two actions: each action alone, then pairs at random.
        plans = [(int(one), hold, int(one)) for one in rng.permutation(n_actions)[:MAX_OPTIONS]]
        for _ in range(N_PAIRS):
            first, second = rng.integers(n_actions, size=2).tolist()
            plans.append((first, int(rng.integers(4, 40)), second))
        state = self.episode.save()
        best, best_value = (self._action, hold), -np.inf
        for first, n_frames, second in plans:
            value = self._value(lag, first, n_frames, second) + rng.normal() * 0.01
            if value > best_value:
                best, best_value = (first, min(n_frames, hold)), value
            self.episode.restore(state)
        return best

    def _value(self, lag: int, first: int, n_frames: int, second: int) -> float:
        seen = self._steps.last(HISTORY)
        n_before = len(seen.memory)
        self._advance(self._action, lag, seen)
        self._advance(first, n_frames, seen)
        self._advance(second, self._ahead - n_frames - lag, seen)
        value = float(seen.promise(self._task)[n_before:].sum())
        is_lost = self.episode.end not in (None, self._console.game.time_end)
        return value - DEATH * is_lost


def play_games(task: Task, n_graded: int, n_best: int) -> list[dict[str, Any]]:
    """Play the games of a behaviour, as their file holds them."""
    rng = np.random.default_rng(zlib.crc32(f"{task.game}-{task.name}".encode()))
    console = game_named(task.game).make_console()
    rows: list[dict[str, Any]] = []
    for index in range(n_graded + n_best):
        is_best = index >= n_graded
        skill = BEST_SKILL if is_best else float(rng.uniform(0, MOST_SKILL))
        player = Player(task, console, skill, rng)
        player.play()
        rows.append(
            {
                "skill": skill,
                "best": is_best,
                **to_row(player.episode.start, player.episode.actions),
                "worth": player.worth,
                "died": player.episode.died,
            }
        )
    console.close()
    return rows


def main() -> None:
    """Play the games of each behaviour that has none in the folder."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--graded", type=int, default=26, help="games of any skill")
    parser.add_argument("--best", type=int, default=10, help="games that show all of it")
    parser.add_argument("--games", nargs="*", default=())
    arguments = parser.parse_args()
    arguments.folder.mkdir(parents=True, exist_ok=True)
    for task in TASKS:
        path = path_of(arguments.folder, task)
        if path.exists() or (arguments.games and task.game not in arguments.games):
            continue
        rows = play_games(task, arguments.graded, arguments.best)
        path.write_text(json.dumps(rows))
        graded = np.array([[row["skill"], row["worth"]] for row in rows if not row["best"]])
        best = [row["worth"] for row in rows if row["best"]]
        print(
            f"{task.game:15} {task.name:22} worth {graded[:, 1].min():.2f} to"
            f" {graded[:, 1].max():.2f}, with skill {np.corrcoef(graded.T)[0, 1]:.2f},"
            f" best efforts {np.mean(best):.2f},"
            f" died {np.mean([row['died'] for row in rows]):.0%}",
            flush=True,
        )


if __name__ == "__main__":
    main()
