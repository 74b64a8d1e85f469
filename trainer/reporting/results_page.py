"""The results of all finished cells as one page: tables, pictures, and links to each cell's own."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from trainer.reporting import extrapolation_results
from trainer.reporting.comparison_tables import ablation_lines, is_ablation, kinds_lines
from trainer.reporting.ledger import DEVICE, PRECISION, Entry, Ledger, LedgerGame
from trainer.reporting.result_groups import ResultGroup, group_results
from trainer.reporting.table_figures import AliensRow, ReturnsPanel, aliens_table, returns_table
from tril.analysis.summary import winner
from tril.behaviours import BUILT_IN, Behaviour, score
from tril.demonstrator import SCRIPTED
from tril.files.artifact_store import write_whole
from tril.recipes import RECIPES, EvaluationRecipe

STARTS = EvaluationRecipe().start_numbers
POLICIES = ("imitator", "clone")


def cell_folder(entry: Entry) -> str:
    """Return the name, below the results, of the folder with a cell's own page."""
    cell = entry.cell
    name = f"{cell.behaviour}/{cell.recipe}-{cell.steps}-{cell.training_seed}-{cell.digest}"
    return name if cell.demonstrations == SCRIPTED.name else f"{name}-{cell.demonstrations}"


def write_page(folder: Path, command: str) -> Path:
    """Write ``README.md`` and its pictures from the folder's ledger.

    Args:
        folder: The folder of results.
        command: The command that makes what is missing, for the page's reader.

    Returns:
        The page's path.

    Raises:
        Invalid: The ledger can't be read.
    """
    entries = [entry for entry in Ledger(folder).entries if entry.cell.recipe in RECIPES]
    held_out = [entry for entry in entries if not entry.cell.own_starts]
    ordinary = [entry for entry in held_out if entry.cell.demonstrations == SCRIPTED.name]
    parts = [
        "# Results",
        "",
        "Demonstrations by the scripted demonstrator: twelve ranked ones (appendix C of the"
        " published work) and twelve perfect ones a behaviour. Every figure is of games that a"
        " trained policy played; each game is a verified recording. The imitator is the policy"
        " that PPO trained on the learned reward; the clone learned the perfect demonstrations by"
        " classification. Starts that a demonstration began from don't count.",
        "",
        f"Made by `{command}`, which computes what is missing in ledger.jsonl.",
        "",
    ]
    for recipe in RECIPES:
        whole = [e for e in ordinary if e.cell.recipe == recipe and not is_ablation(e)]
        if groups := group_results(whole):
            parts += _section(folder, recipe, groups)
    parts += kinds_lines([entry for entry in held_out if not is_ablation(entry)])
    parts += ablation_lines(ordinary)
    parts += _own_starts([e for e in entries if e.cell.demonstrations == SCRIPTED.name])
    parts += extrapolation_results.page_lines(folder)
    page = folder / "README.md"
    write_whole(page, "\n".join(parts).encode())
    return page


def _longest_trained(groups: Sequence[ResultGroup]) -> list[ResultGroup]:
    """Return one group a behaviour, that of most steps by today's recipe: what pictures show."""
    current = [group for group in groups if group.is_current] or groups
    return list({group.behaviour.slug: group for group in current}.values())


def _section(folder: Path, recipe: str, groups: Sequence[ResultGroup]) -> list[str]:
    aliens, returns = f"aliens-{recipe}.png", f"returns-{recipe}.png"
    shown = _longest_trained(groups)
    write_whole(folder / aliens, _aliens(shown))
    write_whole(folder / returns, _returns(shown))
    return [
        f"## Recipe `{recipe}`",
        "",
        "Greedy games from all held-out evaluation starts, of all training seeds together, with 95%"
        " bootstrap intervals over the games. Minutes are those of whole runs, from the recordings"
        " to the attention maps, on the machine as it was; tau and left-out pairs are the reward"
        " model's, the lowest of the training seeds.",
        "",
        *_means(groups),
        "",
        "### Aliens hit from evaluation starts 0, 1, 2",
        "",
        "Targets + strays of the greedy game; a cross marks a game lost to a bomb. The winner hit"
        " more targets, or as many with fewer strays.",
        "",
        *_hits(groups),
        "",
        f"![Aliens left, first training seed]({aliens})",
        "",
        "Squares are aliens left, rings targets hit, crosses strays; most steps, first training"
        " seed.",
        "",
        "### Predicted return against rank",
        "",
        f"![Predicted return against rank]({returns})",
        "",
        *_rewards(shown),
        "",
        "### Each run",
        "",
        *(
            f"- [{group.name}, {group.steps:,} steps, training seed"
            f" {entry.cell.training_seed}]({cell_folder(entry)}/README.md)"
            f"{_remark(entry)}"
            for group in groups
            for entry in group.entries
        ),
        "",
    ]


def _remark(entry: Entry) -> str:
    """Return what is not the same in all runs, for the end of a line."""
    numbers = ", learned in bfloat16" if entry.versions.get(PRECISION) == "bfloat16" else ""
    return numbers + (", on a GPU" if entry.versions.get(DEVICE) == "cuda" else "")


