"""Behaviours and recordings of any game: settings, starts as JSON, items, counters, score."""

from typing import Any

import sqlalchemy as sa
from alembic import op

revision = "0016"
down_revision = "0015"
branch_labels = None
depends_on = None

_BATCH = 500
_RENAMED = {
    "rom_md5": "game_version",
    "ending": "end_rule",
    "ram_hashes": "hashes",
    "hits": "taken",
}
_OF_SPACE_INVADERS = ("idle_frames", "mode", "difficulty", "shots")
_RECORDINGS = sa.table(
    "recordings",
    *map(sa.column, ("id", *_OF_SPACE_INVADERS)),
    sa.column("start", sa.JSON()),
    sa.column("counters", sa.JSON()),
)


# Columns are renamed and dropped in place: SQLite would otherwise write the table anew, which its
# foreign keys forbid.
def upgrade() -> None:
    for table in ("behaviours", "recordings"):
        game = sa.Column("game", sa.String(160), nullable=False, server_default="space_invaders")
        op.add_column(table, game)
    for old, new in _RENAMED.items():
        op.execute(f"ALTER TABLE recordings RENAME COLUMN {old} TO {new}")
    for name in ("start", "counters"):
        op.add_column("recordings", sa.Column(name, sa.JSON(), nullable=False, server_default="{}"))
    op.add_column("recordings", sa.Column("score", sa.Float()))
    op.add_column("recordings", sa.Column("max_steps", sa.Integer()))
    settings = sa.Column("settings", sa.JSON(), nullable=False, server_default="{}")
    op.add_column("behaviours", settings)
    rows = _rows(*_OF_SPACE_INVADERS)
    _write(
        [
            {
                "row": row.id,
                "start": {name: getattr(row, name) for name in _OF_SPACE_INVADERS[:3]},
                "counters": {"shots": row.shots},
            }
            for row in rows
        ]
    )
    for name in _OF_SPACE_INVADERS:
        op.drop_column("recordings", name)


def downgrade() -> None:
    for name in _OF_SPACE_INVADERS:
        op.add_column(
            "recordings", sa.Column(name, sa.Integer(), nullable=False, server_default="0")
        )
    rows = _rows("start", "counters")
    _write(
        [
            {
                "row": row.id,
                **{name: row.start.get(name, 0) for name in _OF_SPACE_INVADERS[:3]},
                "shots": row.counters.get("shots", 0),
            }
            for row in rows
        ]
    )
    for name in ("game", "start", "counters", "score", "max_steps"):
        op.drop_column("recordings", name)
    for old, new in _RENAMED.items():
        op.execute(f"ALTER TABLE recordings RENAME COLUMN {new} TO {old}")
    for name in ("game", "settings"):
        op.drop_column("behaviours", name)


def _rows(*names: str) -> list[sa.Row[Any]]:
    columns = [_RECORDINGS.c[name] for name in ("id", *names)]
    return list(op.get_bind().execute(sa.select(*columns)).all())


def _write(rows: list[dict[str, Any]]) -> None:
    if not rows:
        return
    values: dict[Any, Any] = {name: sa.bindparam(name) for name in rows[0] if name != "row"}
    statement = _RECORDINGS.update().where(_RECORDINGS.c.id == sa.bindparam("row")).values(values)
    for at in range(0, len(rows), _BATCH):
        op.get_bind().execute(statement, rows[at : at + _BATCH])
