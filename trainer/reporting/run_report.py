"""A run's page: Markdown with pictures, in a folder; and what it shows, for other pages."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Protocol

from trainer.reporting.figures import (
    COLOURS,
    MEASURES,
    SCREEN,
    AliensRow,
    PictureForm,
    aliens_figure,
    curves_figure,
    extrapolation_figure,
    returns_figure,
)
from trainer.reporting.rendering import render
from trainer.reporting.result_groups import Duel, ResultGroup
from trainer.reporting.run_entry import cells, describe_example, entry_of
from trainer.reporting.score_results import scores_of
from tril.analysis.outcome import AttentionState
from tril.files.artifact_store import ArtifactStore, write_whole
from tril.games import game_of
from tril.games.behaviours import score
from tril.games.space_invaders import SPACE_INVADERS
from tril.play.agent import STICKY_ACTION_PROBABILITY
from tril.recipes import recipe_from_dict
from tril.store import behaviours, recordings
from tril.store.database import Database
from tril.store.models import RecordingRow
from tril.store.training import artifacts, blind_answers, evaluations, metrics, runs
from tril.store.training.alarms import alarm_of
from tril.store.training.demonstrations import best_demonstration
from tril.store.training.judged_games import PLAYERS, judged_games
from tril.store.training.verdicts import verdict_of

CURVES = {
    "predicted_return": "predicted return",
    "hits": "targets hit",
    "strays": "strays",
    "death_rate": "death rate",
}


class Figure(Protocol):
    """Draws a figure in a format."""

    def __call__(self, *, form: PictureForm) -> bytes:
        """Return the figure's file."""


@dataclass(frozen=True)
class RunReport:
    """What the pages of a run show.

    Attributes:
        view: Variables of their templates, without the pictures.
        figures: Figures by name, in page order.
        attention: The files of the attention maps by name.
    """

    view: dict[str, Any]
    figures: dict[str, Figure]
    attention: dict[str, bytes]


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
        Invalid: The run's recipe belongs to another version.
    """
    report = read_report(database, store, run_id)
    pictures = {f"{name}.png": draw(form=SCREEN) for name, draw in report.figures.items()}
    text = render("run.md.j2", **report.view, pictures=pictures)
    for name, content in (pictures | report.attention).items():
        write_whole(folder / name, content)
    page = folder / "README.md"
    write_whole(page, text.encode())
    return page


def read_report(database: Database, store: ArtifactStore, run_id: str) -> RunReport:
    """Read what the pages of a run show; raises as ``write_report``."""
    with database.reading() as session:
        run = runs.get(session, run_id)
        behaviour = behaviours.as_behaviour(behaviours.get(session, run.behaviour_id))
        result = entry_of(session, run)
        ranked = run.snapshot.ranked if run.snapshot else []
        demonstrations = recordings.by_ids(session, ranked)
        best = best_demonstration(session, run)
        judged = judged_games(session, run, evaluations.listing(session, run_id))
        alarm = alarm_of(session, run)
        verdict = verdict_of(session, run, alarm)
        blind = blind_answers.result_of(session, run_id)
        curves = metrics.series(session, run_id)[1].get("imitator", {})
        files = artifacts.listing(session, run_id)
        # Where the behaviour has targets, they say more.
        scores = scores_of(session, run).means if behaviour.target is None else {}
    game = game_of(behaviour)
    group = ResultGroup(behaviour, (result,))
    duels = group.duels(recipe_from_dict(run.recipe).evaluation.start_numbers)
    figures: dict[str, Figure] = {}
    if behaviour.game == SPACE_INVADERS.name:
        figures["aliens"] = partial(_aliens, duels, best)
    if result.check:
        figures["returns"] = partial(returns_figure, [(behaviour.name, result)])
    if judged:
        quantity = "targets hit, less strays"
        figures["extrapolation"] = partial(extrapolation_figure, judged, quantity)
    # A training in which no game ended has no curves.
    drawn = [(label, COLOURS["imitator"], curves[n]) for n, label in CURVES.items() if n in curves]
    if drawn:
        figures["curves"] = partial(curves_figure, drawn, "steps of training games")
    view = {
        "behaviour": behaviour,
        "result": result,
        "sources": sorted({row.source for row in demonstrations.values()}),
        "example": describe_example(run.outcome),
        "name": run.name,
        "notes": run.notes,
        "parent_run_id": run.parent_run_id,
        "verdict": verdict,
        "blind": "" if blind is None else blind.sentence,
        "warning": run.outcome.check.warning if run.outcome.check else "",
        "game": game,
        "items": game.items,
        "scores": list(scores.items()),
        "duels": duels,
        "group": group,
        "policies": evaluations.POLICIES,
        "action_selections": evaluations.ACTION_SELECTIONS,
        "judged": judged,
        "measure": MEASURES[judged[0].measure] if judged else "",
        "alarm": alarm,
        "attention": {
            (row.kind, row.details["state"]): row
            for row in files
            if row.kind in ("attention_map", "attention_frame")
        },
        "states": list(AttentionState),
        "score": score,
        "sticky_action_probability": STICKY_ACTION_PROBABILITY,
    }
    attention = {r.name: artifacts.read(store, r) for r in files if r.kind.startswith("attention_")}
    return RunReport(view, figures, attention)


def _aliens(duels: list[Duel], best: RecordingRow | None, *, form: PictureForm) -> bytes:
    columns = [("imitator", "Imitator"), ("clone", "Clone")]
    if best is not None:
        columns.append((PLAYERS[best.source], "Best demonstration"))
    demonstrations = () if best is None else (cells(best),)
    rows = [
        AliensRow(f"start {duel.start}", duel.behaviour, (*duel.hits, *demonstrations))
        for duel in duels
    ]
    return aliens_figure(rows, columns, form)
