"""The games that players of the benchmark's behaviours played, and their facts."""

from __future__ import annotations

import hashlib
import json
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from benchmarks.learning.behaviours import suite
from benchmarks.learning.behaviours.suite import TASKS, Task
from tril.games import game_named
from tril.games.base import Game, Start
from tril.recording import Recording, replay
from tril.vocabulary.facts import Vocabulary
from tril.vocabulary.making import vocabulary_key, vocabulary_of
from tril.vocabulary.trace import Trace, trace

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class PlayedGames:
    """The games of all behaviours of a game.

    Attributes:
        game: The game.
        words: Its vocabulary.
        tasks: Its behaviours.
        recordings: The games.
        task: Index of the behaviour that each game's player meant, int64 (n_games,).
        is_best: Which games are best efforts, bool (n_games,).
        summaries: Facts of each game, float32 (n_games, n_facts).
        worths: Worth of each game by each behaviour, float64 (n_games, n_tasks).
    """

    game: Game
    words: Vocabulary
    tasks: tuple[Task, ...]
    recordings: tuple[Recording, ...]
    task: npt.NDArray[np.int64]
    is_best: npt.NDArray[np.bool_]
    summaries: npt.NDArray[np.float32]
    worths: Array


def path_of(folder: Path, task: Task) -> Path:
    """Return the file of a behaviour's games."""
    return folder / f"{task.game}-{task.name.replace(' ', '_')}.json"


def tasks_of(half: str, folder: Path, games: Sequence[str] = ()) -> dict[str, tuple[Task, ...]]:
    """Return the behaviours of a half whose games were played, by game.

    Args:
        half: One of `suite.SPLITS`.
        folder: The folder of the games.
        games: Only these; all if empty.
    """
    found: dict[str, list[Task]] = {}
    for task in TASKS:
        is_asked = task.half == half and (not games or task.game in games)
        if is_asked and path_of(folder, task).exists():
            found.setdefault(task.game, []).append(task)
    return {game: tuple(tasks) for game, tasks in found.items()}


def worth_of(task: Task, played: Trace, horizon: int) -> float:
    """Return what a game is worth by a behaviour, as a share of a whole game."""
    return float(worth_by_step(task, played).sum() / horizon)


def worth_by_step(task: Task, played: Trace) -> Array:
    """Return what each step of a game is worth by a behaviour, float64 (n_steps,)."""
    memory = np.concatenate([played.memory[:1], played.memory])
    held = np.concatenate([[0], played.held])
    return task.worth(memory, held)[1:]


def load_games(folder: Path, name: str, tasks: Sequence[Task]) -> PlayedGames:
    """Load the games of a game's behaviours; facts are kept in the folder.

    Args:
        folder: Where `players` wrote them.
        name: Name of the game.
        tasks: The behaviours.
    """
    game = game_named(name)
    words = vocabulary_of(folder, game)
    recordings: list[Recording] = []
    task_of: list[int] = []
    is_best: list[bool] = []
    summaries: list[npt.NDArray[np.float32]] = []
    worths: list[Array] = []
    for index, task in enumerate(tasks):
        path = path_of(folder, task)
        rows = json.loads(path.read_text())
        known = path.with_suffix(f".{_digest(path, vocabulary_key(game), tasks)}.npz")
        if not known.exists():
            _look_at(rows, game, words, tasks, known)
        with np.load(known) as arrays:
            n_frames, of_games = arrays["n_frames"].tolist(), arrays["summaries"]
            worths += list(arrays["worths"])
        for row, frames, summary in zip(rows, n_frames, of_games, strict=True):
            recordings.append(from_row(row, game).until(frames))
            task_of.append(index)
            is_best.append(row["best"])
            summaries.append(summary)
    return PlayedGames(
        game,
        words,
        tuple(tasks),
        tuple(recordings),
        np.array(task_of),
        np.array(is_best),
        np.stack(summaries),
        np.stack(worths),
    )


def to_row(start: Start, actions: bytes) -> dict[str, Any]:
    """Return a game as JSON, which `from_row` reads."""
    return {"start": start.to_json(), "actions": zlib.compress(actions).hex()}


def from_row(row: Mapping[str, Any], game: Game) -> Recording:
    """Return a recording that `to_row` or a player wrote."""
    actions = zlib.decompress(bytes.fromhex(row["actions"]))
    return Recording(game, game.starts.parse(row["start"]), actions)


def _look_at(
    rows: Sequence[dict[str, Any]],
    game: Game,
    words: Vocabulary,
    tasks: Sequence[Task],
    path: Path,
) -> None:
    """Write how long games are, their facts and their worth by each behaviour."""
    console = game.make_console()
    n_frames: list[int] = []
    summaries: list[npt.NDArray[np.float32]] = []
    worths: list[list[float]] = []
    for row in rows:
        recording = from_row(row, game)
        # A player that looks ahead goes on from restored states, which not every game restores to
        # the last bit: what was played after such a state may end earlier.
        n_frames.append(replay(recording, console).n_frames)
        played = trace(recording.until(n_frames[-1]), console, words.scene)
        summaries.append(words.summary(words.facts(played)))
        worths.append([worth_of(one, played, game.clock.max_steps) for one in tasks])
    console.close()
    np.savez_compressed(
        path,
        n_frames=np.array(n_frames),
        summaries=np.stack(summaries),
        worths=np.array(worths, np.float64),
    )


def _digest(path: Path, key: str, tasks: Sequence[Task]) -> str:
    """Return what names the facts of a file's games: 16 hexadecimal digits of BLAKE2b."""
    digest = hashlib.blake2b(path.read_bytes(), digest_size=8)
    digest.update(f"{key} {[task.name for task in tasks]}".encode())
    digest.update(Path(suite.__file__).read_bytes())
    return digest.hexdigest()
