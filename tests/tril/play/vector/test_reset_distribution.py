import numpy as np
import pytest

from tril.errors import Invalid
from tril.play.episode import TRAINING_IDLE_FRAMES, Start
from tril.play.vector.vector_game import (
    DemonstrationLog,
    DemonstrationStep,
    FixedStarts,
    TrainingStarts,
)

LOG = DemonstrationLog(Start(5), bytes([1] * 202))


def test_training_starts_are_drawn_evenly_and_are_no_evaluation_starts() -> None:
    rng = np.random.default_rng(0)
    drawn = [TrainingStarts().sample(rng, 0, n) for n in range(3000)]
    assert {start.idle_frames for start in drawn if isinstance(start, Start)} == set(
        TRAINING_IDLE_FRAMES
    )


def test_the_share_of_games_begins_at_any_step_of_any_demonstration() -> None:
    source = TrainingStarts(demonstrations=(LOG, LOG), demonstration_share=0.3)
    rng = np.random.default_rng(0)
    drawn = [source.sample(rng, 0, n) for n in range(5000)]
    steps = [one for one in drawn if isinstance(one, DemonstrationStep)]
    assert 0.27 < len(steps) / len(drawn) < 0.33
    assert {(one.demonstration, one.step) for one in steps} == {
        (demonstration, step) for demonstration in range(2) for step in range(51)
    }


def test_a_fixed_start_is_played_once() -> None:
    source = FixedStarts((Start(1), Start(2)))
    rng = np.random.default_rng(0)
    assert source.sample(rng, 1, 0) == Start(2)
    assert source.sample(rng, 1, 1) is None


def test_contradictions_are_refused() -> None:
    with pytest.raises(ValueError, match="share from 0 to 1"):
        TrainingStarts(demonstrations=(LOG,), demonstration_share=1.1)
    with pytest.raises(ValueError, match="Expected demonstrations"):
        TrainingStarts(demonstration_share=0.5)
    with pytest.raises(ValueError, match="at least one frame"):
        DemonstrationLog(Start(0), b"")
    with pytest.raises(Invalid, match="at least one number"):
        TrainingStarts(idle_frames=())
    with pytest.raises(Invalid, match="0 to 127"):
        TrainingStarts(idle_frames=(128,))
