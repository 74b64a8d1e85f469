"""The scripted player that makes example demonstrations, and varied play; always labelled so."""

from tril.demonstrators.error_model import HUMAN, PERFECT, ErrorModel
from tril.demonstrators.example import (
    N_PERFECT,
    Demonstration,
    DemonstrationFailed,
    demonstrate,
    example_tasks,
    execute,
)
from tril.demonstrators.judging import Judgement, PlannedGame, rank_example
from tril.demonstrators.kinds import KINDS, SCRIPTED, ExampleKind, kind_named
from tril.demonstrators.plan_matching import match_plans
from tril.demonstrators.random_play import play_randomly
from tril.demonstrators.space_invaders.plans import (
    N_DEMONSTRATIONS,
    DemonstrationPlan,
    GameOutcome,
    example_plans,
    plan_violation,
    rule_violation,
)
from tril.demonstrators.space_invaders.varied_play import play_varied

__all__ = [
    "HUMAN",
    "KINDS",
    "N_DEMONSTRATIONS",
    "N_PERFECT",
    "PERFECT",
    "SCRIPTED",
    "Demonstration",
    "DemonstrationFailed",
    "DemonstrationPlan",
    "ErrorModel",
    "ExampleKind",
    "GameOutcome",
    "Judgement",
    "PlannedGame",
    "demonstrate",
    "example_plans",
    "example_tasks",
    "execute",
    "kind_named",
    "match_plans",
    "plan_violation",
    "play_randomly",
    "play_varied",
    "rank_example",
    "rule_violation",
]
