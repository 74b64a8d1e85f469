"""The sanity experiments' results: a file and a picture each, and their part of the page."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from trainer.reporting.extrapolation import (
    QUANTITIES,
    Extrapolation,
    Quantity,
    SkilledGame,
    extrapolation_picture,
    tau_of,
)
from trainer.reporting.ledger import values_digest
from tril.errors import Invalid
from tril.files.artifact_store import write_whole
from tril.recipes import Recipe

FOLDER = "extrapolation"


@dataclass(frozen=True, order=True)
class Experiment:
    """One sanity experiment.

    Attributes:
        quantity: What the games were ranked by.
        recipe: Name of the recipe whose reward was learned.
        digest: Of the values of the recipe's reward, see values_digest: no other takes part.
        training_seed: Fed every random choice.
    """

    quantity: Quantity
    recipe: str
    digest: str
    training_seed: int

    @classmethod
    def of(cls, quantity: Quantity, recipe: Recipe, training_seed: int) -> Experiment:
        """Name the experiment."""
        return cls(quantity, recipe.name, values_digest(recipe.reward), training_seed)

    @property
    def name(self) -> str:
        """What its files are called."""
        return f"{self.quantity}-{self.recipe}-{self.training_seed}-{self.digest}"


def missing(folder: Path, experiments: Sequence[Experiment]) -> list[Experiment]:
    """Return those that have no file in the folder of results."""
    return [one for one in experiments if not _path(folder, one).exists()]


def write(folder: Path, experiment: Experiment, found: Extrapolation) -> None:
    """Write an experiment's file and picture into the folder of results."""
    path = _path(folder, experiment)
    path.parent.mkdir(parents=True, exist_ok=True)
    games = [asdict(game) for game in found.games]
    write_whole(path.with_suffix(".png"), extrapolation_picture(found))
    content = {"experiment": asdict(experiment), "games": games}
    write_whole(path, json.dumps(content, indent=1).encode())


def page_lines(folder: Path) -> list[str]:
    """Return the experiments' section of the results page, as lines of Markdown.

    Raises:
        Invalid: A file can't be read; it is named.
    """
    found = sorted(_read(path) for path in (folder / FOLDER).glob("*.json"))
    if not found:
        return []
    return [
        "## Rewards learned from rankings by points and by shots",
        "",
        "The published sanity experiments: one player is trained on the points of the aliens shot,"
        " or on missiles fired, and its games after more and more training are ranked by that. The"
        " reward is learned from twelve of the less skilled games; what it predicts for the others,"
        " those beyond the demonstrations' range among them, is held against the truth. Kendall's"
        " tau is 1 where the order is the same and 0 where there is none in common.",
        "",
        "| ranked by | recipe | seed | demonstrations | tau | unseen, within | tau | beyond | tau"
        " | predicted above all demonstrations |",
        "|---|---|---:|---:|---:|---:|---:|---:|---:|---:|",
        *(
            _row(experiment, Extrapolation(experiment.quantity, games))
            for experiment, games in found
        ),
        "",
        *(
            f"![Predicted return against {QUANTITIES[experiment.quantity]},"
            f" {experiment.recipe}]({FOLDER}/{experiment.name}.png)"
            for experiment, _ in found
        ),
        "",
    ]


def _row(experiment: Experiment, found: Extrapolation) -> str:
    shown = [game.true_quantity for game in found.demonstrations]
    highest = max(game.predicted_return for game in found.demonstrations)
    above = sum(game.predicted_return > highest for game in found.beyond)
    cells = (
        experiment.quantity,
        experiment.recipe,
        str(experiment.training_seed),
        f"{len(shown)} of {min(shown)} to {max(shown)}",
        _tau(found.demonstrations),
        str(len(found.unseen)),
        _tau(found.unseen),
        str(len(found.beyond)),
        _tau(found.beyond),
        f"{above} of {len(found.beyond)}",
    )
    return f"| {' | '.join(cells)} |"


def _tau(games: Sequence[SkilledGame]) -> str:
    tau = tau_of(games)
    return "" if tau is None else f"{tau:.2f}"


def _path(folder: Path, experiment: Experiment) -> Path:
    return folder / FOLDER / f"{experiment.name}.json"


def _read(path: Path) -> tuple[Experiment, tuple[SkilledGame, ...]]:
    try:
        content = json.loads(path.read_text())
        games = tuple(SkilledGame(**game) for game in content["games"])
        return Experiment(**content["experiment"]), games
    except (KeyError, TypeError, ValueError) as error:
        raise Invalid(
            f"{path} is not a finished experiment: {error!r}. Delete it to have it made again."
        ) from None
