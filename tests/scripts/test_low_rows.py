from __future__ import annotations

import numpy as np

from scripts.pretraining.low_rows import (
    MAX_ROW_HITS,
    MAX_ROWS,
    MIN_ROW_HITS,
    draw_low_rows,
    play_low_rows,
)


def test_low_rows_are_drawn_in_an_order_in_which_they_can_be_hit() -> None:
    rng = np.random.default_rng(1)
    drawn = [draw_low_rows(rng) for _ in range(200)]
    for cells in drawn:
        assert MIN_ROW_HITS <= len(cells) <= MAX_ROW_HITS
        assert len(set(cells)) == len(cells)
        assert all(row < MAX_ROWS for row, _ in cells)
        for place, (row, column) in enumerate(cells):
            assert {(below, column) for below in range(row)} <= set(cells[:place])
    first_rows = {tuple(column for row, column in cells if row == 0) for cells in drawn}
    assert {(0, 1, 2, 3, 4, 5), (5, 4, 3, 2, 1, 0)} <= first_rows
    assert len(first_rows) > 10


def test_a_game_towards_low_rows_is_made_from_its_seed() -> None:
    first, again = (play_low_rows(np.random.default_rng(3)) for _ in range(2))
    assert first == again
    assert first.replay.taken
    assert all(hit.row <= MAX_ROWS for hit in first.replay.taken)
