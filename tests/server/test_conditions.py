"""What a recording says of how it was played."""

from __future__ import annotations

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from server.play.conditions import BAD_P95_MS, KEY, PlayConditions

FRAMES = st.integers(1, 1200)
CONDITIONS = st.builds(
    PlayConditions,
    presses=st.lists(st.tuples(FRAMES, st.floats(0.1, 6553.5))),
    dropped=st.lists(FRAMES),
)


@given(CONDITIONS)
def test_conditions_survive_being_stored(conditions: PlayConditions) -> None:
    stored = json.loads(json.dumps({KEY: conditions.to_json(), "manner": "human"}))
    assert PlayConditions.from_conditions(stored) == conditions


@pytest.mark.parametrize(
    "foreign",
    [
        {},
        {KEY: None},
        {KEY: []},
        {KEY: {"presses": [[1]], "dropped": []}},
        {KEY: {"presses": [[1, float("nan")]], "dropped": []}},
        {KEY: {"presses": "many", "dropped": 3}},
    ],
)
def test_what_can_not_be_read_is_left_alone(foreign: dict[str, object]) -> None:
    assert PlayConditions.from_conditions(foreign) is None


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
