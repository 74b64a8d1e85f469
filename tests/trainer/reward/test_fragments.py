import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from trainer.reward.fragments import Fragmenter, fragment_returns, preference_pairs
from tril.errors import Invalid


@given(
    sizes=st.lists(st.integers(1, 301), min_size=2, max_size=6),
    shortest=st.integers(1, 80),
    extra=st.integers(0, 60),
    aligned=st.booleans(),
    seed=st.integers(0, 99),
)
def test_fragments_lie_within_their_games_and_are_equally_long(
    sizes: list[int], shortest: int, extra: int, aligned: bool, seed: int
) -> None:
    pairs = preference_pairs([[i] for i in range(len(sizes))])
    fragmenter = Fragmenter(shortest, shortest + extra, aligned)
    drawn = fragmenter.sample(pairs, sizes, 200, np.random.default_rng(seed))
    size = np.asarray(sizes)
    assert (drawn.better < drawn.worse).all()
    assert (drawn.length >= 1).all()
    assert (drawn.length <= fragmenter.max_length).all()
    assert (drawn.worse_start >= 0).all()
    assert (drawn.better_start + drawn.length <= size[drawn.better]).all()
    assert (drawn.worse_start + drawn.length <= size[drawn.worse]).all()
    shorter = np.minimum(size[drawn.better], size[drawn.worse])
    assert (drawn.length >= np.minimum(shortest, shorter)).all()
    if aligned:
        assert (drawn.better_start == drawn.worse_start).all()
    else:
        assert (drawn.better_start >= drawn.worse_start).all()


def test_a_short_game_limits_its_own_pairs_only() -> None:
    fragmenter = Fragmenter(50, 100, aligned=True)
    pairs = preference_pairs([[0], [1], [2]])
    drawn = fragmenter.sample(pairs, [301, 20, 301], 2000, np.random.default_rng(0))
    with_short = (drawn.better == 1) | (drawn.worse == 1)
    assert set(drawn.length[with_short]) == {20}
    assert drawn.length[~with_short].min() >= 50
    assert drawn.length[~with_short].max() == 100


def test_tied_games_form_no_pair() -> None:
    assert preference_pairs([[4], [1, 2], [0]]) == [(4, 1), (4, 2), (4, 0), (1, 0), (2, 0)]


def test_one_tier_teaches_nothing() -> None:
    with pytest.raises(Invalid, match="at least two tiers"):
        preference_pairs([[0, 1, 2]])


def test_fragment_returns_are_sums() -> None:
    rewards = np.arange(10, dtype=np.float32)
    returns = fragment_returns(rewards, np.array([0, 3, 9]), np.array([10, 2, 1]))
    assert returns.tolist() == [45.0, 7.0, 9.0]
