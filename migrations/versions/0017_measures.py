"""Measures of behaviours, and their values of each recording."""

import sqlalchemy as sa
from alembic import op

revision = "0017"
down_revision = "0016"
branch_labels = None
depends_on = None


def upgrade() -> None:
    measures = sa.Column("measures", sa.JSON(), nullable=False, server_default="[]")
    op.add_column("behaviours", measures)
    measured = sa.Column("measured", sa.JSON(), nullable=False, server_default="{}")
    op.add_column("recordings", measured)


def downgrade() -> None:
    op.drop_column("recordings", "measured")
    op.drop_column("behaviours", "measures")
