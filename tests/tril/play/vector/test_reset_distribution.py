import numpy as np
import pytest

from testsupport.space_invaders import idle_frames
from tril.games.atari.starts import TRAINING_IDLE_FRAMES, AtariStart
from tril.games.base import Start
from tril.games.space_invaders import SPACE_INVADERS
from tril.play.vector.vector_game import (
    DemonstrationLog,
    DemonstrationStep,
    FixedStarts,
    TrainingStarts,
)

LOG = DemonstrationLog(SPACE_INVADERS, AtariStart(5), bytes([1] * 202))


def test_training_starts_are_drawn_evenly_and_are_no_evaluation_starts() -> None:
    rng = np.random.default_rng(0)
    drawn = [TrainingStarts(SPACE_INVADERS).sample(rng, 0, n) for n in range(3000)]
    assert {idle_frames(start) for start in drawn if isinstance(start, Start)} == set(
        TRAINING_IDLE_FRAMES
    )


def test_the_share_of_games_begins_at_any_step_of_any_demonstration() -> None:
    source = TrainingStarts(SPACE_INVADERS, demonstrations=(LOG, LOG), demonstration_share=0.3)
    rng = np.random.default_rng(0)
    drawn = [source.sample(rng, 0, n) for n in range(5000)]
    steps = [one for one in drawn if isinstance(one, DemonstrationStep)]
    assert 0.27 < len(steps) / len(drawn) < 0.33
    assert {(one.demonstration, one.step) for one in steps} == {
        (demonstration, step) for demonstration in range(2) for step in range(51)
    }


def test_a_fixed_start_is_played_once() -> None:
    source = FixedStarts((AtariStart(1), AtariStart(2)))
    rng = np.random.default_rng(0)
    assert source.sample(rng, 1, 0) == AtariStart(2)
    assert source.sample(rng, 1, 1) is None


def test_contradictions_are_refused() -> None:
    with pytest.raises(ValueError, match="share from 0 to 1"):
        TrainingStarts(SPACE_INVADERS, demonstrations=(LOG,), demonstration_share=1.1)
    with pytest.raises(ValueError, match="Expected demonstrations"):
        TrainingStarts(SPACE_INVADERS, demonstration_share=0.5)
    with pytest.raises(ValueError, match="at least one frame"):
        DemonstrationLog(SPACE_INVADERS, AtariStart(0), b"")
