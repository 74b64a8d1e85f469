"""The kind of the example that a run learns from."""

import sqlalchemy as sa
from alembic import op

revision = "0002"
down_revision = "0001"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.add_column(
        "runs",
        sa.Column("example_kind", sa.String(length=24), server_default="scripted", nullable=False),
    )


def downgrade() -> None:
    op.drop_column("runs", "example_kind")
