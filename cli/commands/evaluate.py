"""``tril evaluate``: evaluate a trained policy from chosen evaluation starts."""

from __future__ import annotations

from typing import Annotated, Any

import typer
from rich.table import Table

from cli.output import JsonOption, console, print_json
from cli.progress import progress_bar
from cli.workspace import Workspace, open_workspace
from tril.analysis.summary import GameFigures, Policy, summarise
from tril.errors import Invalid
from tril.files.artifact_store import ArtifactStore
from tril.games import game_of
from tril.games.base import MAX_EVALUATION_STARTS
from tril.games.behaviours import Behaviour, score
from tril.recipes import recipe_from_dict
from tril.store import behaviours
from tril.store.training import artifacts, runs
from tril.store.training.evaluations import ActionSelection


def evaluate(
    run_id: Annotated[str, typer.Argument(help="A run with trained policies.")],
    policy: Annotated[Policy, typer.Option(help="The policy to evaluate.")] = "imitator",
    action_selection: Annotated[
        ActionSelection, typer.Option(help="How the policy selects actions.")
    ] = "greedy",
    starts: Annotated[str, typer.Option(help="Evaluation starts, e.g. 0,1,2 or 0-31.")] = "0-22",
    sticky: Annotated[
        float | None,
        typer.Option(
            min=0,
            max=1,
            help="Probability of repeating the previous frame's action. Default: 0.25 if the"
            " selection is sticky.",
        ),
    ] = None,
    sampling_seed: Annotated[
        int, typer.Option(min=0, max=2**31 - 1, help="Seed of all random draws.")
    ] = 0,
    as_json: JsonOption = False,
) -> None:
    """Play one game from each evaluation start with a trained policy; store nothing."""
    with open_workspace() as workspace:
        numbers = _numbers(starts)
        behaviour, games = _play(
            workspace, run_id, policy, action_selection, numbers, sticky, sampling_seed
        )
        figures = [_figures(behaviour, game) for game in games]
        if as_json:
            for number, game in zip(numbers, figures, strict=True):
                print_json({"start_number": number} | vars(game))
            return
        table = Table("start", "end", box=None, title=behaviour.name, title_justify="left")
        for title in ("targets", "strays", "order errors", "steps", "predicted return"):
            table.add_column(title, justify="right")
        for number, game, game_figures in zip(numbers, games, figures, strict=True):
            counts = (
                game_figures.targets,
                game_figures.strays,
                game_figures.order_errors,
                game_figures.steps,
            )
            cells = ("" if value is None else str(value) for value in counts)
            table.add_row(str(number), game.end, *cells, f"{game_figures.predicted_return:.1f}")
        console.print(table)
        _print_means(figures)


def _play(
    workspace: Workspace,
    run_id: str,
    policy: Policy,
    action_selection: ActionSelection,
    numbers: list[int],
    sticky: float | None,
    sampling_seed: int,
) -> tuple[Behaviour, list[Any]]:
    from trainer.policy.evaluation import beginnings, play
    from trainer.policy.networks import load_policy
    from trainer.reward.model import RewardModel

    database = workspace.database
    store = ArtifactStore(workspace.settings.artifact_root)
    with database.reading() as session:
        run = runs.get(session, run_id)
        behaviour = behaviours.as_behaviour(behaviours.get(session, run.behaviour_id))
    recipe = recipe_from_dict(run.recipe)
    game = game_of(behaviour)
    with artifacts.local_file(database, store, run_id, policy) as path:
        actor = load_policy(path)
    with artifacts.local_file(database, store, run_id, "reward_model") as path:
        model = RewardModel.load(path)
    with progress_bar("playing") as watched:
        games = play(
            game,
            actor,
            beginnings(game, recipe.evaluation, numbers),
            action_selection,
            model=model,
            end_rule=recipe.ending,
            sampling_seed=sampling_seed,
            sticky_action_probability=sticky,
            progress=watched,
        )
    return behaviour, games


def _figures(behaviour: Behaviour, game: Any) -> GameFigures:
    result = score(behaviour, tuple(item.cell for item in game.taken))
    return GameFigures(
        targets=result.targets if result else None,
        strays=result.strays if result else None,
        order_errors=result.order_errors if result else None,
        steps=game.recording.n_steps,
        died=game_of(behaviour).is_death(game.end),
        predicted_return=game.predicted_return,
        n_targets=None if behaviour.target is None else len(behaviour.target),
    )


def _print_means(figures: list[GameFigures]) -> None:
    summary = summarise(figures)
    for name, value in (
        ("targets", summary.targets),
        ("strays", summary.strays),
        ("death rate", summary.death_rate),
        ("perfect games", summary.perfect),
    ):
        if value is not None:
            console.print(
                f"{name}: {value.mean:.2f}, 95% interval {value.low:.2f} to {value.high:.2f}"
            )


def _numbers(text: str) -> list[int]:
    """Parse "0,1,2", "0-31" or a mixture."""
    numbers: list[int] = []
    try:
        for part in text.split(","):
            first, dash, last = part.partition("-")
            if int(last or first) >= MAX_EVALUATION_STARTS:
                raise ValueError
            numbers += range(int(first), int(last) + 1) if dash else [int(first)]
    except ValueError:
        raise Invalid(f"Expected starts such as 0,1,2 or 0-31, got {text[:60]!r}.") from None
    if not numbers or len(set(numbers)) != len(numbers):
        raise Invalid(f"Expected each start once and at least one, got {text[:60]!r}.")
    return numbers
