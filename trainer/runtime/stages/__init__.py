"""What each stage of a run does. A stage may be begun any number of times, see docs/jobs.md."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from trainer.progress import Progress
from trainer.runtime.run_data import RunData
from trainer.runtime.stages.attention import draw_attention
from trainer.runtime.stages.demonstrations import make_demonstrations
from trainer.runtime.stages.evaluation import evaluate
from trainer.runtime.stages.learning import (
    check_reward,
    learn_clone,
    learn_imitator,
    learn_reward,
    replay_demonstrations,
)

StageWork = Callable[[RunData, Progress], dict[str, Any]]
"""Does a stage; returns what it adds to the run's outcome."""

STAGE_WORK: Mapping[str, StageWork] = {
    "demonstrations": make_demonstrations,
    "trajectories": replay_demonstrations,
    "reward": learn_reward,
    "check": check_reward,
    "clone": learn_clone,
    "imitator": learn_imitator,
    "evaluation": evaluate,
    "attention": draw_attention,
}