def _own_starts(entries: Sequence[Entry]) -> list[str]:
    """The published protocol's table: each start's game by the policies trained on that start."""
    known = {behaviour.slug: behaviour for behaviour in BUILT_IN}
    found: dict[tuple[int, str, int, int], dict[int, Entry]] = {}
    for entry in entries:
        cell = entry.cell
        if len(cell.own_starts) != 1 or cell.behaviour not in known:
            continue
        place = list(known).index(cell.behaviour)
        row = found.setdefault((place, cell.recipe, cell.steps, cell.training_seed), {})
        row[cell.own_starts[0]] = entry
    if not found:
        return []
    lines = [
        "## One imitator per start",
        "",
        "The published protocol: an imitator is trained on games from one evaluation start and"
        " judged on that start alone. Targets + strays of its greedy game; a cross: it was lost.",
        "",
        *_hits_head("behaviour | recipe | steps | seed", "---|---|---:|---:"),
    ]
    for (place, recipe, steps, seed), by_start in sorted(found.items()):
        behaviour = BUILT_IN[place]
        head = f"| {behaviour.name} | {recipe} | {steps:,} | {seed} | "
        lines.append(head + _hits_row({n: by_start.get(n) for n in STARTS}))
    links = [
        f"- [{known[entry.cell.behaviour].name}, start {start}, training seed"
        f" {entry.cell.training_seed}]({cell_folder(entry)}/README.md)"
        for by_start in found.values()
        for start, entry in sorted(by_start.items())
    ]
    return [*lines, "", *links, ""]


def _means(groups: Sequence[ResultGroup]) -> list[str]:
    lines = [
        "| behaviour | steps | seeds | policy | targets | strays | order errors | lost"
        " | targets, sampled | tau | left-out pairs | minutes |",
        "|---|---:|---|---|---:|---:|---:|---:|---:|---:|---:|---:|",
    ]
    for group in groups:
        minutes = [entry.minutes for entry in group.entries]
        for policy in POLICIES:
            figures = [
                group.shown(policy, "greedy", "targets"),
                group.shown(policy, "greedy", "strays"),
                group.shown(policy, "greedy", "order_errors") if group.behaviour.ordered else "",
                group.shown(policy, "greedy", "died", ".0%"),
                group.shown(policy, "sampled", "targets"),
            ]
            if policy == "imitator":
                head = f"| {group.name} | {group.steps:,} | {group.seeds}"
                tail = [
                    group.lowest("tau", ".2f"),
                    group.lowest("held_out_accuracy", ".1%"),
                    " to ".join(dict.fromkeys(f"{edge(minutes):.0f}" for edge in (min, max))),
                ]
            else:
                head, tail = "| | |", ["", "", ""]
            lines.append(" | ".join([head, policy, *figures, *tail]) + " |")
    return lines


def _hits(groups: Sequence[ResultGroup]) -> list[str]:
    lines = _hits_head("behaviour | steps | seed", "---|---:|---:")
    for group in groups:
        for entry in group.entries:
            head = f"| {group.name} | {group.steps:,} | {entry.cell.training_seed} | "
            lines.append(head + _hits_row(dict.fromkeys(STARTS, entry)))
    return lines


def _hits_head(names: str, rules: str) -> list[str]:
    heads = [f"{policy} {start}" for start in STARTS for policy in POLICIES]
    return [
        f"| {names} | {' | '.join(heads)} | winner 0 / 1 / 2 |",
        f"|{rules}|{'---|' * len(heads)}---|",
    ]


def _hits_row(by_start: Mapping[int, Entry | None]) -> str:
    """Return both policies' games of each start, and who won them."""
    cells, winners = [], []
    for start, entry in by_start.items():
        ours, theirs = (entry.game(policy, start) if entry else None for policy in POLICIES)
        cells += [_game(ours), _game(theirs)]
        who = winner(ours.figures, theirs.figures) if ours and theirs else None
        winners.append(who or "")
    return f"{' | '.join(cells)} | {' / '.join(winners)} |"


def _rewards(groups: Sequence[ResultGroup]) -> list[str]:
    """The predicted return of each rank, as the published work's appendix tables it."""
    ranks = sorted({one.rank for g in groups for one in g.entries[0].demonstrations})
    lines = [
        f"| rank | {' | '.join(group.behaviour.name for group in groups)} |",
        f"|---:|{'---:|' * len(groups)}",
    ]
    for rank in ranks:
        cells = []
        for group in groups:
            found = [one for one in group.entries[0].demonstrations if one.rank == rank]
            cells.append(
                ", ".join(
                    f"{one.predicted_return:.0f} ({_counted(group.behaviour, one.hits)})"
                    for one in found
                )
            )
        lines.append(f"| {rank} | {' | '.join(cells)} |")
    return lines


def _aliens(groups: Sequence[ResultGroup]) -> bytes:
    columns = [(policy, start) for policy in POLICIES for start in STARTS]
    rows = []
    for group in groups:
        games = [group.entries[0].game(policy, start) for policy, start in columns]
        rows.append(
            AliensRow(group.behaviour, tuple(None if game is None else game.hits for game in games))
        )
    return aliens_table(rows, [(policy, f"{policy}, start {start}") for policy, start in columns])


def _returns(groups: Sequence[ResultGroup]) -> bytes:
    panels = []
    for group in groups:
        entry = group.entries[0]
        panels.append(
            ReturnsPanel(
                group.behaviour.name,
                [one.rank for one in entry.demonstrations],
                [one.predicted_return for one in entry.demonstrations],
                entry.check.get("tau"),
            )
        )
    return returns_table(panels)


def _game(game: LedgerGame | None) -> str:
    if game is None:
        return ""
    figures = game.figures
    return f"{figures.targets} + {figures.strays}{' ✗' if figures.died else ''}"


def _counted(behaviour: Behaviour, hits: tuple[tuple[int, int], ...]) -> str:
    found = score(behaviour, hits)
    return f"{len(hits)}" if found is None else f"{found.targets} + {found.strays}"
