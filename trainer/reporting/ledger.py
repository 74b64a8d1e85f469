"""The ledger of finished results: one line of JSON for each cell of a table that was computed.

It lies beside the results it speaks of, so that whoever has the folder computes only what is
missing. It holds figures, not files: every table of the results can be made from it alone.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Sequence
from dataclasses import MISSING, asdict, dataclass, field, fields, is_dataclass
from pathlib import Path
from typing import Any

from sqlalchemy.orm import Session

from tril.analysis.outcome import ImitatorOutcome
from tril.analysis.summary import GameFigures, PolicySummary, summarise
from tril.demonstrator import SCRIPTED
from tril.errors import Invalid
from tril.files.artifact_store import write_whole
from tril.recipes import (
    FOR_PEOPLE,
    RECIPES,
    Recipe,
    RewardRecipe,
    changed_values,
    recipe_from_dict,
)
from tril.store import behaviours, recordings
from tril.store.database import Database
from tril.store.models import RunRow
from tril.store.training import evaluations, runs

FILE_NAME = "ledger.jsonl"

PRECISION = "precision"
"""Name, among an entry's versions, of the numbers that the policy learned in; float32 without."""

DEVICE = "device"
"""Name, among an entry's versions, of what the policy learned on; the processor without."""


@dataclass(frozen=True, order=True)
class Cell:
    """One result: what was taught, how, and by which chance.

    Attributes:
        behaviour: Short name of the behaviour.
        recipe: Name of the recipe.
        digest: Of the recipe's values, see recipe_digest: another value makes another cell.
        steps: PPO steps.
        training_seed: Fed every random choice.
        own_starts: As in PolicyRecipe: what the policy was trained and judged on, if not held out.
        demonstrations: Name of the kind of demonstrations, see tril.demonstrator.KINDS.
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
        demonstrations: str = SCRIPTED.name,
    ) -> Cell:
        """Name the cell of a run."""
        return cls(
            behaviour,
            recipe.name,
            recipe_digest(recipe),
            steps,
            training_seed,
            recipe.policy.own_starts,
            demonstrations,
        )


@dataclass(frozen=True)
class LedgerGame:
    """An evaluation game.

    Attributes:
        policy: "imitator" or "clone".
        action_selection: How it chose its actions.
        start: Number of the evaluation start.
        held_out: Whether no demonstration began from that start.
        hits: The aliens hit as (row from the bottom, column from the left), in order of time.
        figures: The game in numbers.
    """

    policy: str
    action_selection: str
    start: int
    held_out: bool
    hits: tuple[tuple[int, int], ...]
    figures: GameFigures


@dataclass(frozen=True)
class LedgerDemonstration:
    """A ranked demonstration: its rank from 1, the best, its hits, and its predicted return."""

    rank: int
    hits: tuple[tuple[int, int], ...]
    predicted_return: float


@dataclass(frozen=True)
class Entry:
    """A finished cell.

    Attributes:
        cell: Which one.
        finished_at: When, ISO 8601.
        seconds: Of each stage of the run.
        check: Kendall's tau and accuracies of the reward model; empty if it was not checked.
        demonstrations: The ranking that was learned from.
        games: All evaluation games.
        versions: Of what took part.
        changes: Values, by dotted path, in which the recipe was not the ready-made one of its name.
    """

    cell: Cell
    finished_at: str
    seconds: dict[str, float]
    check: dict[str, float | None]
    demonstrations: tuple[LedgerDemonstration, ...]
    games: tuple[LedgerGame, ...]
    versions: dict[str, str]
    changes: dict[str, Any] = field(default_factory=dict)

    def headline(self, policy: str, action_selection: str = "greedy") -> PolicySummary | None:
        """Return the means over the held-out games of a policy; None if there are none."""
        found = [
            game.figures
            for game in self.games
            if (game.policy, game.action_selection) == (policy, action_selection) and game.held_out
        ]
        return summarise(found) if found else None

    def game(self, policy: str, start: int, action_selection: str = "greedy") -> LedgerGame | None:
        """Return one game; None if it was not played."""
        for game in self.games:
            if (game.policy, game.action_selection, game.start) == (
                policy,
                action_selection,
                start,
            ):
                return game
        return None

    @property
    def minutes(self) -> float:
        """How long the run took, making scripted demonstrations left out."""
        return sum(s for stage, s in self.seconds.items() if stage != "demonstrations") / 60


class Ledger:
    """The finished cells of a folder of results.

    Args:
        folder: The folder; the ledger in it need not exist yet.

    Raises:
        Invalid: A line of the file can't be read; it is named.
    """

    def __init__(self, folder: Path) -> None:
        self.path = folder / FILE_NAME
        self._entries: dict[Cell, Entry] = {}
        if self.path.exists():
            lines = self.path.read_text().splitlines()
            for number, line in enumerate(lines, start=1):
                try:
                    entry = _entry(json.loads(line))
                except (KeyError, TypeError, ValueError) as error:
                    raise Invalid(
                        f"Line {number} of {self.path} is not a finished result: {error!r}. Take it"
                        " out to have that result computed again."
                    ) from None
                self._entries[entry.cell] = entry

    @property
    def entries(self) -> Sequence[Entry]:
        """The finished cells, in the order of their names."""
        return [self._entries[cell] for cell in sorted(self._entries)]

    def missing(self, cells: Iterable[Cell]) -> list[Cell]:
        """Return the cells that are not finished, in the order given."""
        return [cell for cell in cells if cell not in self._entries]

    def add(self, entry: Entry) -> None:
        """Add a finished cell, or replace it, and write the file as a whole."""
        self._entries[entry.cell] = entry
        lines = [json.dumps(asdict(one), separators=(",", ":")) for one in self.entries]
        self.path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(self.path, "".join(f"{line}\n" for line in lines).encode())


def recipe_digest(recipe: Recipe) -> str:
    """Return eight hexadecimal digits that change when a value of the recipe does.

    Values that are their field's default don't count, so that a new field changes nothing as long
    as a recipe leaves it alone; nor does the summary, which is for people.
    """
    values = _uncommon(recipe)
    for name in FOR_PEOPLE:
        values.pop(name, None)
    return _digest(values)


def values_digest(part: RewardRecipe) -> str:
    """Return the same for a part of a recipe."""
    return _digest(_uncommon(part))


def read_cell(session: Session, run: RunRow) -> Cell:
    """Name the cell of a run.

    Raises:
        Invalid: The run's recipe is one of another version.
    """
    slug = behaviours.get(session, run.behaviour_id).slug
    recipe = recipe_from_dict(run.recipe)
    return Cell.of(slug, recipe, run.steps, run.training_seed, run.example_kind)


def read_entry(database: Database, run_id: str) -> Entry:
    """Read a finished run as an entry of the ledger.

    Raises:
        NotFound: No such run.
        Invalid: The run is not done, or was made by a recipe of another version.
    """
    with database.reading() as session:
        run = runs.get(session, run_id)
        if run.finished_at is None:
            raise Invalid(f"Run {run_id} is {run.status}; only a finished one is a result.")
        tiers = run.snapshot.tiers if run.snapshot else []
        shown = recordings.by_ids(session, [number for tier in tiers for number in tier])
        check = run.outcome.check
        returns = check.predicted_returns if check else {}
        return Entry(
            cell=read_cell(session, run),
            finished_at=run.finished_at.isoformat(timespec="seconds"),
            seconds={name: round(s, 1) for name, s in run.finished_stages.items()},
            check=check.figures if check else {},
            demonstrations=tuple(
                LedgerDemonstration(rank, _cells(shown[number].hits), round(returns[number], 2))
                for rank, tier in enumerate(tiers, start=1)
                for number in tier
                if number in returns
            ),
            games=tuple(
                LedgerGame(
                    policy=row.policy,
                    action_selection=row.action_selection,
                    start=row.start_number,
                    held_out=row.held_out,
                    hits=_cells(row.recording.hits),
                    figures=evaluations.figures_of(row),
                )
                for row in evaluations.listing(session, run_id)
            ),
            versions=dict(run.versions) | _learned_with(run),
            changes=_changes(recipe_from_dict(run.recipe)),
        )


def _changes(recipe: Recipe) -> dict[str, Any]:
    """Return what is other than in the ready-made recipe, as JSON gives it back."""
    changed = changed_values(recipe, RECIPES[recipe.name]) if recipe.name in RECIPES else {}
    return {path: list(v) if isinstance(v, tuple) else v for path, v in changed.items()}


def _learned_with(run: RunRow) -> dict[str, str]:
    imitator = run.outcome.imitator or ImitatorOutcome()
    learned = {PRECISION: imitator.precision, DEVICE: imitator.device}
    return {name: value for name, value in learned.items() if value}


def _cells(hits: Iterable[Sequence[int]]) -> tuple[tuple[int, int], ...]:
    return tuple((hit[0], hit[1]) for hit in hits)


def _entry(data: dict[str, Any]) -> Entry:
    games = []
    for game in data["games"]:
        figures = GameFigures(**game["figures"])
        games.append(LedgerGame(**{**game, "hits": _cells(game["hits"]), "figures": figures}))
    shown = tuple(
        LedgerDemonstration(**{**one, "hits": _cells(one["hits"])})
        for one in data["demonstrations"]
    )
    return Entry(
        **{
            **data,
            "cell": Cell(
                **{**data["cell"], "own_starts": tuple(data["cell"].get("own_starts", ()))}
            ),
            "demonstrations": shown,
            "games": tuple(games),
        }
    )


def _digest(values: dict[str, Any]) -> str:
    text = json.dumps(values, sort_keys=True)
    return hashlib.blake2b(text.encode(), digest_size=4).hexdigest()


def _uncommon(part: Any) -> dict[str, Any]:
    """Return the values of a dataclass that are not their field's default."""
    values: dict[str, Any] = {}
    for one in fields(part):
        value = getattr(part, one.name)
        if is_dataclass(value):
            if inner := _uncommon(value):
                values[one.name] = inner
        elif one.default is MISSING or value != one.default:
            values[one.name] = value
    return values
