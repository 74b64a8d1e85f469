"""The run whose imitator a run continues from."""

import sqlalchemy as sa
from alembic import op

revision = "0006"
down_revision = "0005"
branch_labels = None
depends_on = None


def upgrade() -> None:
    parent = sa.ForeignKey("runs.id", name="fk_runs_parent_run_id_runs")
    op.add_column(
        "runs",
        sa.Column("parent_run_id", sa.String(length=36), parent, nullable=True),
        # SQLite can't add a constraint afterwards; this way it has no name.
        inline_references=op.get_context().dialect.name == "sqlite",
    )


def downgrade() -> None:
    op.drop_column("runs", "parent_run_id")
