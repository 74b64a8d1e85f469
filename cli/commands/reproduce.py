"""``tril reproduce``: computes the results that a folder's ledger lacks, and writes its pages."""

from __future__ import annotations

import json
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from cli.commands.runs import chosen_recipe, start_run
from cli.follow import StandbyWorker, follow_to_end, standby_worker
from cli.output import console, errors
from cli.score_example import MAX_GAMES, MIN_GAMES, print_scores, score_example
from cli.workspace import Workspace, open_workspace
from tril.errors import Invalid
from tril.files.artifact_store import ArtifactStore, write_whole
from tril.games import game_named, game_of, published
from tril.recipes import FAST, PAPER, RECIPES, Recipe, evaluated_on_own_start, recipe_from_dict
from tril.store import behaviours
from tril.store.models import RunRow, RunStatus
from tril.store.training import runs

if TYPE_CHECKING:
    from trainer.reporting.ledger import LedgerCell

POLL_S = 2.0
SCORE_ALONE = (
    "--score has demonstrations of its own: leave out --behaviour, --own-starts and --page-only."
)

_BEHAVIOURS = {behaviour.slug: behaviour for behaviour in published()}


def reproduce(
    behaviour: Annotated[
        list[str] | None,
        typer.Option("--behaviour", "-b", help="Short name; may be repeated. Default: all seven."),
    ] = None,
    training_seed: Annotated[
        list[int] | None,
        typer.Option(
            "--training-seed",
            "--seed",
            "-s",
            help="May be repeated. Default: 0, 1, 2, with --score 0.",
        ),
    ] = None,
    recipe: Annotated[
        str,
        typer.Option(
            help=f"One of {', '.join(RECIPES)}. Default: {FAST.name}, with --score {PAPER.name}."
        ),
    ] = "",
    steps: Annotated[
        int | None, typer.Option(min=1, help="PPO steps. Default: what the recipe proposes.")
    ] = None,
    value: Annotated[
        list[str] | None, typer.Option("--set", help="Change the recipe: NAME=VALUE.")
    ] = None,
    own_starts: Annotated[
        bool,
        typer.Option(
            "--own-starts",
            help="The published protocol: for each of the starts 0, 1, 2 an imitator that is"
            " trained and evaluated on that start alone.",
        ),
    ] = False,
    score: Annotated[
        str | None,
        typer.Option(
            "--score",
            metavar="GAME",
            help="T-REX's own experiment in a game, as `tril games list` names it: games of varied"
            " play, ranked by the game's score. Reports what imitator and clone score.",
        ),
    ] = None,
    games: Annotated[
        int,
        typer.Option(min=MIN_GAMES, max=MAX_GAMES, help="With --score: games that are ranked."),
    ] = 24,
    output: Annotated[
        Path,
        typer.Option(
            "--output",
            "-o",
            help="Folder of ledger, pages and pictures. To go on from the ledger of another folder,"
            " such as docs/results, copy its ledger.jsonl there first.",
        ),
    ] = Path("results"),
    page_only: Annotated[
        bool, typer.Option("--page-only", help="Train nothing; write the page from the ledger.")
    ] = False,
) -> None:
    """Train what the ledger lacks, for each behaviour and training seed, and write the results.

    Each finished result is written at once: the command can be stopped at any time and continues
    where it was. Runs are queued like any other, so more workers make it faster.
    """
    from trainer.reporting.ledger import Ledger
    from trainer.reporting.results_page import write_page

    if score is not None:
        with open_workspace() as workspace:
            if behaviour or own_starts or page_only:
                raise Invalid(SCORE_ALONE)
            game = game_named(score)
            chosen = chosen_recipe(recipe or PAPER.name, value, game)
            for seed in training_seed or [0]:
                slug = score_example(workspace, game, games, seed)
                run_id = _run_on_ranking(workspace, slug, chosen, steps, seed)
                follow_to_end(workspace, run_id)
                folder = _write_scores(workspace, run_id, output)
                console.print(f"Results: {folder}", soft_wrap=True)
        return
    chosen = chosen_recipe(recipe, value, game_of(published()[0]))
    slugs = behaviour or list(_BEHAVIOURS)
    if unknown := [slug for slug in slugs if slug not in _BEHAVIOURS]:
        raise typer.BadParameter(
            f"There is no scripted example of {', '.join(unknown)}; choose among"
            f" {', '.join(_BEHAVIOURS)}."
        )
    with open_workspace() as workspace:
        recipes = _recipes(chosen, own_starts=own_starts)
        cells = cells_of(recipes, slugs, training_seed or [0, 1, 2], steps)
        missing = [] if page_only else Ledger(output).missing(cells)
        if missing:
            errors.print(f"{len(missing)} of {len(cells)} results are missing.")
            with standby_worker(workspace) as worker:
                chosen_cells = {cell: cells[cell] for cell in missing}
                failed = _compute(workspace, chosen_cells, output, worker)
        else:
            failed = 0
        page = write_page(output)
        console.print(f"Results: {page}", soft_wrap=True)
        if failed:
            raise Invalid(
                f"{failed} of {len(missing)} runs were not finished; see tril runs list. Run the"
                " command again to repeat them."
            )


