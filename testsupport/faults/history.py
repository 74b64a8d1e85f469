"""What clients asked for and were told, and which faults there were meanwhile."""

from __future__ import annotations

import json
import threading
from dataclasses import asdict, dataclass, field
from enum import StrEnum
from pathlib import Path
from typing import Any


class Kind(StrEnum):
    """What a client does.

    WRITE gives a subject a value, READ asks for it. IMPORT uploads a recording, PLAY plays a game
    to its end, REJOIN goes on with a game whose connection broke. RANK saves a ranking, UNDO
    undoes the last one. CREATE, CANCEL and RESUME are of runs.
    """

    WRITE = "write"
    READ = "read"
    IMPORT = "import"
    PLAY = "play"
    REJOIN = "rejoin"
    RANK = "rank"
    UNDO = "undo"
    CREATE = "create"
    CANCEL = "cancel"
    RESUME = "resume"


@dataclass(frozen=True)
class Request:
    """One request and its answer.

    Attributes:
        kind: What was asked for.
        subject: What it was about, such as ``notes of recording 3``.
        value: What was sent.
        began_s: When it was sent; seconds, monotonic.
        ended_s: When the answer came, or the client gave up.
        status: HTTP status; None without an answer.
        answer: What the answer says.
    """

    kind: Kind
    subject: str
    value: Any
    began_s: float
    ended_s: float
    status: int | None
    answer: Any = None

    @property
    def is_acknowledged(self) -> bool:
        """Whether the client was told that it was done."""
        return self.status is not None and 200 <= self.status < 300

    @property
    def is_uncertain(self) -> bool:
        """Whether it may have been done without the client being told."""
        return self.status is None or self.status >= 500


@dataclass(frozen=True)
class Fault:
    """One fault.

    Attributes:
        kind: What was done, such as ``kill worker``.
        began_s: When; seconds, monotonic.
        healed_s: When it was undone.
        recovered_s: When every process answered again; None if they never did.
    """

    kind: str
    began_s: float
    healed_s: float
    recovered_s: float | None

    def covers(self, request: Request, grace_s: float) -> bool:
        """Whether a request may have met the fault or its consequences."""
        if self.recovered_s is not None and request.began_s > self.recovered_s + grace_s:
            return False
        return request.ended_s >= self.began_s


@dataclass
class History:
    """Requests and faults, in order of their ends; written by several threads."""

    requests: list[Request] = field(default_factory=list)
    faults: list[Fault] = field(default_factory=list)
    _lock: threading.Lock = field(default_factory=threading.Lock, repr=False)

    def add(self, entry: Request | Fault) -> None:
        """Add a request that is over, or a fault."""
        with self._lock:
            if isinstance(entry, Request):
                self.requests.append(entry)
            else:
                self.faults.append(entry)

    def write(self, path: Path) -> None:
        """Write everything as JSON Lines."""
        entries = [{"request": asdict(request)} for request in self.requests]
        entries += [{"fault": asdict(fault)} for fault in self.faults]
        path.write_text("".join(f"{json.dumps(entry)}\n" for entry in entries), encoding="utf-8")
