"""What has to hold after faults, judged by the clients' histories and by what is stored."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

from testsupport.faults.history import Fault, Kind, Request
from testsupport.faults.ledger import Entry
from tril.store.models import NOT_OVER, RunStatus

MOST_LOST_FRAMES = 60
"""Of a game whose server was killed: a second."""

MOST_LOST_TRAINING_S = 120.0

GRACE_S = 5.0
"""How long after recovery a request may still fail that was made of what was there before it."""

MAY_FAIL_RUNS = frozenset({"fill disk", "fail writes"})
"""Faults by which a run may fail: it then says why, and can be resumed."""


@dataclass(frozen=True)
class Stored:
    """A recording as it is stored in the end.

    Attributes:
        digest: Of its start and actions.
        n_frames: Its length.
        behaviour_id: What it is a game of.
        refusal: Why it does not replay; None if it does.
    """

    digest: str
    n_frames: int
    behaviour_id: int
    refusal: str | None = None


@dataclass(frozen=True)
class Found:
    """What is found after all faults.

    Attributes:
        values: By subject of Kind.WRITE.
        recordings: By id, deleted ones too.
        revisions: Tiers by revision, of the ranking that clients change.
        first_revision: The ranking's newest one before the clients began.
        runs: Status by id.
        ledger: Every change of the runs.
        left_behind: Processes, files and descriptors that ought to be gone.
        damaged: What an integrity check says of the databases.
        unlike: How finished runs differ from runs that nothing happened to.
    """

    values: Mapping[str, Any] = field(default_factory=dict)
    recordings: Mapping[int, Stored] = field(default_factory=dict)
    revisions: Mapping[int, list[list[int]]] = field(default_factory=dict)
    first_revision: int = 0
    runs: Mapping[str, str] = field(default_factory=dict)
    ledger: Sequence[Entry] = ()
    left_behind: Sequence[str] = ()
    damaged: Sequence[str] = ()
    unlike: Sequence[str] = ()


def violations(requests: Sequence[Request], faults: Sequence[Fault], found: Found) -> list[str]:
    """Return everything that does not hold, one sentence each."""
    return [
        *answers(requests, faults),
        *values(requests, found.values),
        *imports(requests, found.recordings),
        *games(requests, found.recordings),
        *rankings(requests, found.revisions, found.first_revision),
        *runs(requests, faults, found.runs, found.ledger),
        *epochs(found.ledger),
        *(
            f"Run {lost.run_id} lost {lost.seconds:.0f} s of training in the stage {lost.stage}."
            for lost in lost_training(found.ledger)
            if lost.seconds > MOST_LOST_TRAINING_S
        ),
        *found.left_behind,
        *found.damaged,
        *found.unlike,
    ]


def answers(requests: Sequence[Request], faults: Sequence[Fault]) -> Iterator[str]:
    """An answer is a success, a conflict, or 503 or none while something is down."""
    for request in requests:
        asked = f"{request.kind} of {request.subject} at {request.began_s:.1f} s"
        if (
            request.status is not None
            and request.status not in {409, 503}
            and request.status >= 400
        ):
            yield f"{asked} was answered {request.status}: {request.answer}"
        elif request.is_uncertain and not any(fault.covers(request, GRACE_S) for fault in faults):
            yield f"{asked} was answered {request.status} though nothing was down: {request.answer}"


def values(requests: Sequence[Request], final: Mapping[str, Any]) -> Iterator[str]:
    """A subject has the value of its last acknowledged write, or of an unanswered one.

    Each subject has one client, which asks one thing at a time. An unanswered write may have been
    done at any time since, or never.
    """
    by_subject: dict[str, list[Request]] = defaultdict(list)
    for request in requests:
        if request.kind in {Kind.WRITE, Kind.READ}:
            by_subject[request.subject].append(request)
    for subject, asked in by_subject.items():
        last: list[Any] = []
        unanswered: list[Any] = []
        for request in sorted(asked, key=lambda request: request.began_s):
            if request.kind is Kind.READ:
                if request.is_acknowledged and last and request.answer not in last + unanswered:
                    yield (
                        f"{subject} was read as {request.answer!r} at {request.began_s:.1f} s "
                        f"after {last[0]!r} was acknowledged."
                    )
            elif request.is_acknowledged:
                last = [request.value]
            elif request.is_uncertain:
                unanswered.append(request.value)
        if last and final.get(subject) not in last + unanswered:
            yield f"{subject} is {final.get(subject)!r}; {last[0]!r} was acknowledged."


def imports(requests: Sequence[Request], recordings: Mapping[int, Stored]) -> Iterator[str]:
    """What was imported is there, once, as it was sent."""
    stored: dict[str, list[int]] = defaultdict(list)
    for recording_id, recording in recordings.items():
        stored[recording.digest].append(recording_id)
        if recording.refusal is not None:
            yield f"Recording {recording_id} does not replay: {recording.refusal}"
    sent = [request for request in requests if request.kind is Kind.IMPORT]
    for request in sent:
        if request.is_acknowledged and request.answer not in stored[request.value]:
            yield f"{request.subject} was imported as recording {request.answer} and is not there."
    for digest in {request.value for request in sent}:
        if len(stored[digest]) > 1:
            yield f"Recordings {stored[digest]} are one that was imported once."


def games(requests: Sequence[Request], recordings: Mapping[int, Stored]) -> Iterator[str]:
    """A game that ended is a recording of as many frames; one that broke lost at most a second."""
    for request in requests:
        if request.kind is Kind.PLAY and request.is_acknowledged:
            recording = recordings.get(request.answer["recording_id"])
            if recording is None or recording.n_frames != request.answer["frame"]:
                frames = None if recording is None else recording.n_frames
                yield f"{request.subject} ended as {request.answer}; stored are {frames} frames."
        elif request.kind is Kind.REJOIN and request.is_acknowledged:
            lost = request.value - request.answer
            if lost > MOST_LOST_FRAMES:
                yield f"{request.subject} lost {lost} frames when its connection broke."


def rankings(
    requests: Sequence[Request], revisions: Mapping[int, list[list[int]]], first: int
) -> Iterator[str]:
    """Each acknowledged revision is there, and none that nobody asked for."""
    asked = [request for request in requests if request.kind in {Kind.RANK, Kind.UNDO}]
    told: dict[int, Request] = {}
    for request in asked:
        if not request.is_acknowledged:
            continue
        revision, tiers = request.answer["revision"], request.answer["tiers"]
        if revision in told:
            yield f"Revision {revision} of the ranking was acknowledged twice."
        told[revision] = request
        if revisions.get(revision) != tiers:
            yield f"Revision {revision} was acknowledged as {tiers}, not {revisions.get(revision)}."
        if request.kind is Kind.RANK and tiers != request.value:
            yield f"Revision {revision} was saved as {tiers}, but {request.value} was sent."
    if sorted(revisions) != list(range(1, len(revisions) + 1)):
        yield f"The revisions of the ranking are {sorted(revisions)}."
    unanswered = [request for request in asked if request.is_uncertain]
    for revision, tiers in sorted(revisions.items()):
        if revision <= first or revision in told:
            continue
        meant = [r for r in unanswered if r.kind is Kind.UNDO or r.value == tiers]
        if not meant:
            yield f"Nobody asked for revision {revision} of the ranking, {tiers}."
        else:
            unanswered.remove(min(meant, key=lambda request: request.kind is Kind.UNDO))


_MAY_FOLLOW = {
    "queued": {"running", "cancelled", "failed"},
    "running": {"queued", "cancelling", "cancelled", "stopped", "failed", "done"},
    "cancelling": {"cancelled", "done", "failed"},
    "cancelled": {"queued"},
    "stopped": {"queued"},
    "failed": {"queued"},
    "done": set[str](),
}


def runs(
    requests: Sequence[Request],
    faults: Sequence[Fault],
    final: Mapping[str, str],
    ledger: Sequence[Entry],
) -> Iterator[str]:
    """A run is over in the end, and was made to go on only as often as somebody asked for it."""
    for request in requests:
        if request.kind is Kind.CREATE and request.is_acknowledged and request.answer not in final:
            yield f"Run {request.answer} was made and is not there."
    for run_id, status in final.items():
        if status in NOT_OVER:
            yield f"Run {run_id} is still {status}."
    may_fail = any(fault.kind in MAY_FAIL_RUNS for fault in faults)
    for run_id, entries in by_run(ledger).items():
        again = 0
        for before, after in pairwise(entry.status for entry in entries):
            if before == after:
                continue
            if after not in _MAY_FOLLOW[before]:
                yield f"Run {run_id} was {before} and then {after}."
            again += RunStatus(before).is_over
        asked = [r for r in requests if r.kind is Kind.RESUME and r.subject == run_id]
        if again > sum(r.is_acknowledged or r.is_uncertain for r in asked):
            yield f"Run {run_id} went on {again} times after it was over; asked for: {len(asked)}."
        if not may_fail and any(entry.status == RunStatus.FAILED for entry in entries):
            yield f"Run {run_id} failed, though nothing was wrong with its disk."


def epochs(ledger: Sequence[Entry]) -> Iterator[str]:
    """A run is trained under one lease at a time: nothing is written twice or out of turn."""
    for run_id, entries in by_run(ledger).items():
        reached: dict[tuple[int, str], int] = {}
        epoch, finished = 0, frozenset[str]()
        for entry in entries:
            if entry.epoch < epoch:
                yield f"Run {run_id} went from epoch {epoch} back to {entry.epoch}."
            if not finished <= entry.finished:
                yield f"Run {run_id} forgot that {set(finished - entry.finished)} was finished."
            epoch, finished = entry.epoch, entry.finished
            if entry.step is None:
                continue
            where = f"in the stage {entry.stage} at step {entry.step}"
            if entry.status not in {RunStatus.RUNNING, RunStatus.CANCELLING}:
                yield f"Run {run_id} was written to {where} while it was {entry.status}."
            if entry.stage in entry.finished:
                yield f"Run {run_id} was trained {where} after that stage was finished."
            if entry.step < reached.get((epoch, entry.stage), 0):
                yield (
                    f"Run {run_id} was written to {where} in epoch {epoch}, which had come to "
                    f"{reached[epoch, entry.stage]}: it is trained twice."
                )
            reached[epoch, entry.stage] = entry.step


@dataclass(frozen=True)
class Lost:
    """Training that was done and had to be done again.

    Attributes:
        run_id: The run.
        stage: The stage.
        seconds: How long it took the first time.
    """

    run_id: str
    stage: str
    seconds: float


@dataclass
class _Work:
    """The reports of a stage under one lease: (seconds, share), in order."""

    epoch: int
    stage: str
    reports: list[tuple[float, float]] = field(default_factory=list)

    @property
    def lowest(self) -> float:
        return min(share for _, share in self.reports)

    def seconds_beyond(self, share: float) -> float:
        """How long it worked on what lies beyond a share."""
        first = next(at for at, reached in self.reports if reached >= min(share, self.highest))
        return self.reports[-1][0] - first

    @property
    def highest(self) -> float:
        return max(share for _, share in self.reports)


def lost_training(ledger: Sequence[Entry]) -> list[Lost]:
    """Return what each lease of a run had to do again of what the leases before had done.

    A lease first reports the share that the one before had reached, and then where it really goes
    on; the lowest share that it reports is that.
    """
    found = []
    for run_id, entries in by_run(ledger).items():
        works: list[_Work] = []
        for entry in entries:
            if entry.share is None or not entry.stage or entry.status != RunStatus.RUNNING:
                continue
            if not works or (works[-1].epoch, works[-1].stage) != (entry.epoch, entry.stage):
                works.append(_Work(entry.epoch, entry.stage))
            works[-1].reports.append((entry.at_s, entry.share))
        for place, work in enumerate(works):
            seconds = 0.0
            for earlier in reversed(works[:place]):
                if earlier.stage != work.stage or earlier.highest <= work.lowest:
                    break
                seconds += earlier.seconds_beyond(work.lowest)
                if earlier.lowest <= work.lowest:
                    break
            if seconds > 0:
                found.append(Lost(run_id, work.stage, seconds))
    return found


def by_run(ledger: Sequence[Entry]) -> dict[str, list[Entry]]:
    """Return the entries of each run, in order."""
    entries: dict[str, list[Entry]] = defaultdict(list)
    for entry in ledger:
        entries[entry.run_id].append(entry)
    return entries
