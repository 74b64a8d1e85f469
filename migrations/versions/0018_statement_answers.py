"""What people said of the statements that Tril made about their rankings."""

import sqlalchemy as sa
from alembic import op

revision = "0018"
down_revision = "0017"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "statement_answers",
        sa.Column("id", sa.Integer(), nullable=False),
        sa.Column("behaviour_id", sa.Integer(), nullable=False),
        sa.Column("player_id", sa.Integer(), nullable=True),
        sa.Column("subjects", sa.JSON(), nullable=False),
        sa.Column("sentence", sa.String(400), nullable=False),
        sa.Column("meant", sa.Boolean(), nullable=True),
        sa.Column("created_at", sa.DateTime(timezone=True), nullable=False),
        sa.ForeignKeyConstraint(
            ["behaviour_id"],
            ["behaviours.id"],
            name="fk_statement_answers_behaviour_id_behaviours",
        ),
        sa.ForeignKeyConstraint(
            ["player_id"], ["players.id"], name="fk_statement_answers_player_id_players"
        ),
        sa.PrimaryKeyConstraint("id", name="pk_statement_answers"),
    )
    op.create_index("ix_statement_answers_behaviour_id", "statement_answers", ["behaviour_id"])


def downgrade() -> None:
    op.drop_table("statement_answers")
