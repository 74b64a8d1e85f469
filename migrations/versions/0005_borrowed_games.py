"""The games that a behaviour has borrowed from others for its ranking."""

import sqlalchemy as sa
from alembic import op

revision = "0005"
down_revision = "0004"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "borrowed_games",
        sa.Column("behaviour_id", sa.Integer(), nullable=False),
        sa.Column("recording_id", sa.Integer(), nullable=False),
        sa.Column("added_at", sa.DateTime(timezone=True), nullable=False),
        sa.ForeignKeyConstraint(
            ["behaviour_id"], ["behaviours.id"], name="fk_borrowed_games_behaviour_id_behaviours"
        ),
        sa.ForeignKeyConstraint(
            ["recording_id"], ["recordings.id"], name="fk_borrowed_games_recording_id_recordings"
        ),
        sa.PrimaryKeyConstraint("behaviour_id", "recording_id", name="pk_borrowed_games"),
    )
    op.create_index("ix_borrowed_games_recording_id", "borrowed_games", ["recording_id"])


def downgrade() -> None:
    op.drop_table("borrowed_games")
