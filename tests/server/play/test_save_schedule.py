"""Commits are spread over slots, and every game is saved in time."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from server.play.saving.save_schedule import N_SLOTS, games_due

EVERY_S = 0.8
SLOT_S = EVERY_S / N_SLOTS


@given(
    began_s=st.lists(st.floats(0, 3), min_size=1, max_size=40),
    jitter=st.lists(st.floats(0, SLOT_S / 4), min_size=40, max_size=40),
)
def test_every_game_is_saved_in_time(began_s: list[float], jitter: list[float]) -> None:
    last = dict(enumerate(began_s))
    for slot, late_s in enumerate(jitter):
        now = slot * SLOT_S + late_s
        playing = {game: at for game, at in last.items() if began_s[game] <= now}
        for game in games_due(playing, now, EVERY_S):
            assert now - last[game] <= EVERY_S
            last[game] = now
    assert all(now - at <= EVERY_S for at in last.values())


def test_games_that_began_together_are_not_saved_together() -> None:
    last = dict.fromkeys(range(20), 0.0)
    sizes = []
    for slot in range(1, 25):
        now = slot * SLOT_S
        saved = games_due(last, now, EVERY_S)
        last.update(dict.fromkeys(saved, now))
        sizes.append(len(saved))
    assert max(sizes) <= 10
    assert min(sizes) > 0


def test_a_lone_game_is_not_saved_in_every_slot() -> None:
    last, saves = {"game": 0.0}, 0
    for slot in range(1, 41):
        for game in games_due(last, slot * SLOT_S, EVERY_S):
            last[game] = slot * SLOT_S
            saves += 1
    assert saves <= 40 / 3 + 1


def test_all_games_are_saved_when_slots_come_late() -> None:
    last = dict.fromkeys(range(9), 0.0)
    assert sorted(games_due(last, 2 * EVERY_S, EVERY_S)) == list(range(9))
    assert games_due({}, 1.0, EVERY_S) == []
