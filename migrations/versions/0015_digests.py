"""Files of runs have a digest, by which damage is noticed."""

import sqlalchemy as sa
from alembic import op

revision = "0015"
down_revision = "0014"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.add_column("artifacts", sa.Column("sha256", sa.String(64)))


def downgrade() -> None:
    op.drop_column("artifacts", "sha256")
