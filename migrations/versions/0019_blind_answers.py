"""What people did in blind comparisons of the games of runs."""

import sqlalchemy as sa
from alembic import op

revision = "0019"
down_revision = "0018"
branch_labels = None
depends_on = None


def _reference(column: str, table: str) -> sa.ForeignKeyConstraint:
    name = f"fk_blind_answers_{column}_{table}"
    return sa.ForeignKeyConstraint([column], [f"{table}.id"], name=name)


def upgrade() -> None:
    op.create_table(
        "blind_answers",
        sa.Column("id", sa.Integer(), nullable=False),
        sa.Column("run_id", sa.String(36), nullable=False),
        sa.Column("player_id", sa.Integer(), nullable=True),
        sa.Column("round", sa.Integer(), nullable=False),
        sa.Column("pair", sa.Integer(), nullable=False),
        sa.Column("imitator_id", sa.Integer(), nullable=False),
        sa.Column("other_id", sa.Integer(), nullable=False),
        sa.Column("imitator_left", sa.Boolean(), nullable=False),
        sa.Column("answer", sa.String(16), nullable=False),
        sa.Column("created_at", sa.DateTime(timezone=True), nullable=False),
        _reference("run_id", "runs"),
        _reference("player_id", "players"),
        _reference("imitator_id", "recordings"),
        _reference("other_id", "recordings"),
        sa.PrimaryKeyConstraint("id", name="pk_blind_answers"),
    )
    op.create_index("ix_blind_answers_run_id", "blind_answers", ["run_id"])


def downgrade() -> None:
    op.drop_table("blind_answers")
