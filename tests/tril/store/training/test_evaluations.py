"""Evaluation games on a migrated database: which were played and what they come to."""

from __future__ import annotations

from collections import Counter

from testsupport.workplace import Workplace
from tril.games.behaviours import Score
from tril.store.training import evaluations
from tril.store.training.evaluations import EvaluationKey

Proposed = tuple[str, int, int | None]
"""Action selection, start number and targets hit."""


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


def proposed(workplace: Workplace, run_id: str, kept_starts: tuple[int, ...]) -> list[Proposed]:
    with workplace.database.reading() as session:
        listed = evaluations.listing(session, run_id)
        games = evaluations.proposed_games(listed, kept_starts, n_targets=6)
    return [(game.action_selection, game.start_number, game.targets) for game in games]


def test_games_that_differ_are_proposed_and_none_of_a_kept_start(workplace: Workplace) -> None:
    run_id = workplace.make_run()
    for number in range(20):
        for how in evaluations.ACTION_SELECTIONS:
            for policy in evaluations.POLICIES:
                # Only one game in ten is bad.
                targets = 0 if number in {7, 17} else 6
                key = EvaluationKey(policy, how, number)
                play(workplace, run_id, key, targets, held_out=True)
    found = proposed(workplace, run_id, kept_starts=(0, 1, 2))
    assert len(set(found)) == evaluations.N_PROPOSED
    assert Counter(how for how, _, _ in found) == {"greedy": 4, "sticky": 4}
    assert Counter(targets for _, _, targets in found)[0] >= 3
    assert [number for _, number, _ in found] == sorted(number for _, number, _ in found)
    assert not {number for _, number, _ in found} & {0, 1, 2}
    assert proposed(workplace, run_id, kept_starts=(0, 1, 2)) == found


def test_sampled_games_with_flaws_are_proposed_beside_perfect_ones_only(
    workplace: Workplace,
) -> None:
    perfect, flawed = workplace.make_run(), workplace.make_run()
    for number in range(10):
        for how in evaluations.ACTION_SELECTIONS:
            targets = 4 if how == "sampled" and number in {0, 4, 5} else 6
            key = EvaluationKey("imitator", how, number)
            play(workplace, perfect, key, targets, held_out=True)
            targets = 5 if how == "sticky" and number == 7 else targets
            play(workplace, flawed, key, targets, held_out=True)
    found = proposed(workplace, perfect, kept_starts=(0, 1, 2))
    assert len(found) == evaluations.N_PROPOSED
    assert {one for one in found if one[0] == "sampled"} == {("sampled", 4, 4), ("sampled", 5, 4)}
    assert {how for how, _, _ in found} == set(evaluations.ACTION_SELECTIONS)
    assert {how for how, _, _ in proposed(workplace, flawed, (0, 1, 2))} == {"greedy", "sticky"}


def test_few_games_are_all_proposed_even_if_their_starts_should_be_kept(
    workplace: Workplace,
) -> None:
    run_id = workplace.make_run()
    for key in (
        EvaluationKey("clone", "greedy", 0),
        EvaluationKey("imitator", "greedy", 0),
        EvaluationKey("imitator", "sampled", 0),
    ):
        play(workplace, run_id, key, 1, held_out=True)
    assert proposed(workplace, run_id, kept_starts=(0,)) == [("greedy", 0, 1)]
    assert proposed(workplace, workplace.make_run(), kept_starts=()) == []


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
