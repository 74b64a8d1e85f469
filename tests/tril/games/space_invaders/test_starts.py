import numpy as np
import pytest

from testsupport.space_invaders import EVALUATION_STARTS, evaluation_start, idle_frames
from tril.errors import Invalid
from tril.games import game_named
from tril.games.atari.starts import EVALUATION_START_COUNT, TRAINING_IDLE_FRAMES, AtariStart
from tril.games.base import draw_start
from tril.games.space_invaders import SPACE_INVADERS


def test_evaluation_and_training_starts_make_up_all_starts_without_overlap() -> None:
    evaluation = [start.idle_frames for start in EVALUATION_STARTS]
    assert len(evaluation) == EVALUATION_START_COUNT == 32
    assert len(TRAINING_IDLE_FRAMES) == 96
    assert sorted([*evaluation, *TRAINING_IDLE_FRAMES]) == list(range(128))


def test_evaluation_starts_are_the_ones_that_stored_results_were_made_with() -> None:
    # A change here would make every stored start number name another game.
    assert [start.idle_frames for start in EVALUATION_STARTS[:6]] == [11, 60, 109, 30, 79, 0]


def test_evaluation_starts_are_spread_over_the_phases_of_the_frame_skip() -> None:
    phases = [start.idle_frames % 4 for start in EVALUATION_STARTS]
    assert [phases.count(phase) for phase in range(4)] == [8, 8, 8, 8]


def test_start_number_names_a_start_and_the_start_its_number() -> None:
    for number in range(EVALUATION_START_COUNT):
        assert SPACE_INVADERS.starts.evaluation_number(evaluation_start(number)) == number
    assert SPACE_INVADERS.starts.evaluation_number(AtariStart(TRAINING_IDLE_FRAMES[0])) is None


def test_a_start_at_the_other_difficulty_counts_as_that_evaluation_start() -> None:
    assert (
        SPACE_INVADERS.starts.evaluation_number(
            AtariStart(evaluation_start(3).idle_frames, difficulty=1)
        )
        == 3
    )


@pytest.mark.parametrize("number", [-1, 32])
def test_an_unknown_start_number_is_refused(number: int) -> None:
    with pytest.raises(Invalid, match="from 0 to 31"):
        evaluation_start(number)


def test_drawn_starts_cover_the_training_starts_and_no_evaluation_start() -> None:
    rng = np.random.default_rng(0)
    drawn = {idle_frames(draw_start(SPACE_INVADERS.starts, rng)) for _ in range(2000)}
    assert drawn == set(TRAINING_IDLE_FRAMES)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"idle_frames": -1}, "0 to 127 idle frames"),
        ({"idle_frames": 128}, "0 to 127 idle frames"),
        ({"idle_frames": 0, "mode": 3}, "Expected game mode 0"),
        ({"idle_frames": 0, "difficulty": 2}, "difficulty 0 or 1"),
        ({"idle_frames": 0, "intro": 2}, "Expected 0 or 1 for a start's intro, got 2"),
    ],
)
def test_a_start_that_does_not_exist_is_refused(values: dict[str, int], message: str) -> None:
    with pytest.raises(Invalid, match=message):
        SPACE_INVADERS.starts.parse(values)


def test_a_start_without_its_intro_is_no_evaluation_start_and_keeps_its_name() -> None:
    starts = SPACE_INVADERS.starts
    start = starts.parse({"idle_frames": 0, "intro": 0})
    assert starts.parse(start.to_json()) == start
    assert start != starts.parse({"idle_frames": 0})
    assert start.key != starts.parse({"idle_frames": 0}).key
    assert starts.evaluation_number(start) is None
    assert starts.evaluation_number(starts.parse({"idle_frames": 0, "intro": 1})) is not None


def test_where_no_intro_precedes_a_game_both_starts_are_one() -> None:
    starts = game_named("pong").starts
    assert starts.parse({"idle_frames": 0, "intro": 0}) == starts.parse({"idle_frames": 0})
