"""Evaluation games on a migrated database: which were played and what they come to."""

from __future__ import annotations

from testsupport.workplace import Workplace
from tril.games.behaviours import Score
from tril.store.training import evaluations
from tril.store.training.evaluations import EvaluationKey


def play(
    workplace: Workplace, run_id: str, key: EvaluationKey, targets: int, held_out: bool
) -> None:
    with workplace.database.writing() as session:
        score = Score(targets, 0, 0)
        evaluations.add(session, run_id, key, workplace.ranked[0], held_out, 1.0, 0.5, score)


def test_means_are_over_held_out_starts_by_policy_and_action_selection(
    workplace: Workplace,
) -> None:
    run_id = workplace.make_run()
    play(workplace, run_id, EvaluationKey("clone", "sticky", 0), 1, held_out=True)
    play(workplace, run_id, EvaluationKey("imitator", "sticky", 0), 2, held_out=True)
    play(workplace, run_id, EvaluationKey("imitator", "sticky", 1), 4, held_out=True)
    play(workplace, run_id, EvaluationKey("imitator", "sticky", 2), 6, held_out=False)
    play(workplace, run_id, EvaluationKey("imitator", "greedy", 0), 5, held_out=True)
    with workplace.database.reading() as session:
        found = evaluations.summaries(evaluations.listing(session, run_id), n_targets=4)
    # No sampled games, as in runs of earlier versions.
    assert list(found) == [("imitator", "greedy"), ("imitator", "sticky"), ("clone", "sticky")]
    sticky = found["imitator", "sticky"].targets
    assert sticky is not None
    assert (sticky.mean, sticky.n) == (3.0, 2)
    perfect = found["imitator", "sticky"].perfect
    assert perfect is not None
    assert perfect.mean == 0.5


def test_each_action_selection_is_a_game_of_its_own(workplace: Workplace) -> None:
    run_id = workplace.make_run()
    keys = {
        EvaluationKey("imitator", action_selection, 0)
        for action_selection in evaluations.ACTION_SELECTIONS
    }
    for key in keys:
        play(workplace, run_id, key, 1, held_out=True)
    with workplace.database.reading() as session:
        assert evaluations.played(session, run_id) == keys
