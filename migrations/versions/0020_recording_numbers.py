"""Numbers of recordings, from 1 on in each behaviour and in each run, which name them."""

import sqlalchemy as sa
from alembic import op

revision = "0020"
down_revision = "0019"
branch_labels = None
depends_on = None

_BATCH = 500
_INDEX = "ix_recordings_behaviour_id_run_id_number"
_RECORDINGS = sa.table(
    "recordings",
    *map(sa.column, ("id", "behaviour_id", "run_id", "state", "n_frames", "number")),
)


def upgrade() -> None:
    op.add_column("recordings", sa.Column("number", sa.Integer(), nullable=True))
    op.create_index(_INDEX, "recordings", ["behaviour_id", "run_id", "number"])
    columns = _RECORDINGS.c
    number = sa.func.row_number().over(
        partition_by=(columns.behaviour_id, columns.run_id), order_by=columns.id
    )
    # Games that are being played, or of which nothing was played, have no number yet.
    named = sa.select(columns.id, number).where(columns.state != "playing", columns.n_frames > 0)
    rows = [{"row": key, "named": number} for key, number in op.get_bind().execute(named)]
    statement = (
        _RECORDINGS.update()
        .where(columns.id == sa.bindparam("row"))
        .values({"number": sa.bindparam("named")})
    )
    for at in range(0, len(rows), _BATCH):
        op.get_bind().execute(statement, rows[at : at + _BATCH])


def downgrade() -> None:
    op.drop_index(_INDEX, "recordings")
    op.drop_column("recordings", "number")
