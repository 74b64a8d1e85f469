import json
import multiprocessing
from collections.abc import Sequence
from itertools import combinations, pairwise
from pathlib import Path

import numpy as np
import pytest

from scripts.demonstrations import demonstration_object
from testsupport.space_invaders import idle_frames
from tril.demonstrators import (
    Demonstration,
    DemonstrationFailed,
    DemonstrationPlan,
    demonstrate,
    example_plans,
    example_tasks,
    execute,
    rule_violation,
)
from tril.demonstrators.space_invaders.plans import draw_hits
from tril.errors import Invalid
from tril.exchange.formats.recording_object import parse_recording
from tril.games.atari.starts import TRAINING_IDLE_FRAMES, AtariStart
from tril.games.base import Cell
from tril.games.behaviours import Behaviour, score
from tril.games.space_invaders import SPACE_INVADERS
from tril.games.space_invaders.behaviours import BUILT_IN
from tril.games.space_invaders.ends import EndReason
from tril.games.space_invaders.memory import MAX_FRAMES
from tril.recording import verify

DATA = Path(__file__).parents[2] / "data"
BY_SLUG = {behaviour.slug: behaviour for behaviour in BUILT_IN}
WHOLE = ("column-6", "row-1")
"""All twelve are played of the two hardest; of the others the best and the worst."""

# The published description: the columns of the wrong aliens of demonstrations 8 to 12.
WRONG_COLUMNS = {
    "column-1": "2 / 2 / 2,3 / 2,3,4 / 2,3,4",
    "column-2": "1 / 1 / 1,3 / 1,3,4 / 1,3,4",
    "column-3": "2 / 2 / 2,4 / 1,2,4 / 1,2,4",
    "column-4": "3 / 3 / 3,5 / 2,3,5 / 2,3,5",
    "column-5": "4 / 4 / 3,4 / 2,3,4 / 2,3,4",
    "column-6": "5 / 5 / 3,4 / 2,3,4,5 / 2,3,4,5",
}
AMOUNTS = {8: range(1, 2), 9: range(2, 6), 10: range(3, 9), 11: range(5, 10), 12: range(9, 15)}
"""One, several, several, several or even more, many."""


def _behaviour(target: Sequence[Cell], ordered: bool = False) -> Behaviour:
    return Behaviour("own", "Own", "", "space_invaders", tuple(target), ordered)


@pytest.fixture(scope="module")
def rng() -> np.random.Generator:
    return np.random.default_rng(4)


# Plans


@pytest.mark.parametrize("behaviour", BUILT_IN, ids=lambda behaviour: behaviour.slug)
def test_the_best_six_hit_fewer_and_fewer_targets_and_the_seventh_none(
    behaviour: Behaviour, rng: np.random.Generator
) -> None:
    plans = example_plans(behaviour)
    assert [plan.number for plan in plans] == list(range(1, 13))
    for plan, n_targets in zip(plans[:7], (6, 5, 4, 3, 2, 1, 0), strict=True):
        hits = draw_hits(plan, rng)
        found = score(behaviour, hits)
        assert found is not None
        assert (found.targets, found.strays, found.order_errors) == (n_targets, 0, 0)


@pytest.mark.parametrize(("slug", "published"), WRONG_COLUMNS.items())
def test_the_worst_five_of_a_column_hit_the_published_columns(
    slug: str, published: str, rng: np.random.Generator
) -> None:
    for plan, columns in zip(example_plans(BY_SLUG[slug])[7:], published.split(" / "), strict=True):
        for _ in range(20):
            hits = draw_hits(plan, rng)
            assert {column + 1 for _, column in hits} == {int(c) for c in columns.split(",")}
            assert len(hits) in AMOUNTS[plan.number]


def test_the_worst_five_of_row_1_are_as_published(rng: np.random.Generator) -> None:
    row_1 = BY_SLUG["row-1"]
    for plan in example_plans(row_1)[7:]:
        for _ in range(20):
            hits = draw_hits(plan, rng)
            rows, columns = zip(*hits, strict=True)
            assert len(hits) in AMOUNTS[plan.number]
            found = score(row_1, hits)
            assert found is not None
            if plan.number == 8:
                assert rows == (0,)
                assert columns[0] in (2, 3)
            elif plan.number == 9:
                assert set(rows) == {0}
                assert not {0, 5} & set(columns)
                assert any(later < earlier for earlier, later in pairwise(columns))
                assert found.order_errors
            else:
                assert 0 in rows
                assert found.strays
                assert len(set(rows)) >= (3 if plan.number == 12 else 2)


