"""The field's standard names for stored values and columns."""

from typing import Any

import sqlalchemy as sa
from alembic import op

revision = "0003"
down_revision = "0002"
branch_labels = None
depends_on = None

RECIPE_NAMES = {
    "reward": {
        "snippet_pairs": "fragment_pairs",
        "snippet_min_steps": "fragment_min_steps",
        "snippet_max_steps": "fragment_max_steps",
        "disturbed_share": "perturbed_share",
        "disturbed_copies": "perturbed_copies",
    },
    "policy": {
        "n_games": "n_envs",
        "rollout_steps": "n_steps",
        "minibatches": "n_minibatches",
        "epochs": "n_epochs",
        "learning_rate_decays": "anneal_lr",
        "discount": "gamma",
        "gae": "gae_lambda",
        "clip": "clip_range",
        "entropy": "ent_coef",
        "value": "vf_coef",
        "gradient_norm": "max_grad_norm",
        "start_policy_pull": "kl_coef",
    },
    "cloning": {"left_out_share": "validation_share"},
}
SUMMARY_NAMES = {"hit_share": "death_rate"}
CURVE_NAMES = SUMMARY_NAMES | {
    "left_out_accuracy": "held_out_accuracy",
    "paid_return": "shaped_return",
    "pull": "kl_to_start",
}
CONDITION_NAMES = {"choice": "action_selection"}

RUNS = sa.table(
    "runs", sa.column("id"), sa.column("recipe", sa.JSON()), sa.column("outcome", sa.JSON())
)
METRICS = sa.table("metrics", sa.column("id"), sa.column("stage"), sa.column("values", sa.JSON()))
RECORDINGS = sa.table(
    "recordings", sa.column("id"), sa.column("source"), sa.column("conditions", sa.JSON())
)


def upgrade() -> None:
    op.execute("ALTER TABLE behaviours RENAME COLUMN ready_made TO built_in")
    _rename_selection("choice", "action_selection")
    _rename_stored(RECIPE_NAMES, SUMMARY_NAMES, CURVE_NAMES, CONDITION_NAMES)


def downgrade() -> None:
    op.execute("ALTER TABLE behaviours RENAME COLUMN built_in TO ready_made")
    _rename_selection("action_selection", "choice")
    _rename_stored(
        {part: _reversed(names) for part, names in RECIPE_NAMES.items()},
        _reversed(SUMMARY_NAMES),
        _reversed(CURVE_NAMES),
        _reversed(CONDITION_NAMES),
    )


def _reversed(names: dict[str, str]) -> dict[str, str]:
    return {new: old for old, new in names.items()}


def _rename_selection(old: str, new: str) -> None:
    unique = "uq_evaluations_run_id_policy_start_number_"
    with op.batch_alter_table("evaluations") as batch_op:
        batch_op.drop_constraint(unique + old, type_="unique")
        batch_op.alter_column(old, new_column_name=new)
    with op.batch_alter_table("evaluations") as batch_op:
        batch_op.create_unique_constraint(unique + new, ["run_id", "policy", "start_number", new])


def _rename_stored(
    recipe: dict[str, dict[str, str]],
    summary: dict[str, str],
    curves: dict[str, str],
    conditions: dict[str, str],
) -> None:
    connection = op.get_bind()
    for row in connection.execute(sa.select(RUNS)).all():
        values = {
            name: _renamed(part, recipe.get(name, {})) if isinstance(part, dict) else part
            for name, part in row.recipe.items()
        }
        outcome = dict(row.outcome)
        if "headline" in outcome:
            outcome["headline"] = {
                policy: _renamed(means, summary) if isinstance(means, dict) else means
                for policy, means in outcome["headline"].items()
            }
        connection.execute(
            RUNS.update().where(RUNS.c.id == row.id).values(recipe=values, outcome=outcome)
        )
    policies = METRICS.c.stage.in_(("clone", "imitator"))
    _rewrite(
        METRICS, "values", sa.select(METRICS.c.id, METRICS.c["values"]).where(policies), curves
    )
    played = sa.select(RECORDINGS.c.id, RECORDINGS.c.conditions)
    _rewrite(RECORDINGS, "conditions", played.where(RECORDINGS.c.source == "policy"), conditions)


def _rewrite(
    table: sa.TableClause,
    column: str,
    rows: sa.Select[Any],
    names: dict[str, str],
) -> None:
    connection = op.get_bind()
    changed = [
        {"row": number, "content": _renamed(content, names)}
        for number, content in connection.execute(rows).all()
        if not names.keys().isdisjoint(content)
    ]
    if changed:
        connection.execute(
            table.update()
            .where(table.c.id == sa.bindparam("row"))
            .values({column: sa.bindparam("content", type_=sa.JSON())}),
            changed,
        )


def _renamed(values: dict[str, object], names: dict[str, str]) -> dict[str, object]:
    return {names.get(name, name): value for name, value in values.items()}
