"""What a finished run shows, as a page of Markdown with pictures, for a folder of results."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from trainer.policy.evaluation import STICKY_ACTION_PROBABILITY
from trainer.reporting.figures import (
    COLOURS,
    PlayedColumn,
    comparison_figure,
    curves_figure,
    extrapolation_figure,
    returns_figure,
)
from trainer.reporting.reward_report import (
    EXTRAPOLATION,
    QUANTITY,
    alarm_lines,
    extrapolation_lines,
    warning_lines,
)
from tril.analysis.extrapolation import JudgedGames
from tril.analysis.outcome import AttentionState, RunOutcome
from tril.analysis.reward_alarm import RewardAlarm
from tril.analysis.summary import Interval, PolicySummary, winner
from tril.behaviours import Behaviour, Cell, score
from tril.demonstrator import kind_named
from tril.files.artifact_store import ArtifactStore, write_whole
from tril.game.episode import DEATHS
from tril.recipes import Recipe, recipe_from_dict
from tril.store import behaviours, recordings
from tril.store.database import Database
from tril.store.models import ArtifactRow, EvaluationRow, RecordingRow, RunRow
from tril.store.training import artifacts, evaluations, metrics, runs
from tril.store.training.alarms import alarm_of
from tril.store.training.evaluations import POLICIES
from tril.store.training.metrics import Series
from tril.store.training.returns import judged_games


@dataclass(frozen=True)
class _Facts:
    run: RunRow
    behaviour: Behaviour
    recipe: Recipe
    tiers: list[list[int]]
    demonstrations: dict[int, RecordingRow]
    games: list[EvaluationRow]
    files: list[ArtifactRow]
    curves: Series
    judged: list[JudgedGames]
    alarm: RewardAlarm | None

    @property
    def best(self) -> RecordingRow | None:
        """The first demonstration of the best tier."""
        return self.demonstrations.get(self.tiers[0][0]) if self.tiers else None

    def game(self, policy: str, start_number: int) -> EvaluationRow | None:
        """The greedy game of a policy from a start."""
        for row in self.games:
            if (row.policy, row.start_number, row.action_selection) == (
                policy,
                start_number,
                "greedy",
            ):
                return row
        return None


def write_report(database: Database, store: ArtifactStore, run_id: str, folder: Path) -> Path:
    """Write ``README.md`` and its pictures into a folder.

    Args:
        database: The application's database.
        store: The artifact store.
        run_id: A run that is done.
        folder: Where to; made if it isn't there, files of the same names are replaced.

    Returns:
        The page's path.

    Raises:
        NotFound: No such run.
    """
    facts = _facts(database, run_id)
    pictures = _pictures(facts)
    pictures |= {
        row.name: store.get(row.path) for row in facts.files if row.kind.startswith("attention_")
    }
    for name, content in pictures.items():
        write_whole(folder / name, content)
    page = folder / "README.md"
    write_whole(page, _page(facts, pictures.keys()).encode())
    return page


def _facts(database: Database, run_id: str) -> _Facts:
    with database.reading() as session:
        run = runs.get(session, run_id)
        tiers = run.snapshot.tiers if run.snapshot else []
        _, curves = metrics.series(session, run_id)
        games = evaluations.listing(session, run_id)
        return _Facts(
            run=run,
            behaviour=behaviours.as_behaviour(behaviours.get(session, run.behaviour_id)),
            recipe=recipe_from_dict(run.recipe),
            tiers=tiers,
            demonstrations=recordings.by_ids(session, [i for tier in tiers for i in tier]),
            games=games,
            files=artifacts.listing(session, run_id),
            curves=curves,
            judged=judged_games(session, run, games),
            alarm=alarm_of(session, run),
        )


def describe_example(outcome: RunOutcome) -> str:
    """Say of what kind a run's demonstrations are, and how right their ranking is.

    Args:
        outcome: The run's.

    Returns:
        A sentence or two; nothing for the ordinary example and for a person's demonstrations.
    """
    example = outcome.example
    if example is None:
        return ""
    n_wrong = len(example.mistakes)
    order = (
        f"{n_wrong} pairs of neighbours are ranked the wrong way round (tau {example.tau:.2f}"
        " with what the games show)."
        if n_wrong
        else "They are ranked without mistakes."
    )
    kind = kind_named(example.kind)
    return f"The demonstrations are of the kind `{kind.name}`: {kind.summary}. {order}"


def _pictures(facts: _Facts) -> dict[str, bytes]:
    starts = facts.recipe.evaluation.start_numbers
    columns = [
        PlayedColumn(
            policy,
            policy.capitalize(),
            tuple(_cells(game.recording) if game else None for game in games),
        )
        for policy in POLICIES
        for games in [[facts.game(policy, number) for number in starts]]
    ]
    if facts.best is not None:
        thing = "demonstrator" if facts.best.source == "scripted" else "person"
        columns.append(
            PlayedColumn(thing, "Best demonstration", (_cells(facts.best),) * len(starts))
        )
    names = [f"start {number}" for number in starts]
    pictures = {"aliens.png": comparison_figure(facts.behaviour, names, columns)}
    if check := facts.run.outcome.check:
        returns = _returns(facts)
        pictures["returns.png"] = returns_figure(
            [tier for tier, _, _ in returns], [value for _, _, value in returns], check.tau
        )
    points = facts.curves.get("imitator", {})
    shown = ("predicted_return", "hits", "strays", "death_rate")
    labels = ("predicted return", "targets hit", "strays", "games lost")
    curves = [
        (label, COLOURS["imitator"], points[name])
        for name, label in zip(shown, labels, strict=True)
        if name in points
    ]
    if facts.judged:
        pictures[EXTRAPOLATION] = extrapolation_figure(facts.judged, QUANTITY)
    # A training so short that no game ended has none.
    if curves:
        pictures["curves.png"] = curves_figure(curves, "steps of training games")
    return pictures


def _returns(facts: _Facts) -> list[tuple[int, int, float]]:
    """(tier from 1, recording id, predicted return) of each ranked demonstration."""
    check = facts.run.outcome.check
    values = check.predicted_returns if check else {}
    return [
        (place, number, values[number])
        for place, tier in enumerate(facts.tiers, start=1)
        for number in tier
        if number in values
    ]


def _page(facts: _Facts, pictures: Iterable[str]) -> str:
    parts = [*_head(facts), *_comparison(facts), *_means(facts), *_ranking(facts)]
    parts += extrapolation_lines(facts.judged)
    if "curves.png" in pictures:
        parts += ["## Training games", "", *alarm_lines(facts.alarm)]
        parts += ["![Curves of the training](curves.png)", ""]
    return "\n".join([*parts, *_attention(facts), *_origin(facts)])


def _head(facts: _Facts) -> list[str]:
    run, seconds = facts.run, facts.run.finished_stages
    stages = ", ".join(f"{name} {seconds[name]:.0f} s" for name in seconds)
    people = {row.source for row in facts.demonstrations.values()}
    made = (
        "The demonstrations were played by the scripted demonstrator, not by a person."
        if people == {"scripted"}
        else "The demonstrations were played by a person."
        if people == {"person"}
        else f"The demonstrations are of these sources: {', '.join(sorted(people))}."
    )
    return [
        f"# {facts.behaviour.name}",
        "",
        facts.behaviour.description,
        "",
        f"Recipe `{run.recipe_name}`, {run.steps:,} steps, training seed {run.training_seed}."
        f" {made} {describe_example(run.outcome)}".rstrip(),
        "",
        f"Time by stage: {stages}.",
        "",
    ]


def _comparison(facts: _Facts) -> list[str]:
    lines = [
        "## Evaluation starts",
        "",
        "Greedy games from starts that no demonstration and no training game began from, unless"
        " marked as seen. Squares are aliens left, rings targets hit, crosses strays. The best"
        " demonstration began from its own start.",
        "",
        "![Aliens left after each game](aliens.png)",
        "",
        "| start | imitator | clone | winner |",
        "|---|---|---|---|",
    ]
    for number in facts.recipe.evaluation.start_numbers:
        games = [facts.game(policy, number) for policy in POLICIES]
        figures = [None if game is None else evaluations.figures_of(game) for game in games]
        who = winner(*figures)
        seen = "" if all(game.held_out for game in games if game) else " (seen)"
        cells = " | ".join(_game(facts.behaviour, game) for game in games)
        lines.append(f"| {number}{seen} | {cells} | {who or ''} |")
    return [*lines, ""]


def _means(facts: _Facts) -> list[str]:
    lines = [
        "Means over all held-out starts, with 95% bootstrap intervals. Greedy: the policy takes the"
        " likeliest action; sampled: it draws by the probabilities; sticky: it takes the likeliest"
        f" one, and at every frame the machine repeats the last action with probability"
        f" {STICKY_ACTION_PROBABILITY}.",
        "",
        "| policy | actions | games | targets | strays | lost to a bomb | steps |",
        "|---|---|---:|---:|---:|---:|---:|",
    ]
    for (policy, action_selection), summary in evaluations.summaries(facts.games).items():
        lines.append(f"| {policy} | {action_selection} | {summary.steps.n} | {_summary(summary)} |")
    return [*lines, ""]


def _ranking(facts: _Facts) -> list[str]:
    check = facts.run.outcome.check
    if check is None:
        return []
    held_out = check.held_out_accuracy
    lines = [
        "## What the reward model makes of the ranking",
        "",
        f"Kendall's tau {check.tau:.3f}; fragment pairs ordered as ranked"
        f" {check.pair_accuracy:.1%}; pairs of demonstrations that were left out of learning"
        f" {'not measured' if held_out is None else f'{held_out:.1%}'}.",
        "",
        *warning_lines(check.warning),
        "![Predicted return against rank](returns.png)",
        "",
        "| rank | hits | predicted return |",
        "|---:|---|---:|",
    ]
    for place, number, value in _returns(facts):
        hits = _counted(facts.behaviour, _cells(facts.demonstrations[number]))
        lines.append(f"| {place} | {hits} | {value:.1f} |")
    return [*lines, ""]


def _attention(facts: _Facts) -> list[str]:
    rewards = {
        row.details["state"]: row.details["reward"]
        for row in facts.files
        if row.kind == "attention_map"
    }
    if not rewards:
        return []
    kinds = {(row.kind, row.details.get("state")): row.name for row in facts.files}
    states = [state for state in AttentionState if state in rewards]

    def row_of(kind: str) -> str:
        cells = (f"![{state}]({kinds[kind, state]})" for state in states)
        return f"| {' | '.join(cells)} |"

    return [
        "## Where the reward model looks",
        "",
        f"| {' | '.join(f'{state} (R = {rewards[state]:.2f})' for state in states)} |",
        f"|{'---|' * len(states)}",
        row_of("attention_map"),
        row_of("attention_frame"),
        "",
    ]


def _origin(facts: _Facts) -> list[str]:
    versions = ", ".join(f"{name} {version}" for name, version in facts.run.versions.items())
    return [f"Versions: {versions}.", ""]


def _game(behaviour: Behaviour, game: EvaluationRow | None) -> str:
    if game is None:
        return "not played"
    end = "lost to a bomb" if game.recording.end in DEATHS else "alive"
    return f"{_counted(behaviour, _cells(game.recording))}, {end}"


def _counted(behaviour: Behaviour, cells: tuple[Cell, ...]) -> str:
    result = score(behaviour, cells)
    if result is None or behaviour.target is None:
        return f"{len(cells)} aliens"
    text = f"{result.targets}/{len(behaviour.target)} targets, {result.strays} strays"
    return text + (f", {result.order_errors} out of order" if behaviour.ordered else "")


def _summary(summary: PolicySummary) -> str:
    def cell(value: Interval | None, form: str = ".2f") -> str:
        if value is None:
            return ""
        return f"{value.mean:{form}} [{value.low:{form}}, {value.high:{form}}]"

    parts: Sequence[str] = (
        cell(summary.targets),
        cell(summary.strays),
        cell(summary.death_rate, ".0%"),
        cell(summary.steps, ".0f"),
    )
    return " | ".join(parts)


def _cells(row: RecordingRow) -> tuple[Cell, ...]:
    return tuple((r, c) for r, c, _ in row.hits)
