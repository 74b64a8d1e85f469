"""Games made for a ranking that lacks variety are called varied play."""

import sqlalchemy as sa
from alembic import op

revision = "0007"
down_revision = "0006"
branch_labels = None
depends_on = None

_RECORDINGS = sa.table("recordings", sa.column("source", sa.String()))


def upgrade() -> None:
    _rename("random", "varied")


def downgrade() -> None:
    _rename("varied", "random")


def _rename(old: str, new: str) -> None:
    rows = sa.update(_RECORDINGS).where(_RECORDINGS.c.source == old)
    op.execute(rows.values(source=new))
