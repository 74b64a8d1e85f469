"""Evaluation games keep the level of the reward that they end at."""

import sqlalchemy as sa
from alembic import op

revision = "0011"
down_revision = "0010"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.add_column("evaluations", sa.Column("final_level", sa.Float()))


def downgrade() -> None:
    op.drop_column("evaluations", "final_level")