@pytest.mark.parametrize("behaviour", BUILT_IN, ids=lambda behaviour: behaviour.slug)
def test_drawn_hits_can_be_shot_in_their_order(
    behaviour: Behaviour, rng: np.random.Generator
) -> None:
    for plan in example_plans(behaviour):
        hits = draw_hits(plan, rng)
        for n, (row, column) in enumerate(hits):
            assert {(below, column) for below in range(row)} <= set(hits[:n])


def test_a_violated_rule_is_explained() -> None:
    column_1 = example_plans(BY_SLUG["column-1"])
    column = [(row, 0) for row in range(6)]
    assert rule_violation(column_1[0], column) is None
    assert rule_violation(column_1[0], column[:5]) == "It hits 5 aliens instead of 6."
    assert rule_violation(column_1[1], [*column[:5], (0, 1)]) == (
        "It hits row 1 of column 2, which the plan leaves alone."
    )
    assert rule_violation(column_1[6], []) is None
    assert rule_violation(column_1[6], [(0, 0)]) is not None
    assert rule_violation(column_1[9], [(0, 1), (1, 1), (2, 1), (3, 1), (4, 1)]) == (
        "It hits none of row 1 of column 3, row 2 of column 3, row 3 of column 3,"
        " row 4 of column 3, row 5 of column 3, row 6 of column 3."
    )
    row_1 = example_plans(BY_SLUG["row-1"])
    assert rule_violation(row_1[4], [(0, 0), (0, 1)]) is None
    assert rule_violation(row_1[4], [(0, 1), (0, 0)]) == (
        "It hits row 1 of column 2, row 1 of column 1 instead of"
        " row 1 of column 1, row 1 of column 2, in this order."
    )
    assert rule_violation(row_1[8], [(0, 1), (0, 2), (0, 3)]) == (
        "It hits the aliens from left to right, which the plan rules out."
    )


@pytest.mark.parametrize(
    ("behaviour", "gradual"),
    [
        (_behaviour([(0, 2)]), [1]),
        (_behaviour([(0, 4), (0, 1), (1, 1)]), [3, 2, 1]),
        (_behaviour([(0, 5), (0, 0)], ordered=True), [2, 1]),
        (_behaviour([(0, column) for column in range(6)]), [6, 5, 4, 3, 2, 1]),
        (_behaviour([(r, c) for c in (2, 3) for r in range(6)]), [12, 10, 8, 5, 3, 1]),
        (_behaviour([(r, c) for c in range(6) for r in range(2)]), [12, 10, 8, 5, 3, 1]),
    ],
)
def test_a_persons_own_behaviour_gets_twelve_by_the_same_pattern(
    behaviour: Behaviour, gradual: list[int], rng: np.random.Generator
) -> None:
    plans = example_plans(behaviour)
    assert [plan.number for plan in plans] == list(range(1, 13))
    drawn = [score(behaviour, draw_hits(plan, rng)) for plan in plans]
    found = [each for each in drawn if each is not None]
    n = len(gradual)
    assert [each.targets for each in found[:n]] == gradual
    assert {(each.strays, each.order_errors) for each in found[: n + 1]} == {(0, 0)}
    assert found[n].targets == 0
    assert all(each.strays for each in found[n + 1 :])
    min_hits = [plan.min_hits for plan in plans[n + 1 :]]
    assert min_hits == sorted(min_hits)
    assert min_hits[-1] >= 11


@pytest.mark.parametrize(
    ("behaviour", "why"),
    [
        (Behaviour("still", "Stay left", "", "space_invaders"), "Stay left has no target aliens"),
        (_behaviour([(1, 2)]), "row 2 of column 3 of Own stands behind aliens"),
        (_behaviour([(1, 0), (0, 0)], ordered=True), "in order from the bottom"),
        (_behaviour([(r, c) for r in range(3) for c in range(5)]), "has 15 target aliens"),
    ],
)
def test_what_no_player_could_show_is_refused(behaviour: Behaviour, why: str) -> None:
    with pytest.raises(Invalid, match=why):
        example_plans(behaviour)


# Games


@pytest.fixture(scope="module")
def games() -> dict[str, list[Demonstration]]:
    """Of each behaviour: the demonstrations to rank (see WHOLE), then a perfect one."""
    rng = np.random.default_rng(1)
    tasks = {slug: example_tasks(behaviour, rng, 1) for slug, behaviour in BY_SLUG.items()}
    chosen = {
        slug: made if slug in WHOLE else [made[0], *made[11:]] for slug, made in tasks.items()
    }
    played = execute([task for part in chosen.values() for task in part], n_processes=2)
    return {slug: [next(played) for _ in part] for slug, part in chosen.items()}


