"""The ledger of finished results: a file with one line of JSON for each.

It holds figures, not files: the page of all results is made from it alone, and whoever has it
computes only what is missing. Games are arrays; targets, strays and order errors follow from hits
and are not stored.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple

from pydantic import PlainSerializer, TypeAdapter

from trainer.reporting.digests import recipe_digest
from tril.analysis.summary import GameFigures
from tril.demonstrators import SCRIPTED
from tril.errors import Invalid
from tril.files.artifact_store import write_whole
from tril.games.base import Cell
from tril.games.behaviours import Behaviour, score
from tril.recipes import Recipe

FILE_NAME = "ledger.jsonl"

Rounded = Annotated[float, PlainSerializer(lambda value: round(value, 2))]
"""A number of which the ledger keeps two digits."""

PRECISION = "precision"
"""Name, among an entry's versions, of the number format that the policy learned in."""

DEVICE = "device"
"""Name, among an entry's versions, of the device that the policy learned on."""


@dataclass(frozen=True, order=True)
class LedgerCell:
    """Names one result: what was taught, how, and from which training seed.

    Attributes:
        behaviour: Short name of the behaviour.
        recipe: Name of the recipe.
        digest: Digest of the recipe's values, see recipe_digest.
        steps: Steps of the imitator's training games.
        training_seed: Feeds every random choice.
        own_starts: As in PolicyRecipe.
        demonstrations: Name of the kind of demonstrations, see tril.demonstrators.KINDS.
    """

    behaviour: str
    recipe: str
    digest: str
    steps: int
    training_seed: int
    own_starts: tuple[int, ...] = ()
    demonstrations: str = SCRIPTED.name

    @classmethod
    def of(
        cls,
        behaviour: str,
        recipe: Recipe,
        steps: int,
        training_seed: int,
        kind: str = SCRIPTED.name,
    ) -> LedgerCell:
        """Name the result of a run on a kind of demonstrations."""
        digest, own_starts = recipe_digest(recipe), recipe.policy.own_starts
        return cls(behaviour, recipe.name, digest, steps, training_seed, own_starts, kind)


class LedgerGame(NamedTuple):
    """An evaluation game.

    Attributes:
        start: Number of the evaluation start.
        held_out: Whether no demonstration began from that start.
        hits: The items taken, in order of time.
        steps: Length of the game.
        died: Whether the player died.
        predicted_return: Sum of R over its observations, if it was computed.
    """

    start: int
    held_out: bool
    hits: tuple[Cell, ...]
    steps: int
    died: bool
    predicted_return: Rounded | None

    def figures(self, behaviour: Behaviour) -> GameFigures:
        """Return the game in numbers."""
        outcome = score(behaviour, self.hits)
        return GameFigures(
            None if outcome is None else outcome.targets,
            None if outcome is None else outcome.strays,
            None if outcome is None else outcome.order_errors,
            self.steps,
            self.died,
            self.predicted_return,
            None if behaviour.target is None else len(behaviour.target),
        )


class LedgerDemonstration(NamedTuple):
    """A ranked demonstration: its rank from 1, the best, its hits, and what R makes of it.

    ``final_level``, by which the ranking is checked, is None in results of earlier versions.
    """

    rank: int
    hits: tuple[Cell, ...]
    predicted_return: Rounded
    final_level: Rounded | None = None


@dataclass(frozen=True)
class Entry:
    """The result of a run.

    Attributes:
        version: Version of the format.
        cell: Names it.
        finished_at: When, ISO 8601.
        seconds: Work of each stage, in seconds.
        check: Kendall's tau and accuracies of the reward model; empty if it was not checked.
        versions: Versions of the software, with the policy's PRECISION and DEVICE.
        demonstrations: The ranking that was learned from.
        games: All evaluation games by policy and action selection, e.g. "imitator greedy".
        changes: Values, by dotted path, in which the recipe differs from the built-in one.
    """

    version: Literal[2] = field(default=2, kw_only=True)
    cell: LedgerCell
    finished_at: str
    seconds: dict[str, Rounded]
    check: dict[str, float | None]
    versions: dict[str, str]
    demonstrations: tuple[LedgerDemonstration, ...]
    games: Mapping[str, tuple[LedgerGame, ...]]
    changes: dict[str, Any] = field(default_factory=dict)

    def of(self, policy: str, action_selection: str) -> tuple[LedgerGame, ...]:
        """Return the games of a policy."""
        return self.games.get(f"{policy} {action_selection}", ())

    def game(self, policy: str, start: int) -> LedgerGame | None:
        """Return the greedy game of a policy from a start; None if it was not played."""
        return next((game for game in self.of(policy, "greedy") if game.start == start), None)

    @property
    def has_levels(self) -> bool:
        """Whether the final levels of all demonstrations are known."""
        return all(demonstration.final_level is not None for demonstration in self.demonstrations)

    @property
    def minutes(self) -> float:
        """How long the run took, without making scripted demonstrations."""
        return sum(s for stage, s in self.seconds.items() if stage != "demonstrations") / 60


_ENTRY: TypeAdapter[Entry] = TypeAdapter(Entry)


class Ledger:
    """The finished results of a folder.

    Args:
        folder: The folder; the ledger in it need not exist yet.

    Raises:
        Invalid: A line can't be read; it is named.
    """

    def __init__(self, folder: Path) -> None:
        self.path = folder / FILE_NAME
        self._entries: dict[LedgerCell, Entry] = {}
        for number, line in enumerate(_lines(self.path), start=1):
            try:
                data = json.loads(line)
                # Up to version 0.3 ledgers had results of sanity experiments, too.
                if "experiment" in data:
                    continue
                entry = _ENTRY.validate_python(data)
                self._entries[entry.cell] = entry
            except (AttributeError, KeyError, TypeError, ValueError) as error:
                raise Invalid(
                    f"Line {number} of {self.path} is not a finished result: {error!r}. Delete it"
                    " to have that result computed again."
                ) from None

    @property
    def entries(self) -> Sequence[Entry]:
        """The results of runs, in the order of their cells."""
        return [self._entries[cell] for cell in sorted(self._entries)]

    def missing(self, cells: Iterable[LedgerCell]) -> list[LedgerCell]:
        """Return the missing results, in the given order."""
        return [cell for cell in cells if cell not in self._entries]

    def add(self, entry: Entry) -> None:
        """Add or replace a result, and write the file as a whole."""
        self._entries[entry.cell] = entry
        lines = [_ENTRY.dump_json(entry) for entry in self.entries]
        self.path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(self.path, b"".join(line + b"\n" for line in lines))


def _lines(path: Path) -> list[str]:
    return path.read_text(encoding="utf-8").splitlines() if path.exists() else []
