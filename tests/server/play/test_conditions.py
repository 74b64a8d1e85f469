"""What a recording says about how it was played."""

from __future__ import annotations

import json
from collections.abc import Iterator
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from server.play.conditions import BAD_P95_MS, KEY, MAX_ENTRIES, BegunBy, PlayConditions
from tril.games.base import MAX_FRAMES as LONGEST_GAME
from tril.games.space_invaders.memory import MAX_FRAMES
from tril.store.training.evaluations import ACTION_SELECTIONS, POLICIES

FRAMES = st.integers(1, MAX_FRAMES)
SPEEDS = st.dictionaries(st.integers(0, MAX_FRAMES), st.integers(25, 100)).map(
    lambda speeds: sorted(speeds.items())
)
CONDITIONS = st.builds(
    PlayConditions,
    presses=st.lists(st.tuples(FRAMES, st.floats(0.1, 6553.5))),
    dropped=st.lists(FRAMES),
    speeds=SPEEDS,
    single_steps=st.lists(FRAMES),
    pauses=st.lists(FRAMES),
    begun_by=st.none()
    | st.builds(
        BegunBy,
        run_id=st.uuids().map(str),
        policy=st.sampled_from(POLICIES),
        action_selection=st.sampled_from(ACTION_SELECTIONS),
        frames=FRAMES,
    ),
)
TOO_MANY_SPEEDS = [[frame, 50 + frame % 2] for frame in range(LONGEST_GAME + 2)]


@given(CONDITIONS)
def test_conditions_survive_being_stored(conditions: PlayConditions) -> None:
    stored = json.loads(json.dumps({**conditions.to_conditions(), "manner": "human"}))
    assert PlayConditions.from_conditions(stored) == conditions


@pytest.mark.parametrize(
    "foreign",
    [
        {},
        {KEY: None},
        {KEY: []},
        {KEY: {**PlayConditions().model_dump(), "presses": [[1]]}},
        {KEY: {**PlayConditions().model_dump(), "presses": [[1, float("nan")]]}},
        {KEY: {**PlayConditions().model_dump(), "speeds": [[1, 0]]}},
        {KEY: {**PlayConditions().model_dump(), "speeds": [[9, 50], [4, 75]]}},
        {KEY: {**PlayConditions().model_dump(), "speeds": [[9, 50], [9, 75]]}},
        {KEY: {**PlayConditions().model_dump(), "speeds": TOO_MANY_SPEEDS}},
        {KEY: {**PlayConditions().model_dump(), "pauses": [1] * (MAX_ENTRIES + 1)}},
        {KEY: {**PlayConditions().model_dump(), "dropped": "many"}},
        {KEY: {**PlayConditions().model_dump(), "mood": "good"}},
    ],
)
def test_what_can_not_be_read_is_left_alone(foreign: dict[str, object]) -> None:
    assert PlayConditions.from_conditions(foreign) is None


@given(CONDITIONS, st.integers(0, MAX_FRAMES))
def test_a_rewound_game_keeps_of_its_policys_part_what_is_left(
    conditions: PlayConditions, frame: int
) -> None:
    kept = conditions.until(frame).begun_by
    if conditions.begun_by is None or frame == 0:
        assert kept is None
    else:
        assert kept is not None
        assert kept.frames == min(frame, conditions.begun_by.frames)
        assert kept.run_id == conditions.begun_by.run_id


def test_latency_is_given_by_nearest_rank() -> None:
    presses = [(frame, float(frame)) for frame in range(20, 0, -1)]
    latency = PlayConditions(presses=presses, dropped=[5, 6]).latency(1200)
    assert (latency.presses, latency.p50_ms, latency.p95_ms) == (20, 10.0, 19.0)
    assert latency.frames_dropped == 2
    assert not latency.is_bad


def test_without_presses_nothing_is_said_of_their_latency() -> None:
    latency = PlayConditions().latency(1200)
    assert (latency.presses, latency.p50_ms, latency.p95_ms) == (0, None, None)
    assert not latency.is_bad


@pytest.mark.parametrize(
    ("conditions", "is_bad"),
    [
        (PlayConditions(presses=[(1, BAD_P95_MS)]), False),
        (PlayConditions(presses=[(1, BAD_P95_MS + 0.1)]), True),
        (PlayConditions(dropped=list(range(60))), False),
        (PlayConditions(dropped=list(range(61))), True),
    ],
)
def test_late_presses_and_missing_frames_are_bad(conditions: PlayConditions, is_bad: bool) -> None:
    assert conditions.latency(1200).is_bad is is_bad


def test_the_speed_is_the_last_one_set() -> None:
    conditions = PlayConditions()
    assert conditions.speed_percent == 100
    conditions.set_speed(10, 50)
    conditions.set_speed(20, 50)
    conditions.set_speed(30, 25)
    conditions.set_speed(30, 75)
    conditions.set_speed(40, 25)
    conditions.set_speed(40, 75)
    assert conditions.speeds == [(10, 50), (30, 75)]
    assert conditions.speed_percent == 75


@given(speeds=SPEEDS, n_frames=st.integers(0, MAX_FRAMES))
def test_the_slowest_speed_is_that_of_an_executed_frame(
    speeds: list[tuple[int, int]], n_frames: int
) -> None:
    ends = [*(frame for frame, _ in speeds), MAX_FRAMES]
    per_frame = [100] * ends[0]
    for (begin, end), (_, percent) in zip(pairwise(ends), speeds, strict=True):
        per_frame += [percent] * (end - begin)
    conditions = PlayConditions(speeds=speeds)
    assert conditions.slowest_percent(n_frames) == min(per_frame[:n_frames], default=100)


class CountedList(list[tuple[int, int]]):
    """A list that counts how often it is iterated over."""

    n_iterations = 0

    def __iter__(self) -> Iterator[tuple[int, int]]:
        self.n_iterations += 1
        return super().__iter__()


def test_the_slowest_of_many_speeds_takes_one_pass() -> None:
    conditions = PlayConditions()
    conditions.speeds = counted = CountedList((n, 50 + n % 2) for n in range(MAX_FRAMES))
    assert conditions.slowest_percent(MAX_FRAMES) == 50
    assert counted.n_iterations == 1


def test_a_page_changes_speed_at_most_once_per_frame() -> None:
    conditions = PlayConditions()
    for n in range(8000):
        conditions.set_speed(n // 20, 25 + n % 76)
    assert len(conditions.speeds) <= 400
    assert PlayConditions.from_conditions(conditions.to_conditions()) == conditions


def test_presses_and_pauses_are_bounded() -> None:
    conditions = PlayConditions()
    for _ in range(MAX_ENTRIES + 1):
        conditions.note_press(1, 40.0)
        conditions.note_pause(1)
    assert PlayConditions.from_conditions(conditions.to_conditions()) == conditions


def test_presses_in_slow_motion_and_single_steps_say_nothing_of_latency() -> None:
    conditions = PlayConditions(speeds=[(10, 50), (20, 100)], single_steps=[30])
    for frame in (10, 11, 20, 21, 30, 31):
        conditions.note_press(frame, 40.0)
    assert [frame for frame, _ in conditions.presses] == [10, 21, 31]
