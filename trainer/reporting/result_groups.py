"""Results that only the training seed tells apart, and the figures of their games together."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from trainer.reporting.digests import changed_recipe, recipe_digest
from trainer.reporting.ledger import Entry, LedgerCell, LedgerGame
from tril.analysis.summary import Interval, interquartile_interval, nested_interval, winner
from tril.games import published
from tril.games.base import Cell
from tril.games.behaviours import Behaviour
from tril.recipes import RECIPES

PLACES = {behaviour.slug: place for place, behaviour in enumerate(published())}


@dataclass(frozen=True)
class Duel:
    """The greedy games of both policies from one start; None where one was not played."""

    behaviour: Behaviour
    start: int
    imitator: LedgerGame | None
    clone: LedgerGame | None

    @property
    def hits(self) -> tuple[tuple[Cell, ...] | None, ...]:
        """The hits of each of the games."""
        return tuple(None if game is None else game.hits for game in (self.imitator, self.clone))

    @property
    def held_out(self) -> bool:
        """Whether no demonstration began from the start."""
        return all(game.held_out for game in (self.imitator, self.clone) if game)

    @property
    def winner(self) -> str:
        """Who won; nothing where a game is missing or the behaviour has no target."""
        if self.imitator is None or self.clone is None:
            return ""
        imitator, clone = (game.figures(self.behaviour) for game in (self.imitator, self.clone))
        return winner(imitator, clone) or ""


@dataclass(frozen=True)
class ResultGroup:
    """The results of one behaviour, recipe, number of steps and kind of demonstrations.

    Attributes:
        behaviour: Behaviour of the results.
        entries: The results by training seed, at least one.
    """

    behaviour: Behaviour
    entries: tuple[Entry, ...]

    @property
    def cell(self) -> LedgerCell:
        """Of the first training seed."""
        return self.entries[0].cell

    @property
    def is_current(self) -> bool:
        """Whether the recipe is the built-in one of this version."""
        return self.cell.digest == recipe_digest(RECIPES[self.cell.recipe])

    @property
    def name(self) -> str:
        """The behaviour's name, with the values of the recipe that are changed."""
        remarks = self._remarks()
        return f"{self.behaviour.name} ({', '.join(remarks)})" if remarks else self.behaviour.name

    def _remarks(self) -> list[str]:
        """Return the recipe's differences from today's built-in one; empty if there are none."""
        changes = self.entries[0].changes
        if self.is_current:
            return []
        changed = changed_recipe(RECIPES[self.cell.recipe], changes)
        if changed is not None and recipe_digest(changed) == self.cell.digest:
            return [f"{path} {value}" for path, value in changes.items()]
        return ["other values", self.cell.digest]

    @property
    def minutes(self) -> tuple[float, float]:
        """The shortest and the longest run."""
        minutes = [entry.minutes for entry in self.entries]
        return min(minutes), max(minutes)

    def duels(self, starts: Iterable[int], entry: Entry | None = None) -> list[Duel]:
        """Return the greedy games of both policies from each of the starts.

        Args:
            starts: Numbers of evaluation starts.
            entry: The result to take them from; the first if None.
        """
        entry = entry or self.entries[0]
        return [
            Duel(self.behaviour, n, entry.game("imitator", n), entry.game("clone", n))
            for n in starts
        ]

    def mean(self, policy: str, action_selection: str, name: str) -> Interval | None:
        """Return the mean of a figure over the held-out games; None where they lack it."""
        values = self.values(policy, action_selection, name)
        return nested_interval(values) if values else None

    def values(self, policy: str, action_selection: str, name: str) -> list[list[float]]:
        """Return a figure of the held-out games of each training that has it."""
        figures_by_entry = (
            [
                float(value)
                for game in entry.of(policy, action_selection)
                if game.held_out
                and (value := getattr(game.figures(self.behaviour), name)) is not None
            ]
            for entry in self.entries
        )
        return [values for values in figures_by_entry if values]

    def lowest(self, name: str) -> float | None:
        """Return the lowest of a figure of the reward models' checks; None if there is none."""
        values = [v for entry in self.entries if (v := entry.check.get(name)) is not None]
        return min(values, default=None)


def group_results(entries: Iterable[Entry]) -> list[ResultGroup]:
    """Return the entries in groups by behaviour, steps, recipe and demonstrations.

    The built-in values of a recipe come before changed ones.
    """
    built_in = {name: recipe_digest(recipe) for name, recipe in RECIPES.items()}
    entries_by_key: dict[tuple[int, int, str, bool, str, str], list[Entry]] = {}
    for entry in entries:
        cell = entry.cell
        place, changed = PLACES[cell.behaviour], cell.digest != built_in[cell.recipe]
        key = (place, cell.steps, cell.recipe, changed, cell.digest, cell.demonstrations)
        entries_by_key.setdefault(key, []).append(entry)
    behaviours = published()
    return [
        ResultGroup(behaviours[key[0]], tuple(entries_by_key[key]))
        for key in sorted(entries_by_key)
    ]


def over_behaviours(
    groups: Iterable[ResultGroup], policy: str, action_selection: str, name: str
) -> Interval | None:
    """Return a figure's interquartile mean over behaviours and seeds; None if none has it."""
    strata = [values for g in groups if (values := g.values(policy, action_selection, name))]
    return interquartile_interval(strata) if strata else None
