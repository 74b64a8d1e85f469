"""A run's page: Markdown with pictures, in a folder."""

from __future__ import annotations

from pathlib import Path

from trainer.reporting.figures import (
    COLOURS,
    AliensRow,
    aliens_figure,
    curves_figure,
    extrapolation_figure,
    returns_figure,
)
from trainer.reporting.rendering import render
from trainer.reporting.result_groups import Duel, ResultGroup
from trainer.reporting.run_entry import cells, describe_example, entry_of
from tril.analysis.outcome import AttentionState
from tril.behaviours import score
from tril.files.artifact_store import ArtifactStore, write_whole
from tril.game.agent import STICKY_ACTION_PROBABILITY
from tril.recipes import recipe_from_dict
from tril.store import behaviours, recordings
from tril.store.database import Database
from tril.store.models import RecordingRow
from tril.store.training import artifacts, evaluations, metrics, runs
from tril.store.training.alarms import alarm_of
from tril.store.training.returns import PLAYERS, judged_games

CURVES = {
    "predicted_return": "predicted return",
    "hits": "targets hit",
    "strays": "strays",
    "death_rate": "death rate",
}


def write_report(database: Database, store: ArtifactStore, run_id: str, folder: Path) -> Path:
    """Write ``README.md`` and its pictures into a folder.

    Args:
        database: The application's database.
        store: The artifact store.
        run_id: The run.
        folder: Made if it isn't there; files of the same names are replaced.

    Returns:
        The page's path.

    Raises:
        NotFound: No such run, or its behaviour was deleted.
        Invalid: Its recipe is one of another version.
    """
    with database.reading() as session:
        run = runs.get(session, run_id)
        behaviour = behaviours.as_behaviour(behaviours.get(session, run.behaviour_id))
        result = entry_of(session, run)
        ranked = run.snapshot.ranked if run.snapshot else []
        demonstrations = recordings.by_ids(session, ranked)
        judged = judged_games(session, run, evaluations.listing(session, run_id))
        alarm = alarm_of(session, run)
        curves = metrics.series(session, run_id)[1].get("imitator", {})
        files = artifacts.listing(session, run_id)
    group = ResultGroup(behaviour, (result,))
    duels = group.duels(recipe_from_dict(run.recipe).evaluation.start_numbers)
    pictures = {"aliens.png": _aliens(duels, demonstrations.get(ranked[0]) if ranked else None)}
    if result.check:
        pictures["returns.png"] = returns_figure([(behaviour.name, result)])
    if judged:
        pictures["extrapolation.png"] = extrapolation_figure(judged, "targets hit, less strays")
    # A training in which no game ended has no curves.
    shown = [(label, COLOURS["imitator"], curves[n]) for n, label in CURVES.items() if n in curves]
    if shown:
        pictures["curves.png"] = curves_figure(shown, "steps of training games")
    text = render(
        "run.md.j2",
        behaviour=behaviour,
        result=result,
        sources=sorted({row.source for row in demonstrations.values()}),
        example=describe_example(run.outcome),
        parent_run_id=run.parent_run_id,
        warning=run.outcome.check.warning if run.outcome.check else "",
        duels=duels,
        group=group,
        policies=evaluations.POLICIES,
        action_selections=evaluations.ACTION_SELECTIONS,
        judged=judged,
        alarm=alarm,
        pictures=pictures,
        attention={
            (row.kind, row.details["state"]): row
            for row in files
            if row.kind in ("attention_map", "attention_frame")
        },
        states=list(AttentionState),
        score=score,
        sticky_action_probability=STICKY_ACTION_PROBABILITY,
    )
    pictures |= {r.name: store.get(r.path) for r in files if r.kind.startswith("attention_")}
    for name, content in pictures.items():
        write_whole(folder / name, content)
    page = folder / "README.md"
    write_whole(page, text.encode())
    return page


def _aliens(duels: list[Duel], best: RecordingRow | None) -> bytes:
    columns = [("imitator", "Imitator"), ("clone", "Clone")]
    if best is not None:
        columns.append((PLAYERS[best.source], "Best demonstration"))
    shown = () if best is None else (cells(best),)
    rows = [AliensRow(f"start {one.start}", one.behaviour, (*one.hits, *shown)) for one in duels]
    return aliens_figure(rows, columns)
