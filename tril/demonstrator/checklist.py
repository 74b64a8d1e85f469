"""Which of a behaviour's demonstrations are there, by what games really came to."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from tril.demonstrator.plans import DemonstrationPlan, PlayedGame, shows


def tick(
    plans: Sequence[DemonstrationPlan], games: Mapping[int, PlayedGame]
) -> dict[int, int | None]:
    """Assign games to the plans that they show, so that as many plans as possible have one.

    A game stands for one plan only, also where it meets the rules of several; older assignments
    make way where that helps (Kuhn's algorithm for bipartite matching).

    Args:
        plans: What is to be shown.
        games: What each game came to, by its id.

    Returns:
        By the number of each plan the id of its game, None where it is missing.
    """
    fitting = {
        plan.number: [number for number, game in games.items() if shows(plan, game) is None]
        for plan in plans
    }
    plan_of: dict[int, int] = {}

    def find_game(plan: int, tried: set[int]) -> bool:
        for number in fitting[plan]:
            if number in tried:
                continue
            tried.add(number)
            if number not in plan_of or find_game(plan_of[number], tried):
                plan_of[number] = plan
                return True
        return False

    for plan in plans:
        find_game(plan.number, set())
    game_of = {plan: number for number, plan in plan_of.items()}
    return {plan.number: game_of.get(plan.number) for plan in plans}