def _run_on_ranking(
    workspace: Workspace, slug: str, recipe: Recipe, steps: int | None, training_seed: int
) -> str:
    """Return the newest run on a behaviour's ranking that is done or not over, else a new one."""
    key = (recipe, steps or recipe.proposed_steps(ordered=False), training_seed)
    with workspace.database.reading() as session:
        for row in runs.listing(session, behaviours.by_slug(session, slug).id):
            is_usable = row.status == RunStatus.DONE or not RunStatus(row.status).is_over
            if not is_usable or row.example or row.parent_run_id is not None:
                continue
            if (recipe_from_dict(row.recipe), row.steps, row.training_seed) == key:
                return row.id
    return start_run(workspace, slug, recipe, steps, training_seed, go_on_anyway=True)


def _write_scores(workspace: Workspace, run_id: str, output: Path) -> Path:
    """Print what a run's policies score; write it, and the run's page, and return the folder."""
    from trainer.reporting.results_page import cell_folder
    from trainer.reporting.run_entry import read_entry
    from trainer.reporting.run_report import write_report
    from trainer.reporting.score_results import read_scores

    result = read_scores(workspace.database, run_id)
    print_scores(result)
    folder = output / cell_folder(read_entry(workspace.database, run_id))
    store = ArtifactStore(workspace.settings.artifact_root)
    write_report(workspace.database, store, run_id, folder)
    write_whole(folder / "scores.json", json.dumps(result.to_json(), indent=1).encode() + b"\n")
    return folder


def cells_of(
    recipes: Sequence[Recipe],
    slugs: Sequence[str],
    training_seeds: Sequence[int],
    steps: int | None,
) -> dict[LedgerCell, Recipe]:
    """Return the results to be computed, in this order, and the recipe of each.

    Args:
        recipes: The recipes to train.
        slugs: Short names of built-in behaviours.
        training_seeds: Seeds of all random choices.
        steps: Steps of the imitator's training; None takes what a recipe proposes.
    """
    from trainer.reporting.ledger import LedgerCell

    return {
        LedgerCell.of(
            slug,
            recipe,
            steps or recipe.proposed_steps(ordered=_BEHAVIOURS[slug].ordered),
            seed,
        ): recipe
        for seed in training_seeds
        for slug in slugs
        for recipe in recipes
    }


def _recipes(chosen: Recipe, *, own_starts: bool) -> list[Recipe]:
    """Return the recipes to be trained: the chosen one, or one for each start."""
    if not own_starts:
        return [chosen]
    return [evaluated_on_own_start(chosen, number) for number in chosen.evaluation.start_numbers]


def _compute(
    workspace: Workspace, cells: Mapping[LedgerCell, Recipe], output: Path, worker: StandbyWorker
) -> int:
    """Train the cells and write each into the ledger when it is done; return how many failed."""
    from trainer.reporting.ledger import Ledger
    from trainer.reporting.results_page import cell_folder, write_page
    from trainer.reporting.run_entry import read_entry
    from trainer.reporting.run_report import write_report

    store = ArtifactStore(workspace.settings.artifact_root)
    waiting = dict.fromkeys(_runs_of(workspace, cells))
    failed = 0
    while waiting:
        for run_id in list(waiting):
            with workspace.database.reading() as session:
                row = runs.get(session, run_id)
            if not RunStatus(row.status).is_over:
                continue
            del waiting[run_id]
            if row.status != RunStatus.DONE:
                errors.print(f"Run {run_id} is {row.status}. {row.message}")
                failed += 1
                continue
            entry = read_entry(workspace.database, run_id)
            write_report(workspace.database, store, run_id, output / cell_folder(entry))
            Ledger(output).add(entry)
            write_page(output)
            console.print(f"{cell_folder(entry)}: done")
        worker.ensure()
        time.sleep(POLL_S)
    return failed


def _runs_of(workspace: Workspace, cells: Mapping[LedgerCell, Recipe]) -> list[str]:
    """Return a run for each cell: the newest that is done or not over, else a new one."""
    from trainer.reporting.ledger import LedgerCell

    present: dict[LedgerCell, str] = {}
    with workspace.database.reading() as session:
        for slug in {cell.behaviour for cell in cells}:
            rows = runs.listing(session, behaviours.by_slug(session, slug).id)
            for row in filter(_is_usable, reversed(rows)):
                recipe = recipe_from_dict(row.recipe)
                cell = LedgerCell.of(slug, recipe, row.steps, row.training_seed, row.example_kind)
                present[cell] = row.id
    return [
        present.get(cell)
        or start_run(
            workspace,
            cell.behaviour,
            recipe,
            cell.steps,
            cell.training_seed,
            go_on_anyway=True,
            example=True,
            example_kind=cell.demonstrations,
        )
        for cell, recipe in cells.items()
    ]


def _is_usable(row: RunRow) -> bool:
    if not row.example or row.parent_run_id is not None:
        return False
    return row.status == RunStatus.DONE or not RunStatus(row.status).is_over
