"""Every rule of the checker, on histories made by hand that keep it and that break it."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from testsupport.faults.history import Fault, Kind, Request
from testsupport.faults.ledger import Entry
from testsupport.faults.rules import Found, Stored, lost_training, violations

NOTES = "notes of recording 3"


def asked(
    kind: Kind, subject: str, value: Any, at_s: float, status: int | None = 200, answer: Any = None
) -> Request:
    return Request(kind, subject, value, at_s, at_s + 0.5, status, answer)


def write(value: str, at_s: float, status: int | None = 200) -> Request:
    return asked(Kind.WRITE, NOTES, value, at_s, status)


def read(value: str, at_s: float) -> Request:
    return asked(Kind.READ, NOTES, None, at_s, 200, value)


KILL = Fault("kill server", began_s=10.0, healed_s=12.0, recovered_s=15.0)


def test_an_acknowledged_write_has_to_be_there() -> None:
    history = [write("a", 1.0), write("b", 2.0)]
    assert violations(history, [], Found(values={NOTES: "b"})) == []
    (lost,) = violations(history, [], Found(values={NOTES: "a"}))
    assert lost == "notes of recording 3 is 'a'; 'b' was acknowledged."


def test_an_unanswered_write_may_be_there_or_not() -> None:
    history = [write("a", 1.0), write("b", 11.0, None)]
    for final in "ab":
        assert violations(history, [KILL], Found(values={NOTES: final})) == []
    assert violations(history, [KILL], Found(values={NOTES: "c"})) != []


def test_a_refused_write_must_not_be_there() -> None:
    history = [write("a", 1.0), write("b", 11.0, 409)]
    assert violations(history, [KILL], Found(values={NOTES: "b"})) != []


def test_a_read_tells_the_last_acknowledged_write() -> None:
    final = Found(values={NOTES: "b"})
    assert violations([write("a", 1.0), read("a", 2.0), write("b", 3.0)], [], final) == []
    (stale,) = violations([write("a", 1.0), write("b", 2.0), read("a", 3.0)], [], final)
    assert "was read as 'a'" in stale


@pytest.mark.parametrize("status", [None, 503])
def test_only_while_something_is_down_may_a_request_fail(status: int | None) -> None:
    def failing(at_s: float) -> list[str]:
        return violations([write("a", at_s, status)], [KILL], Found())

    assert failing(9.8) == []  # sent before, not answered when the fault came
    assert failing(14.0) == []
    assert failing(5.0) != []
    assert failing(40.0) != []


def test_nothing_recovers_by_itself_from_a_fault_without_an_end() -> None:
    for_ever = replace(KILL, recovered_s=None)
    assert violations([write("a", 400.0, 503)], [for_ever], Found()) == []


@pytest.mark.parametrize("status", [500, 502, 404, 401, 422])
def test_other_errors_are_never_answered(status: int) -> None:
    assert violations([write("a", 11.0, status)], [KILL], Found()) != []


def imported(recording_id: int, status: int | None = 200) -> Request:
    return asked(Kind.IMPORT, "game 5", "digest", 1.0, status, recording_id)


def test_an_import_is_there_once_and_replays() -> None:
    there = Stored("digest", 120, 2)
    assert violations([imported(7)], [], Found(recordings={7: there})) == []
    assert violations([imported(7)], [], Found()) != []
    assert violations([imported(7)], [], Found(recordings={7: Stored("other", 120, 2)})) != []
    assert violations([imported(7)], [], Found(recordings={7: there, 8: there})) != []
    broken = replace(there, refusal="The RAM differs.")
    assert violations([imported(7)], [], Found(recordings={7: broken})) != []


def test_a_game_that_ended_is_stored_as_it_ended() -> None:
    ended = asked(Kind.PLAY, "game", 90, 1.0, 200, {"recording_id": 4, "frame": 93})
    assert violations([ended], [], Found(recordings={4: Stored("d", 93, 2)})) == []
    assert violations([ended], [], Found(recordings={4: Stored("d", 92, 2)})) != []
    assert violations([ended], [], Found()) != []


def test_a_game_that_broke_loses_at_most_a_second() -> None:
    def rejoined_at(frame: int) -> list[str]:
        return violations([asked(Kind.REJOIN, "game", 200, 1.0, 200, frame)], [], Found())

    assert rejoined_at(150) == []
    assert rejoined_at(100) != []


def ranked(tiers: list[list[int]], revision: int, status: int | None = 200) -> Request:
    answer = {"revision": revision, "tiers": tiers}
    return asked(Kind.RANK, "ranking of behaviour 2", tiers, 10.0 + revision, status, answer)


def test_acknowledged_revisions_are_there_and_no_others() -> None:
    first, second = [[1], [2]], [[2], [1]]
    history = [ranked(first, 1), ranked(second, 2)]

    def found(*tiers: list[list[int]]) -> Found:
        return Found(revisions=dict(enumerate(tiers, 1)))

    assert violations(history, [], found(first, second)) == []
    assert violations(history, [], found(first)) != []
    assert violations(history, [], found(first, first)) != []
    assert violations(history, [], found(first, second, first)) != []
    assert violations([*history, ranked(first, 2)], [], found(first, second)) != []
    unanswered = ranked(first, 3, None)
    assert violations([*history, unanswered], [KILL], found(first, second)) == []
    assert violations([*history, unanswered], [KILL], found(first, second, first)) == []
    assert violations([*history, unanswered], [KILL], found(first, second, [[1, 2]])) != []
    assert violations([*history, unanswered], [KILL], found(first, second, first, first)) != []


def test_a_revision_that_is_not_what_was_sent_is_found() -> None:
    swapped = replace(ranked([[1], [2]], 1), value=[[2], [1]])
    assert violations([swapped], [], Found(revisions={1: [[1], [2]]})) != []


def report(at_s: float, epoch: int, share: float, **more: Any) -> Entry:
    return Entry(at_s, "r", epoch, **{"status": "running", "stage": "reward", **more}, share=share)


def point(at_s: float, epoch: int, step: int, **more: Any) -> Entry:
    return Entry(at_s, "r", epoch, **{"status": "running", "stage": "reward", **more}, step=step)


def of_ledger(*ledger: Entry, status: str = "done", faults: list[Fault] | None = None) -> list[str]:
    return violations([], faults or [], Found(runs={"r": status}, ledger=ledger))


DONE = Entry(99.0, "r", 2, "done", "reward", 1.0, None, frozenset({"reward"}))


def test_a_run_that_went_on_from_its_checkpoint_is_as_it_should_be() -> None:
    again = Entry(25.0, "r", 1, "queued", "reward", 0.6)
    went_on = (report(1, 0, 0), point(10, 0, 3), point(20, 0, 6), again, point(31, 2, 4))
    assert of_ledger(*went_on, point(40, 2, 9), DONE) == []


def test_a_run_that_is_not_over_is_found() -> None:
    assert of_ledger(report(1, 0, 0), status="queued") == ["Run r is still queued."]


def test_a_run_that_was_made_has_to_be_there() -> None:
    made = asked(Kind.CREATE, "runs", None, 1.0, 201, "s")
    assert violations([made], [], Found(runs={"s": "done"})) == []
    assert violations([made], [], Found()) != []


def test_two_workers_on_one_run_are_found() -> None:
    late = (point(10, 2, 5), point(11, 2, 9), point(12, 2, 6), DONE)
    (twice,) = of_ledger(*late)
    assert "it is trained twice" in twice


def test_what_is_written_out_of_turn_is_found() -> None:
    assert of_ledger(point(10, 2, 5, status="queued"), DONE) != []
    assert of_ledger(point(10, 3, 5), DONE) != []
    assert of_ledger(DONE, point(100, 2, 5, status="done", finished=DONE.finished)) != []
    assert of_ledger(replace(DONE, at_s=1.0, status="running"), replace(DONE, finished=frozenset()))


def test_a_run_goes_on_only_if_somebody_asks_for_it() -> None:
    cancelled = replace(DONE, at_s=5.0, status="cancelled", finished=frozenset())
    again = (cancelled, replace(cancelled, status="queued"), replace(DONE, status="running"), DONE)
    assert of_ledger(*again) != []
    resumed = asked(Kind.RESUME, "r", None, 6.0)
    assert violations([resumed], [], Found(runs={"r": "done"}, ledger=again)) == []
    assert of_ledger(DONE, replace(DONE, status="queued"), DONE) != []


def test_a_run_fails_only_where_its_disk_fails() -> None:
    failed = replace(DONE, status="failed")
    assert of_ledger(failed, status="failed") != []
    assert of_ledger(failed, status="failed", faults=[KILL]) != []
    assert of_ledger(failed, status="failed", faults=[replace(KILL, kind="fill disk")]) == []


def test_at_most_two_minutes_of_training_are_lost() -> None:
    before = (report(0, 0, 0.0), report(50, 0, 0.2), report(200, 0, 0.6))
    lost = (*before, report(230, 2, 0.6), report(232, 2, 0.2))
    assert [loss.seconds for loss in lost_training(lost)] == [150.0]
    assert of_ledger(*lost, replace(DONE, at_s=300.0)) == [
        "Run r lost 150 s of training in the stage reward."
    ]
    kept = (*before, report(230, 2, 0.6), report(232, 2, 0.5))
    assert lost_training(kept) == []
    assert of_ledger(*kept, replace(DONE, at_s=300.0)) == []


def test_a_checkpoint_lost_later_counts_what_led_to_it() -> None:
    first = (report(0, 0, 0.0), report(100, 0, 0.5))
    second = (report(130, 2, 0.5), report(180, 2, 0.7))
    third = (report(200, 4, 0.7), report(201, 4, 0.0))
    assert [loss.seconds for loss in lost_training((*first, *second, *third))] == [150.0]


def test_what_is_left_behind_damaged_or_unlike_is_told() -> None:
    found = Found(left_behind=["a"], damaged=["b"], unlike=["c"])
    assert violations([], [], found) == ["a", "b", "c"]
