"""Which of an imitator's games are proposed for the ranking."""

from __future__ import annotations

from collections import Counter

from testsupport.workplace import Workplace
from tril.analysis.variety import N_PROPOSED
from tril.games.behaviours import Score
from tril.games.space_invaders.behaviours import BUILT_IN
from tril.store.training import evaluations
from tril.store.training.evaluations import EvaluationKey
from tril.teaching.proposals import pick_training_games, proposed_games

COLUMN_1 = next(behaviour for behaviour in BUILT_IN if behaviour.slug == "column-1")

Proposed = tuple[str, int, int | None]
"""Action selection, start number and targets hit."""


def play(workplace: Workplace, run_id: str, key: EvaluationKey, targets: int) -> None:
    with workplace.database.writing() as session:
        score = Score(targets, 0, 0)
        evaluations.add(session, run_id, key, workplace.ranked[0], True, 1.0, 0.5, score)


def proposed(workplace: Workplace, run_id: str, kept_starts: tuple[int, ...]) -> list[Proposed]:
    with workplace.database.reading() as session:
        listed = evaluations.listing(session, run_id)
        games = proposed_games(listed, kept_starts, n_targets=6)
    return [(game.action_selection, game.start_number, game.targets) for game in games]


def test_games_that_differ_are_proposed_and_none_of_a_kept_start(workplace: Workplace) -> None:
    run_id = workplace.make_run()
    for number in range(20):
        for how in evaluations.ACTION_SELECTIONS:
            for policy in evaluations.POLICIES:
                # Only one game in ten is bad.
                targets = 0 if number in {7, 17} else 6
                key = EvaluationKey(policy, how, number)
                play(workplace, run_id, key, targets)
    found = proposed(workplace, run_id, kept_starts=(0, 1, 2))
    assert len(set(found)) == N_PROPOSED
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
            play(workplace, perfect, key, targets)
            targets = 5 if how == "sticky" and number == 7 else targets
            play(workplace, flawed, key, targets)
    found = proposed(workplace, perfect, kept_starts=(0, 1, 2))
    assert len(found) == N_PROPOSED
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
        play(workplace, run_id, key, 1)
    assert proposed(workplace, run_id, kept_starts=(0,)) == [("greedy", 0, 1)]
    assert proposed(workplace, workplace.make_run(), kept_starts=()) == []


def test_few_games_are_kept_and_of_every_kind() -> None:
    good = tuple((row, 0) for row in range(6))
    games = [(good, False)] * 20 + [((), True), (((0, 3),), False)]
    picked = pick_training_games(COLUMN_1, games)
    assert len(picked) == N_PROPOSED
    assert {20, 21} <= set(picked)
    assert picked == pick_training_games(COLUMN_1, games) == sorted(picked)
    assert pick_training_games(COLUMN_1, games[:3]) == [0, 1, 2]
