"""Every change of a run's row and every point of its curves, as the database committed them.

Triggers write it, so it is of the transaction that made the change and no worker can leave it out.
"""

from __future__ import annotations

import json
from dataclasses import dataclass

from sqlalchemy import text

from tril.store.database import Database

_TABLE = """
CREATE TABLE campaign_ledger (
    id {key}, at_s DOUBLE PRECISION, run_id TEXT, epoch INTEGER, status TEXT, stage TEXT,
    share DOUBLE PRECISION, step INTEGER, finished TEXT
)
"""
_OF_ROW = """
INSERT INTO campaign_ledger (at_s, run_id, epoch, status, stage, share, finished)
VALUES ({now}, NEW.id, NEW.epoch, NEW.status, NEW.stage, NEW.stage_done, NEW.finished_stages);
"""
_OF_POINT = """
INSERT INTO campaign_ledger (at_s, run_id, epoch, status, stage, step, finished)
SELECT {now}, NEW.run_id, epoch, status, NEW.stage, NEW.step, finished_stages
FROM runs WHERE id = NEW.run_id;
"""
_ON_ROW = "AFTER UPDATE OF status, epoch, stage, stage_done, finished_stages ON runs"
_ON_POINT = "AFTER INSERT ON metrics"

_SQLITE = {"now": "(julianday('now') - 2440587.5) * 86400.0"}
_POSTGRESQL = {"now": "extract(epoch FROM clock_timestamp())"}


@dataclass(frozen=True)
class Entry:
    """A change of a run, or a point of its curves.

    Attributes:
        at_s: When, by the database's clock; seconds.
        run_id: The run.
        epoch: The run's epoch after the change.
        status: Its status.
        stage: The stage at work, or the one that the point is of.
        share: Share of the stage that is done; None for a point.
        step: The point's step; None for a change of the row.
        finished: The stages that are finished.
    """

    at_s: float
    run_id: str
    epoch: int
    status: str
    stage: str
    share: float | None = None
    step: int | None = None
    finished: frozenset[str] = frozenset()


def keep_ledger(database: Database) -> None:
    """Let a database keep a ledger from now on."""
    if database.engine.dialect.name == "sqlite":
        statements = [
            _TABLE.format(key="INTEGER PRIMARY KEY AUTOINCREMENT"),
            *(
                f"CREATE TRIGGER campaign_{name} {when} BEGIN {body.format(**_SQLITE)} END"
                for name, when, body in (
                    ("row", _ON_ROW, _OF_ROW),
                    ("point", _ON_POINT, _OF_POINT),
                )
            ),
        ]
    else:
        statements = [_TABLE.format(key="BIGSERIAL PRIMARY KEY")]
        for name, when, body in (("row", _ON_ROW, _OF_ROW), ("point", _ON_POINT, _OF_POINT)):
            statements += [
                f"CREATE FUNCTION campaign_{name}() RETURNS trigger LANGUAGE plpgsql AS "
                f"$$ BEGIN {body.format(**_POSTGRESQL)} RETURN NEW; END $$",
                f"CREATE TRIGGER campaign_{name} {when} "
                f"FOR EACH ROW EXECUTE FUNCTION campaign_{name}()",
            ]
    with database.writing() as session:
        for statement in statements:
            session.connection().exec_driver_sql(statement)


def read_ledger(database: Database) -> list[Entry]:
    """Return the ledger in the order of its commits."""
    query = text(
        "SELECT at_s, run_id, epoch, status, stage, share, step, finished "
        "FROM campaign_ledger ORDER BY id"
    )
    with database.reading() as session:
        rows = session.execute(query).mappings().all()
    return [
        Entry(
            row["at_s"],
            row["run_id"],
            row["epoch"],
            row["status"],
            row["stage"],
            row["share"],
            row["step"],
            frozenset(json.loads(row["finished"])),
        )
        for row in rows
    ]
