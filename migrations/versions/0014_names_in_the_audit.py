"""The audit log keeps the names of then, which a renaming changed in earlier entries."""

import sqlalchemy as sa
from alembic import op

revision = "0014"
down_revision = "0013"
branch_labels = None
depends_on = None

_NAMES = sa.text(
    "UPDATE audit SET player_name ="
    " (SELECT players.name FROM players WHERE players.id = audit.player_id)"
)


def upgrade() -> None:
    op.add_column("audit", sa.Column("player_name", sa.String(80)))
    is_sqlite = op.get_bind().dialect.name == "sqlite"
    if is_sqlite:
        op.execute("DROP TRIGGER audit_keeps_update")
    # What people are called now is all that is known of the entries so far.
    op.execute(_NAMES)
    if is_sqlite:
        op.execute(
            "CREATE TRIGGER audit_keeps_update BEFORE UPDATE ON audit "
            "BEGIN SELECT RAISE(ABORT, 'The audit log can only be added to.'); END"
        )


def downgrade() -> None:
    op.drop_column("audit", "player_name")
