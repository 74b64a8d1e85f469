"""What players without a learned reward reach in the evaluation games after openings.

    python -m benchmarks.learning.yardsticks [-b column-3 -b row-1]

The scripted player reads the console's memory, looks ahead on a saved game and goes for the targets
from wherever the opening leaves it: about as much as can be reached. The tape replays the perfect
demonstration whose start differs from the game's by the fewest idle frames, from the step at which
the opening ends: what remembering is worth. Both play the 32 games that benchmarks.learning.people
judges imitators by, with every action executed as chosen and with sticky actions. Prints a table
and JSON; a behaviour takes about four minutes.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable
from typing import Any

import numpy as np

from benchmarks.learning.expert import Expert
from testsupport.space_invaders import idle_frames
from tril.demonstrators.example import example_tasks, execute
from tril.games.atari.starts import EVALUATION_START_COUNT
from tril.games.behaviours import Behaviour, score
from tril.games.space_invaders import SPACE_INVADERS
from tril.games.space_invaders.behaviours import BUILT_IN
from tril.games.space_invaders.ends import DEATHS
from tril.games.space_invaders.memory import Action
from tril.play.agent import STICKY_ACTION_PROBABILITY, AgentGame, StickyActions
from tril.recording import step_actions

Player = Callable[[AgentGame], int]


def figures(
    behaviour: Behaviour, player_of: Callable[[int], Player], sticky: float
) -> dict[str, float]:
    """Return a player's mean figures over the evaluation games.

    Args:
        behaviour: The behaviour.
        player_of: Makes the player of the game from an evaluation start.
        sticky: Probability that an action is repeated.
    """
    assert behaviour.target is not None
    console = SPACE_INVADERS.make_console()
    rows = []
    for number in range(EVALUATION_START_COUNT):
        rng = np.random.default_rng([number, 7])
        game = AgentGame(console, sticky=StickyActions(sticky, rng) if sticky else None)
        game.begin(SPACE_INVADERS.starts.evaluation_opening(number))
        player = player_of(number)
        while game.end is None:
            game.step(player(game))
        found = score(behaviour, tuple(hit.cell for hit in game.taken))
        assert found is not None
        died = game.end in DEATHS
        whole = found.targets == len(behaviour.target) and not found.strays + found.order_errors
        rows.append((found.targets, found.strays, died, whole and not died))
    names = ("targets", "strays", "died", "perfect")
    return dict(zip(names, np.mean(rows, axis=0).tolist(), strict=True))


def scripted(behaviour: Behaviour) -> Callable[[int], Player]:
    """Return the scripted player for each start."""
    expert = Expert(behaviour, SPACE_INVADERS.make_console())

    def player_of(number: int) -> Player:
        expert.begin(np.random.default_rng(number))
        return lambda game: expert.action(game.episode.save())

    return player_of


def tape(behaviour: Behaviour) -> Callable[[int], Player]:
    """Return the player that replays the perfect demonstration of the nearest start."""
    tasks = example_tasks(behaviour, np.random.default_rng(0))
    shown = [one for one in execute(tasks) if one.perfect]
    starts = np.array([idle_frames(one.recording.start) for one in shown])
    tapes = [step_actions(one.recording.actions, 4) for one in shown]

    def player_of(number: int) -> Player:
        idle = idle_frames(SPACE_INVADERS.starts.evaluation_opening(number).start)
        played = tapes[int(np.abs(starts - idle).argmin())]

        def next_action(game: AgentGame) -> int:
            return int(played[game.steps]) if game.steps < len(played) else int(Action.NOOP)

        return next_action

    return player_of


def main() -> None:
    """Play and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-b", "--behaviour", action="append", help="default: all seven")
    slugs = parser.parse_args().behaviour
    rows: list[dict[str, Any]] = []
    print("| behaviour | player | actions | targets | strays | lost | perfect |")
    print("|---|---|---|---:|---:|---:|---:|")
    for behaviour in BUILT_IN:
        if behaviour.target is None or (slugs and behaviour.slug not in slugs):
            continue
        for name, make in (("scripted", scripted), ("tape", tape)):
            player_of = make(behaviour)
            for sticky in (0.0, STICKY_ACTION_PROBABILITY):
                found = figures(behaviour, player_of, sticky)
                actions = "sticky" if sticky else "as chosen"
                row = {"behaviour": behaviour.slug, "player": name, "actions": actions}
                rows.append(row | found)
                print(
                    f"| {behaviour.name} | {name} | {actions} | {found['targets']:.2f} |"
                    f" {found['strays']:.2f} | {found['died']:.0%} | {found['perfect']:.0%} |",
                    flush=True,
                )
    print(json.dumps(rows))


if __name__ == "__main__":
    main()
