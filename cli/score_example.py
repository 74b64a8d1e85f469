"""Examples in any game: games of varied play, ranked by the game's own score.

The score stands in for a person's order, as in T-REX (Brown et al. 2019, section 5): only the
ranking knows it, learning sees screens.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from rich.table import Table

from cli.output import console
from cli.progress import progress_bar
from cli.workspace import Workspace
from tril.demonstrators.varied import has_player, play_varied
from tril.errors import Invalid
from tril.games.base import Game
from tril.recording import Verified
from tril.store import behaviours, rankings, recordings
from tril.store.models import Source

if TYPE_CHECKING:
    from trainer.reporting.score_results import ScoreResult

MIN_GAMES, MAX_GAMES = 4, 200


def score_example(workspace: Workspace, game: Game, n_games: int, seed: int) -> str:
    """Return the short name of the behaviour with such games, which is made if it is missing.

    Args:
        workspace: The opened data folder.
        game: The game.
        n_games: Number of games, the same ones whenever the seed is.
        seed: Seed of all that is drawn for them.

    Raises:
        Invalid: All of the games have the same score.
    """
    name = f"{game.title} by score ({n_games} games, seed {seed})"
    with workspace.database.reading() as session:
        rows = {row.name: row for row in behaviours.listing(session) if row.game == game.name}
        if name in rows:
            return rows[name].slug
    games = _play(game, n_games, seed)
    games.sort(key=lambda played: played.replay.score, reverse=True)
    scores = [played.replay.score for played in games]
    if scores[0] == scores[-1]:
        raise Invalid(
            f"{describe_games(game, n_games)} all have the score {scores[0]:g}, so that none can be"
            f" ranked above another. Play {game.title} yourself or import games of others (tril"
            " recordings import), rank them, and train on that (tril train)."
        )
    description = f"{describe_games(game, n_games)}, ranked by the game's own score."
    with workspace.database.writing() as session:
        row = behaviours.create(session, name, description, game=game.name)
        tiers: list[list[int]] = []
        for number, played in enumerate(games):
            recording = recordings.add(
                session,
                row.id,
                played.recording,
                played.replay,
                Source.VARIED,
                notes=f"Score {played.replay.score:g}",
            )
            if number and scores[number] == scores[number - 1]:
                tiers[-1].append(recording.id)
            else:
                tiers.append([recording.id])
        rankings.save(session, row.id, 0, tiers, change="example")
        return row.slug


def describe_games(game: Game, n_games: int | None = None) -> str:
    """Describe the games of an example by their player, to begin a sentence."""
    count = "" if n_games is None else f"{n_games} "
    if has_player(game.name):
        return f"{count}games of a scripted player with errors in {game.title}"
    return f"{count}games of random actions in {game.title}"


def print_scores(result: ScoreResult) -> None:
    """Print what the demonstrations and the policies of a run score."""
    title = "Score from held-out starts, with 95% intervals"
    table = Table("games of", title=title, box=None, title_justify="left")
    for heading in ("games", "mean score", "best score"):
        table.add_column(heading, justify="right")
    scores = {"demonstrations": result.demonstrations} | dict(result.policies)
    for name, mean in result.means.items():
        interval = f"{mean.mean:.1f} ({mean.low:.1f} to {mean.high:.1f})"
        table.add_row(name, str(mean.n), interval, f"{max(scores[name]):g}")
    console.print(table)


def _play(game: Game, n_games: int, seed: int) -> list[Verified]:
    console = game.make_console()
    games: dict[tuple[object, bytes], Verified] = {}
    with progress_bar(f"Playing {n_games} games of {game.title}") as progress:
        for number in range(n_games):
            played = play_varied(np.random.default_rng((seed, number)), console)
            # Two games may be alike where few actions make a game.
            games.setdefault((played.recording.start, played.recording.actions), played)
            progress.advance(number + 1, n_games)
    return [*games.values()]
