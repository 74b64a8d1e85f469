"""Names that people gave to the things of games."""

import sqlalchemy as sa
from alembic import op

revision = "0021"
down_revision = "0020"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "thing_names",
        sa.Column("id", sa.Integer(), nullable=False),
        sa.Column("game", sa.String(160), nullable=False),
        sa.Column("thing", sa.String(80), nullable=False),
        sa.Column("name", sa.String(40), nullable=False),
        sa.Column("player_id", sa.Integer(), nullable=True),
        sa.Column("created_at", sa.DateTime(timezone=True), nullable=False),
        sa.ForeignKeyConstraint(
            ["player_id"], ["players.id"], name="fk_thing_names_player_id_players"
        ),
        sa.PrimaryKeyConstraint("id", name="pk_thing_names"),
    )
    op.create_index("ix_thing_names_game", "thing_names", ["game"])


def downgrade() -> None:
    op.drop_table("thing_names")
