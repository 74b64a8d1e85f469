"""Which games of an imitator that still learns are kept and shown."""

from __future__ import annotations

from testsupport.workplace import Workplace
from tril.games.space_invaders.behaviours import BUILT_IN
from tril.store import recordings
from tril.store.training import training_games
from tril.store.training.evaluations import N_PROPOSED

COLUMN_1 = next(one for one in BUILT_IN if one.slug == "column-1")


def test_the_games_of_the_newest_snapshot_are_shown(workplace: Workplace) -> None:
    run_id = workplace.make_run()
    with workplace.database.reading() as session:
        assert training_games.latest(session, run_id) == (0, [])
    with workplace.database.writing() as session:
        for key, steps in zip(workplace.ranked, (50, 50, 100, 100), strict=True):
            row = recordings.get(session, key)
            row.run_id, row.conditions = run_id, {"steps": steps}
    with workplace.database.reading() as session:
        steps, games = training_games.latest(session, run_id)
    assert (steps, [game.id for game in games]) == (100, list(workplace.ranked[2:]))


def test_few_games_are_kept_and_of_every_kind() -> None:
    good = tuple((row, 0) for row in range(6))
    games = [(good, False)] * 20 + [((), True), (((0, 3),), False)]
    picked = training_games.pick(COLUMN_1, games)
    assert len(picked) == N_PROPOSED
    assert {20, 21} <= set(picked)
    assert picked == training_games.pick(COLUMN_1, games) == sorted(picked)
    assert training_games.pick(COLUMN_1, games[:3]) == [0, 1, 2]
