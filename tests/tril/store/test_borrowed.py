"""Games that a behaviour borrows for its ranking, from others and from policies."""

from __future__ import annotations

import numpy as np
import pytest

from testsupport.workplace import Workplace
from tril.demonstrators import play_randomly
from tril.errors import Conflict, Invalid, NotFound
from tril.games.space_invaders import SPACE_INVADERS
from tril.recording import Verified
from tril.store import behaviours, borrowed, rankings, recordings
from tril.store.models import BorrowedGameRow, Source, Verification
from tril.store.training import runs
from tril.teaching.new_run import freeze_ranking
from tril.teaching.varied_games import add_varied_games

N_OTHERS = 3
COUNT = 8


def games(n: int) -> list[Verified]:
    console = SPACE_INVADERS.make_console()
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
    with pytest.raises(
        Invalid, match="recording 1 of Column 2 is of another behaviour and not borrowed"
    ):
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
        frozen = freeze_ranking(session, workplace.behaviour_id)
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


def test_a_deleted_game_leaves_every_ranking_and_comes_back_into_those_that_may_hold_it(
    workplace: Workplace, others: list[int]
) -> None:
    best, *_ = workplace.ranked
    borrow(workplace, others)
    rank(workplace, [[best], others])
    with workplace.database.writing() as session:
        column_2 = behaviours.by_slug(session, "column-2").id
        rankings.save(session, column_2, 0, [[others[1]], [others[0]]])
    with workplace.database.writing() as session:
        recordings.delete(session, [recordings.get(session, key) for key in others[:2]], None)
    assert tiers_of(workplace) == [[best], [others[2]]]
    assert held(workplace) == [others[2]]
    with workplace.database.writing() as session:
        recordings.restore(session, [recordings.get(session, others[0])])
    assert tiers_of(workplace) == [[best], [others[0], others[2]]]
    assert held(workplace) == [others[2], others[0]]
    with workplace.database.writing() as session:
        assert rankings.current(session, column_2).tiers == [[others[0]]]
        # Given back while it was deleted.
        borrowed.give_back(session, workplace.behaviour_id, others[1])
        recordings.restore(session, [recordings.get(session, others[1])])
        assert rankings.current(session, column_2).tiers == [[others[1]], [others[0]]]
    assert tiers_of(workplace) == [[best], [others[0], others[2]]]


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
        assert session.get(BorrowedGameRow, (own, workplace.ranked[0])) is not None
    with pytest.raises(Conflict, match="recording 2 of Own is of a deleted behaviour"):
        borrow(workplace, [kept])
    assert held(workplace) == [lent]
    assert tiers_of(workplace) == [[workplace.ranked[0]], [lent]]


@pytest.fixture
def run_id(workplace: Workplace) -> str:
    """A run of column 1 that is over."""
    made = workplace.make_run()
    with workplace.database.writing() as session:
        runs.request_cancel(session, made)
    return made


@pytest.fixture
def by_policy(workplace: Workplace, run_id: str) -> list[int]:
    """Games that the run's policies have played."""
    with workplace.database.writing() as session:
        return [
            recordings.add(
                session,
                workplace.behaviour_id,
                one.recording,
                one.replay,
                Source.POLICY,
                run_id=run_id,
            ).id
            for one in games(2)
        ]


def test_a_policys_game_is_ranked_once_it_is_borrowed_by_its_own_behaviour_or_another(
    workplace: Workplace, by_policy: list[int]
) -> None:
    best, *_ = workplace.ranked
    first, second = by_policy
    with pytest.raises(
        Invalid, match=r"recording 1 of run \w+ belongs to a training and is not borrowed"
    ):
        rank(workplace, [[best], [first]])
    borrow(workplace, [first])
    rank(workplace, [[first], [best]])
    borrow(workplace, by_policy)
    assert held(workplace) == [second, first]
    with workplace.database.reading() as session:
        newest = rankings.current(session, workplace.behaviour_id)
        assert rankings.unranked(session, newest)[0] == second
        library = recordings.listing(session, workplace.behaviour_id)
        frozen = freeze_ranking(session, workplace.behaviour_id)
    assert set(by_policy).isdisjoint(row.id for row in library)
    assert (frozen.tiers, frozen.perfect) == ([[first], [best]], [best])
    with workplace.database.writing() as session:
        column_2 = behaviours.by_slug(session, "column-2").id
        borrowed.borrow(session, column_2, by_policy)
        assert rankings.save(session, column_2, 0, [[first]]).tiers == [[first]]


def test_a_deleted_runs_games_stay_with_the_rankings_that_hold_them(
    workplace: Workplace, run_id: str, by_policy: list[int]
) -> None:
    best, *_ = workplace.ranked
    borrow(workplace, by_policy)
    rank(workplace, [by_policy[:1], [best]])
    with workplace.database.writing() as session:
        runs.delete(session, run_id)
    rank(workplace, [[best], by_policy])
    assert held(workplace) == sorted(by_policy, reverse=True)
    with workplace.database.writing() as session:
        newest = rankings.current(session, workplace.behaviour_id)
        assert rankings.undo(session, workplace.behaviour_id, newest.revision).tiers == [
            by_policy[:1],
            [best],
        ]
    frozen = workplace.run(workplace.make_run()).snapshot
    assert frozen is not None
    assert frozen.tiers == [by_policy[:1], [best]]


def test_games_are_borrowed_all_or_none_and_the_reasons_are_named(
    workplace: Workplace, others: list[int], by_policy: list[int]
) -> None:
    own, *_ = workplace.ranked
    deleted, unverified, good = others
    with workplace.database.writing() as session:
        recordings.delete(session, [recordings.get(session, deleted)], None)
        recordings.get(session, unverified).verification = Verification.FAILED
    with pytest.raises(Conflict) as refusal:
        borrow(workplace, [good, own, deleted, unverified, *by_policy])
    assert str(refusal.value) == (
        "Nothing was added to the ranking's games:"
        " recording 1 is in the behaviour's library, so that it can be ranked already,"
        " recording 1 of Column 2 has been deleted, recording 2 of Column 2 is not verified."
    )
    with pytest.raises(NotFound, match="no such recordings: 998, 999"):
        borrow(workplace, [good, 999, 998])
    assert held(workplace) == []


@pytest.mark.usefixtures("by_policy")
def test_no_policys_game_is_among_varied_games(workplace: Workplace) -> None:
    with workplace.database.reading() as session:
        column_2 = behaviours.by_slug(session, "column-2").id
    played = iter(games(4))
    rng = np.random.default_rng(0)
    add_varied_games(workplace.database, column_2, 8, lambda _: next(played), rng)
    with workplace.database.reading() as session:
        lent = [row.id for row in borrowed.listing(session, column_2)]
    assert sorted(lent) == sorted(workplace.ranked)


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
    made = [row for row in library if row.source == Source.VARIED]
    assert len(made) == len(seeds)
    assert {row.verification for row in made} == {Verification.VERIFIED}
    assert {row.player_id for row in made} == {None}
