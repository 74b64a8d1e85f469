"""What other demonstrations and a recipe without its parts come to, beside the ordinary result."""

from __future__ import annotations

from collections.abc import Sequence

from trainer.reporting.ledger import Entry, recipe_digest
from trainer.reporting.result_groups import ResultGroup, group_results
from tril.behaviours import BUILT_IN
from tril.demonstrator import KINDS, SCRIPTED
from tril.recipes import ABLATIONS, FAST

WITHOUT = {recipe_digest(one.recipe): one for one in ABLATIONS}


def is_ablation(entry: Entry) -> bool:
    """Tell whether a result is of the fast recipe without one of its factors."""
    return entry.cell.recipe == FAST.name and entry.cell.digest in WITHOUT


def kinds_lines(entries: Sequence[Entry]) -> list[str]:
    """Return the section on other kinds of demonstrations, as lines of Markdown.

    Args:
        entries: Results of ready-made recipes. Each other kind stands beside the ordinary
            demonstrations of the same recipe and steps; without any other kind there is no section.
    """
    order = [kind.name for kind in KINDS]
    entries = [entry for entry in entries if entry.cell.demonstrations in order]
    others = {_learned(one) for one in entries if one.cell.demonstrations != SCRIPTED.name}
    if not others:
        return []
    groups = sorted(
        group_results([entry for entry in entries if _learned(entry) in others]),
        key=lambda group: (*_place(group), order.index(group.entries[0].cell.demonstrations)),
    )
    shown = {group.entries[0].cell.demonstrations for group in groups}
    return [
        "## Other demonstrations",
        "",
        "The same learning from other demonstrations; always with twelve perfect games beside the"
        " ranked ones, played in the same manner. Greedy games from all held-out evaluation starts,"
        " sampled where it says so; tau and left-out pairs are of the ranking as it was given,"
        " mistakes included.",
        "",
        *(f"- `{kind.name}`: {kind.summary}." for kind in KINDS if kind.name in shown),
        "",
        "| behaviour | recipe | steps | demonstrations | seeds | targets | strays | lost"
        " | targets, sampled | clone's targets | clone lost | tau | left-out pairs |",
        "|---|---|---:|---|---|---:|---:|---:|---:|---:|---:|---:|---:|",
        *(
            _row(
                group.name,
                group.entries[0].cell.recipe,
                f"{group.steps:,}",
                f"`{group.entries[0].cell.demonstrations}`",
                group.seeds,
                *_imitator(group),
                group.shown("clone", "greedy", "targets"),
                group.shown("clone", "greedy", "died", ".0%"),
                *_check(group),
            )
            for group in groups
        ),
        "",
    ]


def ablation_lines(entries: Sequence[Entry]) -> list[str]:
    """Return the section on the recipe without its factors, as lines of Markdown.

    Args:
        entries: Results of the ordinary demonstrations, the whole recipe's among them. Without any
            of a recipe that lacks a factor there is no section.
    """
    compared = {(entry.cell.behaviour, entry.cell.steps) for entry in entries if is_ablation(entry)}
    if not compared:
        return []
    whole = recipe_digest(FAST)
    order = [whole, *WITHOUT]
    groups = sorted(
        group_results(
            [
                entry
                for entry in entries
                if (entry.cell.behaviour, entry.cell.steps) in compared
                and entry.cell.recipe == FAST.name
                and entry.cell.digest in order
            ]
        ),
        key=lambda group: (
            BUILT_IN.index(group.behaviour),
            group.steps,
            order.index(group.entries[0].cell.digest),
        ),
    )
    left_out = [
        WITHOUT[digest] for group in groups if (digest := group.entries[0].cell.digest) != whole
    ]
    lines = [
        "## The fast recipe without its parts",
        "",
        "Each row leaves one factor out of `fast`; all else but what is named is the same. Greedy"
        " games from all held-out evaluation starts, sampled where it says so; tau and left-out"
        " pairs are the reward model's, the lowest of the training seeds.",
        "",
        *(f"- Without {one.name}: {one.instead}." for one in ABLATIONS if one in left_out),
        "",
        "| behaviour | steps | without | seeds | targets | strays | lost | targets, sampled | tau"
        " | left-out pairs |",
        "|---|---:|---|---|---:|---:|---:|---:|---:|---:|",
    ]
    for group in groups:
        digest = group.entries[0].cell.digest
        name = "(the whole recipe)" if digest == whole else WITHOUT[digest].name
        lines.append(
            _row(
                group.behaviour.name,
                f"{group.steps:,}",
                name,
                group.seeds,
                *_imitator(group),
                *_check(group),
            )
        )
    return [*lines, ""]


def _learned(entry: Entry) -> tuple[str, str, str, int]:
    """Return what two results have in common that differ in their demonstrations or by chance."""
    cell = entry.cell
    return cell.behaviour, cell.recipe, cell.digest, cell.steps


def _place(group: ResultGroup) -> tuple[int, str, str, int]:
    cell = group.entries[0].cell
    return BUILT_IN.index(group.behaviour), cell.recipe, cell.digest, cell.steps


def _imitator(group: ResultGroup) -> tuple[str, ...]:
    return (
        group.shown("imitator", "greedy", "targets"),
        group.shown("imitator", "greedy", "strays"),
        group.shown("imitator", "greedy", "died", ".0%"),
        group.shown("imitator", "sampled", "targets"),
    )


def _check(group: ResultGroup) -> tuple[str, ...]:
    return group.lowest("tau", ".2f"), group.lowest("held_out_accuracy", ".1%")


def _row(*cells: str) -> str:
    return f"| {' | '.join(cells)} |"
