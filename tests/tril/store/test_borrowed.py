"""Games that a behaviour borrows from others for its ranking."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from testsupport.workplace import Workplace
from tril.demonstrator import play_randomly
from tril.errors import Conflict, Invalid, NotFound
from tril.game.console import Console
from tril.recording import Verified
from tril.store import behaviours, borrowed, rankings, recordings
from tril.store.borrowed import add_varied_games, pick_evenly
from tril.store.models import BorrowedGameRow, Source, Verification
from tril.store.training import runs

N_OTHERS = 3
COUNT = 8


def games(n: int) -> list[Verified]:
    console = Console()
    return [play_randomly(np.random.default_rng(seed), console) for seed in range(n)]


@pytest.fixture
def others(workplace: Workplace) -> list[int]:
    """Games of column 2, which column 1 may borrow."""
    with workplace.database.writing() as session:
        column_2 = behaviours.by_slug(session, "column-2").id
        return [
            recordings.add(session, column_2, one.recording, one.replay, Source.PERSON).id
            for one in games(N_OTHERS)
        ]


def borrow(workplace: Workplace, ids: list[int]) -> None:
    with workplace.database.writing() as session:
        borrowed.borrow(session, workplace.behaviour_id, ids)


def held(workplace: Workplace) -> list[int]:
    with workplace.database.reading() as session:
        return [row.id for row in borrowed.listing(session, workplace.behaviour_id)]


def rank(workplace: Workplace, tiers: list[list[int]]) -> None:
    with workplace.database.writing() as session:
        newest = rankings.current(session, workplace.behaviour_id)
        rankings.save(session, workplace.behaviour_id, newest.revision, tiers)


def tiers_of(workplace: Workplace) -> list[list[int]]:
    with workplace.database.reading() as session:
        return rankings.current(session, workplace.behaviour_id).tiers


def test_only_borrowed_games_of_others_can_be_ranked(
    workplace: Workplace, others: list[int]
) -> None:
    best, *_ = workplace.ranked
    with pytest.raises(Invalid, match=f"{others[0]} is of another behaviour and not borrowed"):
        rank(workplace, [[best], [others[0]]])
    borrow(workplace, others[:2])
    rank(workplace, [[best], [others[0]]])
    with workplace.database.reading() as session:
        newest = rankings.current(session, workplace.behaviour_id)
        unranked = rankings.unranked(session, newest)
    assert newest.tiers == [[best], [others[0]]]
    assert others[1] in unranked
    assert others[2] not in unranked


def test_a_run_learns_from_borrowed_games_but_clones_only_its_own(
    workplace: Workplace, others: list[int]
) -> None:
    best, *_ = workplace.ranked
    with workplace.database.writing() as session:
        recordings.update(session, recordings.get(session, others[0]), perfect=True)
    borrow(workplace, others)
    rank(workplace, [[best], others])
    with workplace.database.reading() as session:
        frozen = runs.snapshot(session, workplace.behaviour_id)
    assert frozen.tiers == [[best], others]
    assert frozen.perfect == [best]


def test_a_ranked_game_is_not_given_back_and_undo_does_not_bring_a_given_one_back(
    workplace: Workplace, others: list[int]
) -> None:
    best, *_ = workplace.ranked
    borrow(workplace, others[:1])
    rank(workplace, [[best], others[:1]])
    with (
        pytest.raises(Conflict, match="Take it off the board"),
        workplace.database.writing() as session,
    ):
        borrowed.give_back(session, workplace.behaviour_id, others[0])
    rank(workplace, [[best]])
    with workplace.database.writing() as session:
        borrowed.give_back(session, workplace.behaviour_id, others[0])
        newest = rankings.current(session, workplace.behaviour_id)
        undone = rankings.undo(session, workplace.behaviour_id, newest.revision)
        assert undone.tiers == [[best]]
    assert held(workplace) == []
    with pytest.raises(NotFound), workplace.database.writing() as session:
        borrowed.give_back(session, workplace.behaviour_id, others[0])


def test_a_deleted_game_leaves_every_ranking_and_comes_back_unranked(
    workplace: Workplace, others: list[int]
) -> None:
    best, *_ = workplace.ranked
    borrow(workplace, others)
    rank(workplace, [[best], others])
    with workplace.database.writing() as session:
        recordings.delete(session, [recordings.get(session, key) for key in others[:2]], None)
    assert tiers_of(workplace) == [[best], [others[2]]]
    assert held(workplace) == [others[2]]
    with workplace.database.writing() as session:
        recordings.restore(session, recordings.get(session, others[0]))
    assert tiers_of(workplace) == [[best], [others[2]]]
    assert held(workplace) == [others[2], others[0]]


def test_games_of_a_deleted_behaviour_stay_with_their_borrowers_but_are_lent_no_more(
    workplace: Workplace,
) -> None:
    with workplace.database.writing() as session:
        own = behaviours.create(session, "Own").id
        lent, kept = (
            recordings.add(session, own, one.recording, one.replay, Source.PERSON).id
            for one in games(2)
        )
        borrowed.borrow(session, own, list(workplace.ranked))
    borrow(workplace, [lent])
    rank(workplace, [[workplace.ranked[0]], [lent]])
    with workplace.database.writing() as session:
        behaviours.delete(session, behaviours.get(session, own))
        assert session.get(BorrowedGameRow, (own, workplace.ranked[0])) is None
    borrow(workplace, [kept])
    assert held(workplace) == [lent]
    assert tiers_of(workplace) == [[workplace.ranked[0]], [lent]]


def test_half_of_the_varied_games_are_borrowed_while_there_are_enough(
    workplace: Workplace, others: list[int]
) -> None:
    with workplace.database.writing() as session:
        recordings.get(session, others[2]).verification = Verification.FAILED
    played = iter(games(2 * COUNT))
    seeds = []

    def play(seed: int) -> Verified:
        seeds.append(seed)
        return next(played)

    def add(count: int) -> list[int]:
        rng = np.random.default_rng(0)
        return add_varied_games(workplace.database, workplace.behaviour_id, count, play, rng)

    added = add(2)
    assert len(set(added) & set(others[:2])) == 1
    assert set(added + add(COUNT)) >= set(others[:2])
    assert sorted(held(workplace)) == others[:2]
    assert len(seeds) == 2 + COUNT - 2
    with workplace.database.reading() as session:
        library = recordings.listing(session, workplace.behaviour_id)
    made = [row for row in library if row.source == Source.RANDOM]
    assert len(made) == len(seeds)
    assert {row.verification for row in made} == {Verification.VERIFIED}
    assert {row.player_id for row in made} == {None}


@given(
    st.lists(st.tuples(st.integers(0, 3), st.integers(0, 2)), max_size=40),
    st.integers(0, 30),
    st.integers(0, 5),
)
def test_picked_items_are_distinct_and_as_many_as_possible(
    traits: list[tuple[int, int]], count: int, seed: int
) -> None:
    picked = pick_evenly(traits, count, np.random.default_rng(seed))
    assert len(picked) == min(count, len(traits))
    assert len(set(picked)) == len(picked)
    assert set(picked) <= set(range(len(traits)))


def test_a_common_kind_does_not_crowd_out_a_rare_one() -> None:
    traits = [("column-2", "person", 2)] * 50 + [
        (slug, source, length)
        for slug in ("column-2", "column-3", "own")
        for source in ("person", "scripted")
        for length in range(3)
    ]
    picked = pick_evenly(traits, 12, np.random.default_rng(0))
    for place, n_values in enumerate((3, 2, 3)):
        counts = Counter(traits[item][place] for item in picked)
        assert len(counts) == n_values
        assert max(counts.values()) - min(counts.values()) <= 2
    assert picked != pick_evenly(traits, 12, np.random.default_rng(1))
