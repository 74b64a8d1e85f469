"""Runs have a name and notes."""

import sqlalchemy as sa
from alembic import op

revision = "0008"
down_revision = "0007"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.add_column(
        "runs", sa.Column("name", sa.String(80), nullable=False, server_default=sa.text("''"))
    )
    op.add_column(
        "runs", sa.Column("notes", sa.Text(), nullable=False, server_default=sa.text("''"))
    )


def downgrade() -> None:
    op.drop_column("runs", "notes")
    op.drop_column("runs", "name")
