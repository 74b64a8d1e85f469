"""The scripted player that makes example demonstrations; never presented as a person."""

from tril.demonstrator.checklist import tick
from tril.demonstrator.example import (
    N_PERFECT,
    Demonstration,
    DemonstrationFailed,
    carry_out,
    demonstrate,
    example_tasks,
    judge_example,
    make_example,
    perfect_demonstrations,
)
from tril.demonstrator.expert import EXPERT_STYLE, Expert, check_expert
from tril.demonstrator.judging import Judgement, ShownGame
from tril.demonstrator.kinds import KINDS, SCRIPTED, ExampleKind, kind_named
from tril.demonstrator.manner import HUMAN, PERFECT, Manner
from tril.demonstrator.plans import (
    N_DEMONSTRATIONS,
    DemonstrationPlan,
    PlayedGame,
    example_plans,
    meets,
    shows,
)

__all__ = [
    "EXPERT_STYLE",
    "HUMAN",
    "KINDS",
    "N_DEMONSTRATIONS",
    "N_PERFECT",
    "PERFECT",
    "SCRIPTED",
    "Demonstration",
    "DemonstrationFailed",
    "DemonstrationPlan",
    "ExampleKind",
    "Expert",
    "Judgement",
    "Manner",
    "PlayedGame",
    "ShownGame",
    "carry_out",
    "check_expert",
    "demonstrate",
    "example_plans",
    "example_tasks",
    "judge_example",
    "kind_named",
    "make_example",
    "meets",
    "perfect_demonstrations",
    "shows",
    "tick",
]
