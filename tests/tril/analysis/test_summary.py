from dataclasses import replace

import pytest

from tril.analysis.summary import GameFigures, summarise, winner

PERFECT = GameFigures(6, 0, 0, 300, died=False, predicted_return=None, n_targets=6)


@pytest.mark.parametrize(
    ("flaw", "perfect"),
    [
        ({}, True),
        ({"targets": 5}, False),
        ({"strays": 1}, False),
        ({"order_errors": 1}, False),
        ({"died": True}, False),
        ({"targets": None, "strays": None, "order_errors": None}, None),
        ({"n_targets": None}, None),
    ],
)
def test_a_perfect_game_has_no_flaw(flaw: dict[str, int | None], perfect: bool | None) -> None:
    assert replace(PERFECT, **flaw).perfect is perfect  # type: ignore[arg-type]


def test_the_share_of_perfect_games_is_over_those_that_can_be_judged() -> None:
    found = summarise([PERFECT, replace(PERFECT, died=True)]).perfect
    assert found is not None
    assert (found.mean, found.n) == (0.5, 2)
    assert summarise([replace(PERFECT, n_targets=None)]).perfect is None


def test_of_equal_games_the_one_that_was_survived_wins() -> None:
    lost = replace(PERFECT, died=True)
    assert winner(PERFECT, lost) == "imitator"
    assert winner(lost, PERFECT) == "clone"
    assert winner(lost, lost) == "tie"
    # Targets and strays come first.
    assert winner(lost, replace(PERFECT, targets=5)) == "imitator"
    assert winner(replace(PERFECT, strays=1), lost) == "clone"
