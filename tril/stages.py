"""The stages of a run."""

from __future__ import annotations

from enum import StrEnum


class Stage(StrEnum):
    """A stage of a run, in the order in which a run goes through them."""

    DEMONSTRATIONS = "demonstrations"
    TRAJECTORIES = "trajectories"
    REWARD = "reward"
    CHECK = "check"
    CLONE = "clone"
    IMITATOR = "imitator"
    EVALUATION = "evaluation"
    ATTENTION = "attention"

    @property
    def label(self) -> str:
        """The stage's name for people."""
        return _WORDS[self][0]

    @property
    def summary(self) -> str:
        """What happens in the stage, in one sentence for people."""
        return _WORDS[self][1]


_WORDS = {
    Stage.DEMONSTRATIONS: ("Demonstrations", "A scripted player makes the example games."),
    Stage.TRAJECTORIES: ("Replay", "Each ranked recording is replayed as an imitator sees it."),
    Stage.REWARD: ("Reward model", "Tril learns from the order what makes better games better."),
    Stage.CHECK: ("Check", "Does the learned reward agree with the ranking?"),
    Stage.CLONE: (
        "Clone",
        "A baseline copies the perfect recordings or, without any, the best ranked ones.",
    ),
    Stage.IMITATOR: ("Imitator", "The imitator learns to earn the reward."),
    Stage.EVALUATION: ("Evaluation", "Both play from starts they were not trained on."),
    Stage.ATTENTION: ("Attention", "What on the screen does the reward model look at?"),
}


def stages_of(example: bool) -> tuple[Stage, ...]:
    """Return the stages that a run goes through, in order.

    Args:
        example: Whether the run makes its demonstrations first.
    """
    return tuple(stage for stage in Stage if example or stage is not Stage.DEMONSTRATIONS)
