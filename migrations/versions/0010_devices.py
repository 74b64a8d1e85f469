"""Runs say which device they need."""

import sqlalchemy as sa
from alembic import op

revision = "0010"
down_revision = "0009"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.add_column(
        "runs", sa.Column("device", sa.String(8), nullable=False, server_default=sa.text("'any'"))
    )


def downgrade() -> None:
    op.drop_column("runs", "device")
