"""The ending rule of a recording; where a process runs."""

import sqlalchemy as sa
from alembic import op

revision = "0004"
down_revision = "0003"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.add_column(
        "recordings",
        sa.Column("ending", sa.String(length=16), nullable=False, server_default="hit"),
    )
    for name, kind in (
        ("machine", sa.String(80)),
        ("pid", sa.Integer()),
        ("started", sa.String(32)),
    ):
        op.add_column("processes", sa.Column(name, kind, nullable=True))


def downgrade() -> None:
    with op.batch_alter_table("processes") as batch_op:
        for name in ("started", "pid", "machine"):
            batch_op.drop_column(name)
    with op.batch_alter_table("recordings") as batch_op:
        batch_op.drop_column("ending")
