"""A run's page of Markdown, written from its rows."""

from __future__ import annotations

from tests.trainings import DEMONSTRATED, HACKS, HONEST, Training, checked
from testsupport.workplace import TINY, Workplace
from trainer.reporting.run_report import write_report
from tril.files.artifact_store import ArtifactStore
from tril.games.behaviours import Score
from tril.store import behaviours, recordings
from tril.store.training import evaluations, metrics, runs
from tril.store.training.evaluations import ACTION_SELECTIONS as HOW
from tril.store.training.evaluations import EvaluationKey

WARNED = "The reward model can\u2019t tell these tiers apart: 3 and 4."


def page_of(workplace: Workplace, training: Training, warning: str | None = WARNED) -> str:
    """Write the page of a run that went like a training; returns its text."""
    run_id = workplace.make_run(TINY)
    returns = dict(zip(workplace.ranked, sorted(DEMONSTRATED[::2], reverse=True), strict=False))
    # Those of earlier versions have no warning.
    said = {} if warning is None else {"warning": warning}
    curves = training.curves()
    with workplace.database.writing() as session:
        runs.get(session, run_id).outcome = checked(returns, held_out_accuracy=0.97, **said)
        played = recordings.by_ids(session, workplace.ranked)
        for number, how, targets in zip(workplace.ranked, HOW, (5, 4, 2), strict=False):
            key = EvaluationKey("imitator", how, 0)
            played[number].taken = [[0, 1, 60], *([row, 0, 90] for row in range(targets))]
            evaluations.add(session, run_id, key, number, True, 640.0, 0.5, Score(targets, 1, 0))
        for place, (step, _) in enumerate(curves["hits"]):
            values = {name: points[place][1] for name, points in curves.items()}
            metrics.add(session, run_id, "imitator", step, values)
    folder = workplace.settings.data / "page"
    store = ArtifactStore(workplace.settings.artifact_root)
    page = write_report(workplace.database, store, run_id, folder).read_text()
    assert ("extrapolation.png" in page) == (folder / "extrapolation.png").exists()
    return page


def test_the_page_warns_of_a_return_that_rises_alone_and_of_tiers_that_are_not_told_apart(
    workplace: Workplace,
) -> None:
    page = page_of(workplace, HACKS["all the time"])
    assert "> **Alarm.** The learned reward may be rewarding something other" in page
    assert f"> **Warning.** {WARNED}" in page
    calm = page_of(workplace, HONEST["both rise"], warning="")
    assert "Alarm" not in calm
    assert "Warning" not in calm
    assert "Warning" not in page_of(workplace, HONEST["both rise"], warning=None)


def test_the_page_has_a_line_for_every_action_selection_and_what_games_were_worth(
    workplace: Workplace,
) -> None:
    page = page_of(workplace, HONEST["both rise"])
    lines = [line.split(" | ")[:4] for line in page.splitlines() if line.startswith("| imitator")]
    assert lines[:3] == [
        ["| imitator", "greedy", "1", "5.00 [5.00, 5.00]"],
        ["| imitator", "sampled", "1", "4.00 [4.00, 4.00]"],
        ["| imitator", "sticky", "1", "2.00 [2.00, 2.00]"],
    ]
    assert "5/6 targets, 1 stray, alive" in page
    assert "| imitator | no | 3 | 1 to 4 | 640.0 to 640.0 |" in page
    assert "| demonstrator | yes | 3 |" in page


def test_the_page_names_the_run_whose_imitator_was_trained_further(workplace: Workplace) -> None:
    assert "PPO began with" not in page_of(workplace, HONEST["both rise"])
    parent, child = workplace.make_run(), workplace.make_run()
    with workplace.database.writing() as session:
        runs.get(session, child).parent_run_id = parent
    store = ArtifactStore(workplace.settings.artifact_root)
    page = write_report(workplace.database, store, child, workplace.settings.data / "child")
    assert f"PPO began with the imitator of run `{parent}`." in page.read_text()


def test_without_targets_no_game_has_a_worth(workplace: Workplace) -> None:
    with workplace.database.writing() as session:
        behaviours.get(session, workplace.behaviour_id).target = None
    page = page_of(workplace, HACKS["all the time"])
    assert "worth" not in page
    assert "Alarm" not in page
