"""Which games of an imitator that still learns are shown."""

from __future__ import annotations

from testsupport.workplace import Workplace
from tril.store import recordings
from tril.store.training import training_games


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
