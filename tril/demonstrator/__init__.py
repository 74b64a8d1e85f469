"""The scripted player that makes example demonstrations; never presented as a person."""

from tril.demonstrator.example import (
    N_PERFECT,
    Demonstration,
    DemonstrationFailed,
    carry_out,
    demonstrate,
    example_tasks,
    make_example,
    perfect_demonstrations,
)
from tril.demonstrator.expert import EXPERT_STYLE, Expert, check_expert
from tril.demonstrator.plans import N_DEMONSTRATIONS, DemonstrationPlan, example_plans, meets

__all__ = [
    "EXPERT_STYLE",
    "N_DEMONSTRATIONS",
    "N_PERFECT",
    "Demonstration",
    "DemonstrationFailed",
    "DemonstrationPlan",
    "Expert",
    "carry_out",
    "check_expert",
    "demonstrate",
    "example_plans",
    "example_tasks",
    "make_example",
    "meets",
    "perfect_demonstrations",
]
