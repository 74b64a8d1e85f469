"""Finished cells that only chance tells apart, and the figures of their games together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from trainer.reporting.ledger import Entry, recipe_digest
from tril.analysis.summary import Interval, interval
from tril.behaviours import BUILT_IN, Behaviour
from tril.errors import Invalid
from tril.recipes import RECIPES, with_values


@dataclass(frozen=True)
class ResultGroup:
    """The finished cells of one behaviour, recipe, number of steps and kind of demonstrations.

    Attributes:
        behaviour: What was taught.
        entries: The cells, by training seed; at least one.
    """

    behaviour: Behaviour
    entries: tuple[Entry, ...]

    @property
    def is_current(self) -> bool:
        """Whether the recipe is the ready-made one as it is now."""
        cell = self.entries[0].cell
        return cell.digest == recipe_digest(RECIPES[cell.recipe])

    @property
    def name(self) -> str:
        """The behaviour for a table, with the values of the recipe that are others."""
        if self.is_current:
            return self.behaviour.name
        first = self.entries[0]
        said = f"other values, {first.cell.digest}"
        if _still_makes(first):
            said = ", ".join(f"{path} {value}" for path, value in first.changes.items())
        return f"{self.behaviour.name} ({said})"

    @property
    def steps(self) -> int:
        """Steps of the imitator's training."""
        return self.entries[0].cell.steps

    @property
    def seeds(self) -> str:
        """The training seeds, for a table."""
        return ", ".join(str(entry.cell.training_seed) for entry in self.entries)

    def mean(self, policy: str, action_selection: str, name: str) -> Interval | None:
        """Return the mean of a figure over the held-out games of all training seeds."""
        values = [
            float(value)
            for entry in self.entries
            for game in entry.games
            if (game.policy, game.action_selection) == (policy, action_selection) and game.held_out
            if (value := getattr(game.figures, name)) is not None
        ]
        return interval(values) if values else None

    def shown(self, policy: str, action_selection: str, name: str, form: str = ".2f") -> str:
        """Return the mean and its interval for a table; nothing where games have no such figure."""
        value = self.mean(policy, action_selection, name)
        if value is None:
            return ""
        return f"{value.mean:{form}} [{value.low:{form}}, {value.high:{form}}]"

    def lowest(self, name: str, form: str) -> str:
        """Return the lowest of a figure of the reward models' checks, for a table."""
        values = [v for entry in self.entries if (v := entry.check.get(name)) is not None]
        return f"{min(values):{form}}" if values else ""


def _still_makes(entry: Entry) -> bool:
    """Tell whether an entry's changes make its recipe of the ready-made one as it is now."""
    changes = {path: tuple(v) if isinstance(v, list) else v for path, v in entry.changes.items()}
    try:
        changed = with_values(RECIPES[entry.cell.recipe], changes)
    except Invalid:
        return False  # A value that recipes have no more.
    return recipe_digest(changed) == entry.cell.digest


def group_results(entries: Sequence[Entry]) -> list[ResultGroup]:
    """Return the entries as groups, by behaviour as these come ready, then by steps."""
    known = {behaviour.slug: place for place, behaviour in enumerate(BUILT_IN)}
    found: dict[tuple[int, int, str, str, str], list[Entry]] = {}
    for entry in entries:
        cell = entry.cell
        if cell.behaviour in known:
            place = known[cell.behaviour]
            key = (place, cell.steps, cell.recipe, cell.digest, cell.demonstrations)
            found.setdefault(key, []).append(entry)
    return [ResultGroup(BUILT_IN[key[0]], tuple(found[key])) for key in sorted(found)]
