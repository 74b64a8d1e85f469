"""The page of all results in a folder, written from its ledger."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from trainer.reporting.figures import (
    AliensRow,
    aliens_figure,
    attention_figure,
    returns_figure,
)
from trainer.reporting.ledger import Entry, Ledger
from trainer.reporting.rendering import render
from trainer.reporting.result_groups import (
    PLACES,
    Duel,
    ResultGroup,
    group_results,
    over_behaviours,
)
from tril.analysis.outcome import AttentionState
from tril.demonstrators import SCRIPTED
from tril.files.artifact_store import write_whole
from tril.games import published
from tril.games.behaviours import score
from tril.play.agent import STICKY_ACTION_PROBABILITY
from tril.recipes import RECIPES, EvaluationRecipe
from tril.store.training.evaluations import POLICIES

STARTS = EvaluationRecipe().start_numbers
ATTENTION = "attention.png"


@dataclass(frozen=True)
class StartsRow:
    """A row of a table of single games.

    Attributes:
        name: The behaviour's.
        entry: The result, or the first of those that the games are from.
        duels: The games from each of STARTS.
        pages: Paths of the results' own pages, as far as the folder has them, by start if each has
            a result of its own.
    """

    name: str
    entry: Entry
    duels: list[Duel]
    pages: dict[int, str]


@dataclass(frozen=True)
class RecipeSection:
    """The results of a recipe.

    Attributes:
        recipe: Name of the recipe.
        groups: The results.
        rows: Games of the recipe.
        shown: The groups in the pictures: of each behaviour the one with most steps.
    """

    recipe: str
    groups: list[ResultGroup]
    rows: list[StartsRow]
    shown: list[ResultGroup]

    @property
    def is_current(self) -> bool:
        """Whether a result is of the built-in recipe of this version."""
        return any(group.is_current for group in self.groups)

    @property
    def means(self) -> list[tuple[ResultGroup, str]]:
        """Each group with each policy."""
        return [(group, policy) for group in self.groups for policy in POLICIES]

    @property
    def ranks(self) -> list[int]:
        """The ranks of demonstrations."""
        return sorted(
            {
                demonstration.rank
                for g in self.shown
                for demonstration in g.entries[0].demonstrations
            }
        )


def cell_folder(entry: Entry) -> str:
    """Return the name, below the results, of the folder with a result's own page."""
    cell = entry.cell
    name = f"{cell.behaviour}/{cell.recipe}-{cell.steps}-{cell.training_seed}-{cell.digest}"
    return name if cell.demonstrations == SCRIPTED.name else f"{name}-{cell.demonstrations}"


def write_page(folder: Path) -> Path:
    """Write ``README.md`` and its pictures from a folder's ledger.

    Returns:
        The page's path.

    Raises:
        Invalid: The ledger can't be read.
    """
    ledger = Ledger(folder)
    sections = _sections(folder, ledger)
    for section in sections:
        write_whole(folder / f"aliens-{section.recipe}.png", _aliens(section.shown))
        panels = [(group.behaviour.name, group.entries[0]) for group in section.shown]
        write_whole(folder / f"returns-{section.recipe}.png", returns_figure(panels))
    _draw_attention(folder, [group for section in sections for group in section.shown])
    page = folder / "README.md"
    write_whole(page, page_text(folder).encode())
    return page


def page_text(folder: Path) -> str:
    """Return the page of a folder's ledger.

    Raises:
        Invalid: The ledger can't be read.
    """
    ledger = Ledger(folder)
    return render(
        "results.md.j2",
        sections=_sections(folder, ledger),
        own_starts=_own_starts(folder, _known(ledger)),
        starts=STARTS,
        policies=POLICIES,
        has_attention=(folder / ATTENTION).exists(),
        score=score,
        over_behaviours=over_behaviours,
        sticky_action_probability=STICKY_ACTION_PROBABILITY,
    )


def _known(ledger: Ledger) -> list[Entry]:
    """Return the results of recipes and behaviours that this version has."""
    cells = ((entry, entry.cell) for entry in ledger.entries)
    return [entry for entry, cell in cells if cell.recipe in RECIPES and cell.behaviour in PLACES]


def _sections(folder: Path, ledger: Ledger) -> list[RecipeSection]:
    ordinary = [
        entry
        for entry in _known(ledger)
        if entry.cell.demonstrations == SCRIPTED.name and not entry.cell.own_starts
    ]
    return [
        _section(folder, recipe, groups)
        for recipe in RECIPES
        if (groups := group_results(entry for entry in ordinary if entry.cell.recipe == recipe))
    ]


def _section(folder: Path, recipe: str, groups: list[ResultGroup]) -> RecipeSection:
    current = [group for group in groups if group.is_current] or groups
    rows = [
        StartsRow(group.name, entry, group.duels(STARTS, entry), _pages(folder, {0: entry}))
        for group in groups
        for entry in group.entries
    ]
    groups_by_behaviour = {group.behaviour: group for group in current}
    return RecipeSection(recipe, groups, rows, list(groups_by_behaviour.values()))


def _pages(folder: Path, entries: Mapping[int, Entry]) -> dict[int, str]:
    """Return the paths of those results' pages that are there."""
    pages = {key: f"{cell_folder(entry)}/README.md" for key, entry in sorted(entries.items())}
    return {key: page for key, page in pages.items() if (folder / page).exists()}


def _own_starts(folder: Path, entries: Sequence[Entry]) -> list[StartsRow]:
    """Return the games of policies that were trained on the start that they are judged on."""
    entries_by_key: dict[tuple[int, str, int, int], dict[int, Entry]] = {}
    for entry in entries:
        cell = entry.cell
        if len(cell.own_starts) == 1 and cell.demonstrations == SCRIPTED.name:
            key = (PLACES[cell.behaviour], cell.recipe, cell.steps, cell.training_seed)
            entries_by_key.setdefault(key, {})[cell.own_starts[0]] = entry
    rows = []
    for (place, *_), by_start in sorted(entries_by_key.items()):
        behaviour = published()[place]
        groups = {n: ResultGroup(behaviour, (entry,)) for n, entry in by_start.items()}
        no_duel = Duel(behaviour, 0, None, None)
        duels = [groups[n].duels([n])[0] if n in groups else no_duel for n in STARTS]
        entry = next(iter(by_start.values()))
        rows.append(StartsRow(behaviour.name, entry, duels, _pages(folder, by_start)))
    return rows


def _aliens(groups: Sequence[ResultGroup]) -> bytes:
    rows = []
    for group in groups:
        by_policy = zip(*(duel.hits for duel in group.duels(STARTS)), strict=True)
        hits = tuple(hits_of_game for policy in by_policy for hits_of_game in policy)
        rows.append(AliensRow(group.behaviour.name, group.behaviour, hits))
    columns = [(policy, f"{policy.capitalize()}, start {n}") for policy in POLICIES for n in STARTS]
    return aliens_figure(rows, columns)


def _draw_attention(folder: Path, groups: Sequence[ResultGroup]) -> None:
    """Draw the attention maps of the longest training whose page is in the folder."""
    for group in sorted(groups, key=lambda group: -group.cell.steps):
        run = folder / cell_folder(group.entries[0])
        names = [(name, f"attention-{name.replace(' ', '-')}") for name in AttentionState]
        states = [(name, run / f"{file}.png", run / f"{file}-frame.png") for name, file in names]
        if all(path.exists() for _, *paths in states for path in paths):
            title = f"{group.name}, recipe {group.cell.recipe}, {group.cell.steps:,} steps"
            write_whole(folder / ATTENTION, attention_figure(title, states))
            return
