"""Games of policies are measured when they are verified."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import cast

from trainer.policy.evaluation import EvaluatedGame
from trainer.runtime.context import RunContext
from trainer.runtime.policy_games import verify_games
from tril.games import game_named
from tril.games.measures import Counted, Length
from tril.games.space_invaders.behaviours import ROW_1
from tril.sample import sample


def test_a_verified_game_has_the_values_of_the_behaviours_measures() -> None:
    game = game_named("space_invaders")
    length = Length(at_least=3)
    # Another version of a game may lack what was measured in an earlier one.
    lost = Counted(counter="bonus ships")
    context = SimpleNamespace(
        game=game,
        behaviour=replace(ROW_1, measures=(length, lost)),
        check_cancelled=lambda: None,
    )
    played = cast("EvaluatedGame", SimpleNamespace(recording=sample(game)))
    (verified,) = verify_games(cast("RunContext", context), [played], game.make_console())
    assert verified.replay.measured == {length.key: verified.replay.n_frames / 60}
