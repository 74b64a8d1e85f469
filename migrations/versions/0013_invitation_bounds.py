"""An invitation lets in so many people, until some day; those made before have no bounds."""

import sqlalchemy as sa
from alembic import op

revision = "0013"
down_revision = "0012"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.add_column("invitations", sa.Column("max_uses", sa.Integer()))
    op.add_column("invitations", sa.Column("expires_at", sa.DateTime(timezone=True)))


def downgrade() -> None:
    op.drop_column("invitations", "expires_at")
    op.drop_column("invitations", "max_uses")