@pytest.mark.parametrize("slug", BY_SLUG)
def test_every_demonstration_meets_its_plan_and_lives_for_300_steps(
    games: dict[str, list[Demonstration]], slug: str
) -> None:
    console = SPACE_INVADERS.make_console()
    expected = list(range(1, 13)) if slug in WHOLE else [1, 12]
    assert [made.plan.number for made in games[slug]] == [*expected, 1]
    assert [made.perfect for made in games[slug]] == [False] * len(expected) + [True]
    for made in games[slug]:
        verified = verify(made.recording, console=console)
        assert verified.recording == made.recording
        assert verified.replay == made.replay
        assert made.replay.end == EndReason.STEPS
        assert made.replay.n_frames == MAX_FRAMES
        cells = [hit.cell for hit in made.replay.taken]
        assert rule_violation(made.plan, cells) is None
        assert idle_frames(made.recording.start) in TRAINING_IDLE_FRAMES
        # A step is one action, as an agent's is.
        actions = np.frombuffer(made.recording.actions, np.uint8).reshape(-1, 4)
        assert (actions == actions[:, :1]).all()


@pytest.mark.parametrize("slug", BY_SLUG)
def test_perfect_demonstrations_are_perfect_and_different_games(
    games: dict[str, list[Demonstration]], slug: str
) -> None:
    perfect = [made for made in games[slug] if made.plan.number == 1]
    for made in perfect:
        found = score(BY_SLUG[slug], tuple(hit.cell for hit in made.replay.taken))
        assert found is not None
        assert (found.targets, found.strays, found.order_errors) == (6, 0, 0)
    assert len({made.recording.start for made in games[slug]}) == len(games[slug])
    for one, other in combinations([made.recording.actions for made in perfect], 2):
        assert np.mean(np.frombuffer(one, np.uint8) == np.frombuffer(other, np.uint8)) < 0.95


@pytest.mark.parametrize("slug", ["column-1", "column-2"])
def test_the_demonstrations_for_tests_are_what_the_demonstrator_makes(slug: str) -> None:
    stored = [json.loads(line) for line in (DATA / f"{slug}.jsonl").read_text().splitlines()]
    assert [each.get("tier") for each in stored] == [*range(1, 13), None, None, None]
    tasks = example_tasks(BY_SLUG[slug], np.random.default_rng(0), 3)
    again = [demonstration_object(made) for made in execute([tasks[2], tasks[14]])]
    # What is stored is in version 1 of the format.
    assert [parse_recording(one) for one in again] == [
        parse_recording(one) for one in (stored[2], stored[14])
    ]


def test_the_same_generator_gives_the_same_games_and_another_gives_others(
    games: dict[str, list[Demonstration]],
) -> None:
    # The fixture's games were played in other processes; its generator is drawn from in turn.
    rng = np.random.default_rng(1)
    tasks = {slug: example_tasks(behaviour, rng, 1) for slug, behaviour in BY_SLUG.items()}
    assert list(execute([tasks["column-3"][11], tasks["column-3"][12]])) == games["column-3"][1:3]
    others = example_tasks(BY_SLUG["column-3"], np.random.default_rng(2), 2)
    assert list(execute([others[12]])) != games["column-3"][2:3]


def test_an_example_can_be_stopped_between_two_demonstrations() -> None:
    example = execute(example_tasks(BY_SLUG["row-1"], np.random.default_rng(0)), n_processes=2)
    assert next(example).plan.number == 1
    example.close()  # type: ignore[attr-defined]
    assert multiprocessing.active_children() == []


def test_a_failed_demonstration_is_explained() -> None:
    twice = ((0, 0), (0, 0))
    impossible = DemonstrationPlan(1, "One alien twice", frozenset(twice), 2, 2, sequence=twice)
    with pytest.raises(DemonstrationFailed, match="hits 1 aliens instead of 2"):
        demonstrate(impossible, AtariStart(0), np.random.default_rng(0))


def test_an_own_behaviour_is_shown_from_best_to_worst() -> None:
    behaviour = _behaviour([(0, 3), (0, 1)], ordered=True)
    tasks = example_tasks(behaviour, np.random.default_rng(0), 1)
    best, worst, perfect = execute([tasks[0], tasks[11], tasks[12]])
    assert [hit.cell for hit in best.replay.taken] == [(0, 3), (0, 1)]
    assert len(worst.replay.taken) >= 11
    assert perfect.perfect
    assert demonstration_object(perfect)["perfect"]
    assert demonstration_object(best)["tier"] == 1
