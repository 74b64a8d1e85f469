"""A new run of a behaviour: what it may be, and the ranking frozen for it."""

from __future__ import annotations

import uuid

from sqlalchemy.orm import Session

from tril.analysis.outcome import RunSnapshot
from tril.demonstrators import SCRIPTED, kind_named
from tril.errors import Conflict, Invalid, NotFound
from tril.games import game_of
from tril.ranking import best_ranked
from tril.recipes import Recipe, recipe_from_dict, recipe_named
from tril.store import answers, audit, behaviours, rankings, recordings
from tril.store.changes import note_change
from tril.store.database import database_now
from tril.store.models import RunDevice, RunRow, RunStatus
from tril.store.training import artifacts, runs


def create_run(
    session: Session,
    behaviour_id: int,
    recipe: Recipe,
    steps: int | None,
    training_seed: int,
    go_on_anyway: bool = False,
    example: bool = False,
    player_id: int | None = None,
    example_kind: str = SCRIPTED.name,
    parent_run_id: str | None = None,
    max_queued: int | None = None,
    max_queued_of_player: int | None = None,
    max_of_player: int | None = None,
    device: RunDevice = RunDevice.ANY,
) -> RunRow:
    """Make a queued run with a frozen snapshot of the behaviour's ranking.

    It waits until ``tril.jobs`` has enqueued it, which also happens after a crash in between.

    Args:
        session: The transaction.
        behaviour_id: Behaviour to teach.
        recipe: Recipe of the run; stored in full.
        steps: Steps of the imitator's training games; None for what the recipe proposes.
        training_seed: Feeds every random choice of learning.
        go_on_anyway: Whether the imitator is trained even when the check of the ranking fails.
        example: Whether missing scripted demonstrations are made and ranked first; the snapshot is
            frozen once they exist.
        player_id: Player that starts the run.
        example_kind: Which demonstrations an example has, see tril.demonstrators.KINDS.
        parent_run_id: The run whose imitator PPO begins with, in place of the run's own clone.
        max_queued: Most runs that may wait in the queue; None for any number.
        max_queued_of_player: Most of those that may be this person's.
        max_of_player: Most runs of this person that may be stored, deleted ones included.
        device: Which workers may take it.

    Raises:
        NotFound: No such behaviour or parent.
        Invalid: The ranking or the perfect demonstrations don't suffice, or the recipe does not
            allow this behaviour, this parent or this many steps.
        Conflict: The parent has no imitator yet.
    """
    behaviour = behaviours.get(session, behaviour_id)
    if steps is None:
        steps = recipe.proposed_steps(ordered=behaviour.ordered)
    if recipe.needs_pretrained and not game_of(behaviours.as_behaviour(behaviour)).pretrained:
        recipe_named(recipe.name, pretrained=False)
        raise Invalid(
            "The recipe needs networks that have learned to read the game's screens, which this"
            " game does not have: set reward.method=paper, cloning.pretrained=false and"
            " policy.mixed_start=false."
        )
    if steps < 1:
        raise Invalid(f"Expected at least one step, got {steps}.")
    if parent_run_id is not None:
        _refuse_unfit_parent(session, behaviour_id, recipe, parent_run_id)
    elif recipe.policy.warm_start and recipe.cloning.network != recipe.policy.network:
        raise Invalid(
            f"policy.warm_start=true begins with the clone, whose network"
            f" {recipe.cloning.network!r} is not that of the imitator, {recipe.policy.network!r}."
            " Set policy.network and cloning.network to the same one."
        )
    if max_queued is not None and runs.count_queued(session) >= max_queued:
        raise Conflict(
            f"{max_queued} runs are waiting already, and no more may. Wait until one has begun, or"
            " cancel one."
        )
    if (
        max_queued_of_player is not None
        and player_id is not None
        and runs.count_queued(session, RunRow.player_id == player_id) >= max_queued_of_player
    ):
        raise Conflict(
            f"{max_queued_of_player} of your runs are waiting already, and no more may. Wait until"
            " one has begun, or cancel one. Whoever runs this server can allow more"
            " (TRIL_MAX_QUEUED_RUNS_PER_PLAYER)."
        )
    if max_of_player is not None and player_id is not None:
        _refuse_too_many(session, player_id, max_of_player)
    row = RunRow(
        id=str(uuid.uuid4()),
        # By which those that wait are ordered, whichever machine they were made on.
        created_at=database_now(session),
        behaviour_id=behaviour_id,
        player_id=player_id,
        parent_run_id=parent_run_id,
        example=example,
        example_kind=kind_named(example_kind).name,
        recipe_name=recipe.name,
        recipe=recipe.to_dict(),
        training_seed=training_seed,
        steps=steps,
        go_on_anyway=go_on_anyway,
        snapshot=None if example else freeze_ranking(session, behaviour_id),
        device=device,
        status=RunStatus.QUEUED,
    )
    session.add(row)
    session.flush()
    audit.note(
        session,
        audit.Action.RUN_QUEUED,
        player_id,
        f"run {row.id}",
        behaviour=behaviour_id,
        recipe=recipe.name,
    )
    note_change(session, "run", row.id)
    return row


def _refuse_too_many(session: Session, player_id: int, limit: int) -> None:
    n_stored = runs.count_of_player(session, player_id)
    if n_stored >= limit:
        raise Conflict(
            f"{n_stored} runs of yours are stored, deleted ones included, and no more may be."
            " Whoever runs this server can allow more (TRIL_MAX_RUNS_PER_PLAYER)."
        )


def _refuse_unfit_parent(
    session: Session, behaviour_id: int, recipe: Recipe, parent_run_id: str
) -> None:
    """Raise unless a run of the behaviour by this recipe can begin with the parent's imitator."""
    parent = runs.get(session, parent_run_id)
    if parent.behaviour_id != behaviour_id:
        raise Invalid(
            "The training to continue from teaches another behaviour. Choose one of this behaviour."
        )
    if recipe.method != "ppo" or not recipe.policy.warm_start:
        raise Invalid(
            f"The recipe {recipe.name} can't continue from an imitator: it does not train by PPO"
            " with a warm start. Choose one that does, such as fast."
        )
    its_network = recipe_from_dict(parent.recipe).policy.network
    if its_network != recipe.policy.network:
        raise Invalid(
            f"The imitator to continue from has the network {its_network!r}, but the recipe"
            f" {recipe.name} trains {recipe.policy.network!r}. Choose a recipe with the same one."
        )
    try:
        artifacts.of_kind(session, parent_run_id, "imitator")
    except NotFound as missing:
        raise Conflict(
            "The training to continue from has no imitator yet. Let it train its imitator first,"
            " or choose another training."
        ) from missing


def freeze_ranking(session: Session, behaviour_id: int) -> RunSnapshot:
    """Freeze a behaviour's ranking, perfect demonstrations and answers for a run.

    Where none is marked as perfect, the best ranked recordings are what the clone copies.

    Raises:
        Invalid: They don't suffice for learning.
    """
    row = rankings.current(session, behaviour_id)
    ranking = rankings.as_ranking(row)
    if len(ranking.tiers) < 2:
        raise Invalid(
            "Learning needs recordings in at least two tiers. Play some good and some bad games "
            "and put them into an order first."
        )
    rankings.refuse_unrankable(session, behaviour_id, ranking)
    tiers = [list(tier) for tier in ranking.tiers]
    marked = recordings.perfect_ids(session, behaviour_id)
    return RunSnapshot(
        ranking_revision=row.revision,
        tiers=tiers,
        perfect=marked or best_ranked(tiers),
        none_marked=not marked,
        answers=answers.current(session, behaviour_id),
    )
