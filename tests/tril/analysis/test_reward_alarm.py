"""The alarm for reward hacking, on made-up trainings of which is known whether they hack."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tests.trainings import DEMONSTRATED, HACKS, HONEST, ROLLOUT_STEPS, Training
from tril.analysis.reward_alarm import RewardAlarm, reward_alarm


def alarm_of(training: Training, draws: int = 0, n_targets: int | None = 6) -> RewardAlarm | None:
    return reward_alarm(training.curves(draws), n_targets, DEMONSTRATED)


@pytest.mark.parametrize("name", HACKS)
def test_a_return_that_rises_alone_gives_an_alarm(name: str) -> None:
    found = [alarm_of(HACKS[name], draws) for draws in range(5)]
    for alarm in found:
        assert alarm is not None
        assert alarm.predicted_return.rise >= 90
        assert alarm.hits.rise < 0.25
        assert 0 <= alarm.from_step < alarm.to_step <= HACKS[name].n_points * ROLLOUT_STEPS


@pytest.mark.parametrize("name", HONEST)
def test_an_honest_training_gives_none(name: str) -> None:
    assert [alarm_of(HONEST[name], draws) for draws in range(5)] == [None] * 5


def test_the_alarm_is_raised_during_training() -> None:
    curves = HACKS["all the time"].curves()
    half = {name: points[: len(points) // 2] for name, points in curves.items()}
    assert reward_alarm(half, 6, DEMONSTRATED) is not None


def test_a_short_training_gives_none() -> None:
    hack = replace(HACKS["all the time"], n_points=30)
    assert alarm_of(hack) is None


def test_without_targets_or_curves_there_is_no_alarm() -> None:
    hack = HACKS["all the time"]
    assert alarm_of(hack) is not None
    assert alarm_of(hack, n_targets=None) is None
    curves = hack.curves()
    assert reward_alarm({}, 6, DEMONSTRATED) is None
    assert reward_alarm({**curves, "hits": []}, 6, DEMONSTRATED) is None
    assert reward_alarm(curves, 6, ()) is None


def test_gaps_in_a_curve_are_tolerated() -> None:
    curves = HACKS["all the time"].curves()
    few = {**curves, "strays": curves["strays"][::2]}
    assert reward_alarm(few, 6, DEMONSTRATED) is not None
    early = {**curves, "strays": curves["strays"][:5]}
    assert reward_alarm(early, 6, DEMONSTRATED) is None


def test_the_message_names_the_cause_and_the_remedy() -> None:
    alarm = alarm_of(replace(HACKS["all the time"], length=lambda t: 100 + 180 * t))
    assert alarm is not None
    assert "predicted return of the training games rose from" in alarm.message
    assert "Watch the imitator" in alarm.message
    assert "change the order" in alarm.message
    assert "staying alive" in alarm.message
    even = alarm_of(HACKS["all the time"])
    assert even is not None
    assert "staying alive" not in even.message
