"""What each stage of a run does. A stage may be begun any number of times, see docs/jobs.md."""

from __future__ import annotations

from collections.abc import Callable, Mapping

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
from tril.analysis.outcome import RunOutcome
from tril.stages import Stage

StageWork = Callable[[RunData, Progress], RunOutcome | None]
"""Does a stage; returns what it adds to the run's outcome, if anything."""

STAGE_WORK: Mapping[Stage, StageWork] = {
    Stage.DEMONSTRATIONS: make_demonstrations,
    Stage.TRAJECTORIES: replay_demonstrations,
    Stage.REWARD: learn_reward,
    Stage.CHECK: check_reward,
    Stage.CLONE: learn_clone,
    Stage.IMITATOR: learn_imitator,
    Stage.EVALUATION: evaluate,
    Stage.ATTENTION: draw_attention,
}
