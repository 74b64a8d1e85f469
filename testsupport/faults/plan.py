"""What a campaign is to do, and what came of it."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, field

from testsupport.faults.history import History, Kind
from testsupport.faults.ledger import Entry
from testsupport.faults.rules import Lost, lost_training


@dataclass(frozen=True)
class Plan:
    """What a campaign does.

    Attributes:
        n_faults: How many faults.
        seed: Of everything that is drawn.
        database: ``sqlite`` or ``postgresql``.
        store: ``folder`` or ``s3``.
        n_servers: How many servers.
        n_workers: How many workers; with two, one takes over from the other.
        kinds: The kinds of fault to draw from; None for all that are possible here.
        in_turn: Whether the kinds are taken in turn instead of drawn.
        quiet_s: Shortest and longest time between recovery and the next fault.
        most_s: No fault begins after so many seconds.
        steps: PPO steps of the runs to draw from: a run of seconds, and one that is longer than
            most faults.
        runs_at_once: How many runs there are to be that are not over.
        n_runs: How many runs are started at most.
    """

    n_faults: int
    seed: int = 0
    database: str = "sqlite"
    store: str = "folder"
    n_servers: int = 1
    n_workers: int = 2
    kinds: tuple[str, ...] | None = None
    in_turn: bool = False
    quiet_s: tuple[float, float] = (1.0, 8.0)
    most_s: float = float("inf")
    steps: tuple[int, ...] = (256, 4096)
    runs_at_once: int = 2
    n_runs: float = float("inf")


@dataclass
class Result:
    """What came of a campaign.

    Attributes:
        violations: Every rule that was broken; empty is what is wanted.
        history: What clients were told, and the faults.
        ledger: Every change of the runs.
        runs: Status by run.
        impossible: Kinds of fault that can't be done here.
        seconds: How long it took.
    """

    violations: list[str] = field(default_factory=list)
    history: History = field(default_factory=History)
    ledger: Sequence[Entry] = ()
    runs: dict[str, str] = field(default_factory=dict)
    impossible: list[str] = field(default_factory=list)
    seconds: float = 0.0

    @property
    def recoveries_s(self) -> dict[str, list[float]]:
        """Seconds from the end of each fault until everything answered again, by kind."""
        found: dict[str, list[float]] = defaultdict(list)
        for fault in self.history.faults:
            if fault.recovered_s is not None:
                found[fault.kind].append(fault.recovered_s - fault.healed_s)
        return found

    @property
    def answers(self) -> Counter[str]:
        """How many requests were acknowledged, refused, or not answered."""
        return Counter(
            "acknowledged" if request.is_acknowledged else str(request.status or "unanswered")
            for request in self.history.requests
        )

    @property
    def lost(self) -> list[Lost]:
        """Training that had to be done again."""
        return lost_training(self.ledger)

    @property
    def lost_frames(self) -> list[int]:
        """Frames lost by each game whose connection broke."""
        return [
            max(0, request.value - request.answer)
            for request in self.history.requests
            if request.kind is Kind.REJOIN and request.is_acknowledged
        ]
