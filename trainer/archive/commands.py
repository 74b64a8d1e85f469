"""How to train a run again, by command."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from typing import Any

from tril.demonstrators import SCRIPTED
from tril.exchange.formats.run_file import RunObject
from tril.exchange.run_archive import RANKED, UNRANKED
from tril.games import published
from tril.games.behaviours import Behaviour
from tril.recipes import RECIPES, changed_values, recipe_from_dict


def commands(run: RunObject, behaviour: Behaviour) -> list[str]:
    """Return the commands that train a run again, for a shell in the unpacked archive.

    Args:
        run: The run.
        behaviour: Behaviour that the run teaches.
    """
    recipe = recipe_from_dict(run.recipe)
    options = ["--recipe", recipe.name, "--steps", str(run.steps)]
    options += ["--training-seed", str(run.training_seed)]
    if recipe.name in RECIPES:
        options += _set(changed_values(recipe, RECIPES[recipe.name]))
    is_built_in = behaviour.slug in {built_in.slug for built_in in published()}
    if run.example and is_built_in:
        kind = run.example_kind
        demonstrations = [] if kind == SCRIPTED.name else ["--demonstrations", kind]
        return [_line("tril", "demo", "--behaviour", behaviour.slug, *options, *demonstrations)]
    lines = [] if is_built_in else [_addition(behaviour)]
    of = ("--behaviour", behaviour.slug)
    lines.append(_line("tril", "recordings", "import", RANKED, *of, "--rank"))
    if run.unranked:
        lines.append(_line("tril", "recordings", "import", UNRANKED, *of, "--perfect"))
    anyway = ["--go-on-anyway"] if run.go_on_anyway else []
    return [*lines, _line("tril", "train", behaviour.slug, *options, *anyway)]


def _addition(behaviour: Behaviour) -> str:
    # People count rows and columns from 1.
    cells = [f"{row + 1},{column + 1}" for row, column in behaviour.target or ()]
    target = [word for cell in cells for word in ("--target", cell)]
    ordered = ["--ordered"] if behaviour.ordered else []
    # Behind "--" a name that begins with a dash is no option.
    return _line("tril", "behaviours", "add", *target, *ordered, "--", behaviour.name)


def _set(changes: Mapping[str, Any]) -> list[str]:
    return [word for path, value in changes.items() for word in ("--set", f"{path}={_text(value)}")]


def _text(value: Any) -> str:
    if isinstance(value, tuple):
        return "".join(f"{item}," for item in value)
    return str(value).lower() if isinstance(value, bool) else str(value)


def _line(*words: str) -> str:
    return shlex.join(words)
