"""Match played games to the demonstration plans they fulfil."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from tril.demonstrators.space_invaders.plans import DemonstrationPlan, GameOutcome, plan_violation


def match_plans(
    plans: Sequence[DemonstrationPlan], games: Mapping[int, GameOutcome]
) -> dict[int, int | None]:
    """Assign games to plans so that as many plans as possible have a game of their own.

    Maximum bipartite matching by augmenting paths (Kuhn's algorithm).

    Args:
        plans: The plans to match.
        games: Outcomes by game id.

    Returns:
        Game id by plan number, None for an unmatched plan.
    """
    candidates = {
        plan.number: [key for key, game in games.items() if plan_violation(plan, game) is None]
        for plan in plans
    }
    plan_of: dict[int, int] = {}

    def find_game(plan: int, tried: set[int]) -> bool:
        for key in candidates[plan]:
            if key in tried:
                continue
            tried.add(key)
            if key not in plan_of or find_game(plan_of[key], tried):
                plan_of[key] = plan
                return True
        return False

    for plan in plans:
        find_game(plan.number, set())
    game_of = {plan: key for key, plan in plan_of.items()}
    return {plan.number: game_of.get(plan.number) for plan in plans}
