"""Libraries and recordings, as tests read them."""

from __future__ import annotations

from typing import Any

from starlette.testclient import TestClient

from tril.recording import Replay
from tril.store import recordings
from tril.store.models import RecordingRow


def rows_of(library: dict[str, Any]) -> list[dict[str, Any]]:
    """Return the rows of an answer's columns, each with whether it is ranked."""
    columns = library["recordings"]
    counters, measured = columns.pop("counters"), columns.pop("measured")
    rows = [
        dict(zip(columns, values, strict=True)) for values in zip(*columns.values(), strict=True)
    ]
    return [
        row
        | {"ranked": row["id"] in library["ranked"]}
        | {"counters": {name: counts[place] for name, counts in counters.items()}}
        | {"measured": [values[place] for values in measured]}
        for place, row in enumerate(rows)
    ]


def unranked_in(client: TestClient, behaviour: str) -> list[int]:
    """Return what a behaviour, named by its path, can rank and has not ranked, newest first."""
    rows = [
        row
        for path in ("library", "borrowed")
        for row in rows_of(client.get(f"{behaviour}/{path}").json())
    ]
    return sorted(
        (
            row["id"]
            for row in rows
            if row["state"] == "kept" and row["verification"] == "verified" and not row["ranked"]
        ),
        reverse=True,
    )


def replay_of(row: RecordingRow) -> Replay:
    """Return what happened in a recording, as its row says."""
    return Replay(
        recordings.taken_of(row),
        row.end,
        row.n_frames,
        dict(row.counters),
        row.score or 0.0,
        tuple(row.hashes),
        dict(row.measured),
    )
