"""Statements in words: "the green thing further to the left"."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt

from tril.games.base import Game
from tril.vocabulary.answers import subject_of
from tril.vocabulary.facts import Group, Vocabulary
from tril.vocabulary.posterior import Posterior, Statement

Array = npt.NDArray[np.float64]

MONOTONE = 0.75
"""Correlation of a group's weights with the order of its bins, from which on it has a direction."""

LEAST_SHARE = 0.3
"""Of the deviation of a statement's other group: a part that deviates less is left out."""

_COLOURS: dict[str, tuple[int, int, int]] = {
    "black": (0, 0, 0),
    "gray": (128, 128, 128),
    "white": (236, 236, 236),
    "red": (200, 50, 50),
    "pink": (230, 130, 170),
    "orange": (215, 120, 50),
    "brown": (120, 75, 30),
    "yellow": (215, 205, 70),
    "green": (70, 150, 60),
    "light green": (140, 215, 130),
    "cyan": (80, 190, 190),
    "blue": (60, 80, 190),
    "light blue": (110, 150, 230),
    "purple": (140, 60, 170),
}


@dataclass(frozen=True)
class Telling:
    """A statement as a person reads it.

    Attributes:
        sentence: What it says, without a full stop.
        probability: Of all statements that say the same.
        groups: Indices of the groups of the most probable one of them.
        subjects: What they are about, in order; see `subject_of`.
        statement: That statement.
    """

    sentence: str
    probability: float
    groups: tuple[int, ...]
    subjects: tuple[str, ...]
    statement: Statement = field(compare=False, repr=False)

    def kinds(self, words: Vocabulary) -> tuple[int, ...]:
        """Return the kinds of things that it is about, for a relation, that of the other thing."""
        kinds: list[int] = []
        for index in self.groups:
            group = words.groups[index]
            if group.twin is not None:
                kinds.append(group.twin.kind)
            elif group.source == "thing":
                kinds.append(group.subject[-1])
        return tuple(dict.fromkeys(kinds))


def tell(
    words: Vocabulary,
    posterior: Posterior,
    game: Game,
    meant: Collection[str] = (),
    n_tellings: int = 5,
) -> tuple[Telling, ...]:
    """Return what an order is about, the most probable first.

    Statements about the same count as one, told by the most probable of them: a byte that follows
    a thing is that thing, and a second group is left out where it changes little.

    Args:
        words: The game's vocabulary.
        posterior: What was inferred from the order.
        game: The game.
        meant: Subjects that are told however little they change, since a person means them.
        n_tellings: How many are returned at most.
    """
    told: dict[tuple[str, ...], Telling] = {}
    for statement in posterior.statements:
        parts = _parts(words, statement, game, meant)
        subject = tuple(sorted({subject_of(words, words.groups[index]) for index, _, _ in parts}))
        known = told.get(subject)
        if known is None:
            sentence = ", and ".join(text for _, text, _ in parts)
            groups = tuple(index for index, _, _ in parts)
            told[subject] = Telling(sentence, statement.probability, groups, subject, statement)
        else:
            told[subject] = replace(known, probability=known.probability + statement.probability)
    return tuple(sorted(told.values(), key=lambda one: -one.probability)[:n_tellings])


def _parts(
    words: Vocabulary, statement: Statement, game: Game, meant: Collection[str]
) -> list[tuple[int, str, float]]:
    """Return a statement's groups, what each says and how much it differs between varied games.

    The most important comes first; one that is about the same, or hardly matters beside it, is left
    out, unless it is meant.
    """
    parts: list[tuple[int, str, float]] = []
    begin = 0
    for index in statement.groups:
        group, columns = words.groups[index], words.columns[index]
        weights = statement.weights[begin : begin + group.n_facts]
        begin += group.n_facts
        deviation = float((words.pool[:, columns] @ weights).std())
        parts.append((index, phrase(words, group, weights, game), deviation))
    parts.sort(key=lambda part: -part[2])
    subjects = [subject_of(words, words.groups[index]) for index, _, _ in parts]
    if len(set(subjects)) == 1:
        return parts[:1]
    return [
        part
        for part, subject in zip(parts, subjects, strict=True)
        if part[2] >= LEAST_SHARE * parts[0][2] or subject in meant
    ]


def phrase(words: Vocabulary, group: Group, weights: Array, game: Game) -> str:
    """Return what a group's weights say.

    Args:
        words: The game's vocabulary.
        group: The group.
        weights: Of its facts, not standardised, float64 (n_facts,).
        game: The game.
    """
    if group.source == "button":
        fact = _telling_fact(words, group, weights)
        how = ("held {}", "pressed {} often")[fact].format("more" if weights[fact] > 0 else "less")
        return f"{game.controls.buttons[group.subject[0]]} {how}"
    if group.source == "time":
        return f"the game going on {'longer' if weights.sum() > 0 else 'less long'}"
    if group.source == "memory":
        return _of_byte(words, group, weights, game)
    name = kind_name(words, group.subject[-1], game)
    if group.aspect == "count":
        fact = _telling_fact(words, group, weights)
        return f"{'more' if weights[fact] > 0 else 'fewer'} of {name}"
    if group.aspect == "moves":
        fact = _telling_fact(words, group, weights)
        way = ("right", "left", "down", "up")[fact]
        return f"{name} moving {way} {'more' if weights[fact] > 0 else 'less'}"
    if len(group.subject) == 1:
        return f"{name} {_range(group, weights, group.aspect)}"
    player = kind_name(words, group.subject[0], game)
    if group.aspect == "near":
        return f"{player} {'near' if weights.sum() > 0 else 'away from'} {name}"
    if group.aspect in ("level x", "level y"):
        how = "level with" if group.aspect == "level y" else "in line with"
        return f"{player} {'' if weights.sum() > 0 else 'not '}{how} {name}"
    axis = group.aspect[-1]
    direction = _direction(weights)
    if direction:
        sides = {"x": ("left", "right"), "y": ("above", "below")}[axis]
        side = sides[direction > 0]
        return f"{name} more {f'to the {side} of' if axis == 'x' else side} {player}"
    return f"{name} {_offset(*_bounds(group, weights), axis)} {player}"


def _offset(low: float | None, high: float | None, axis: str) -> str:
    """Return where from low to high pixels is as seen from something; None has no bound."""
    before, after = {
        "x": ("px to the left of", "px to the right of"),
        "y": ("px above", "px below"),
    }[axis]
    if low is None and high is None:
        return "somewhere about"
    if low is None:
        assert high is not None
        return f"more than {-high:.0f} {before}" if high < 0 else f"at most {high:.0f} {after}"
    if high is None:
        return f"more than {low:.0f} {after}" if low >= 0 else f"at most {-low:.0f} {before}"
    if high <= 0:
        return f"{-high:.0f} to {-low:.0f} {before}"
    if low >= 0:
        return f"{low:.0f} to {high:.0f} {after}"
    return f"between {-low:.0f} {before} and {high:.0f} {after}"


def _telling_fact(words: Vocabulary, group: Group, weights: Array) -> int:
    """Return the index of the fact of a group by which its weights tell varied games apart most.

    Signs may differ within a group: who holds a button longer presses it less often.
    """
    columns = words.columns[words.groups.index(group)]
    return int(np.argmax(np.abs(weights * words.pool[:, columns].std(0))))


def _of_byte(words: Vocabulary, group: Group, weights: Array, game: Game) -> str:
    byte = group.subject[0]
    named = game.memory_names.get(byte)
    name = f"memory {byte}" + (f" ({named})" if named else "")
    if group.aspect == "changes":
        rises, falls, _ = weights
        if rises > 0 and falls > 0:
            return f"{name} changing more often"
        if rises <= 0 and falls <= 0:
            return f"{name} changing less often"
        up = abs(rises) >= abs(falls)
        amount = "more" if (rises if up else falls) > 0 else "less"
        return f"{name} {'rising' if up else 'falling'} {amount} often"
    if group.aspect == "bits":
        bit = int(np.argmax(np.abs(weights)))
        return f"{name} with bit {bit} {'on' if weights[bit] > 0 else 'off'}"
    if group.twin is not None:
        twin = group.twin
        edges = tuple(twin.place(edge) for edge in group.edges)
        if twin.scale < 0:
            edges, weights = edges[::-1], weights[::-1]
        placed = Group("thing", (twin.kind,), "x" if twin.axis == "x" else "y", edges)
        return phrase(words, placed, weights, game)
    return f"{name} {_range(group, weights, 'value')}"


def _direction(weights: Array) -> int:
    """Return 1 if the weights rise with the bins, -1 if they fall, 0 if they do neither."""
    if len(weights) == 2:
        return int(np.sign(weights[1] - weights[0]))
    # Two values are a range, which has bounds.
    if len(np.unique(weights)) < 3:
        return 0
    correlation = np.corrcoef(np.arange(len(weights)), weights)[0, 1]
    return 0 if abs(correlation) < MONOTONE else int(np.sign(correlation))


def _bounds(group: Group, weights: Array) -> tuple[float | None, float | None]:
    """Return the bounds of the bins around the best one that are better than the middle."""
    good = weights > (weights.max() + weights.min()) / 2
    first = last = int(np.argmax(weights))
    while first and good[first - 1]:
        first -= 1
    while last < len(weights) - 1 and good[last + 1]:
        last += 1
    low = group.edges[first - 1] if first else None
    high = group.edges[last] if last < len(group.edges) else None
    return low, high


def _range(group: Group, weights: Array, aspect: str) -> str:
    direction = _direction(weights)
    if direction:
        ways = {
            "x": ("further to the left", "further to the right"),
            "y": ("higher up", "lower down"),
            "value": ("smaller", "larger"),
        }
        return ways[aspect][direction > 0]
    low, high = _bounds(group, weights)
    unit = {"x": " px from the left", "y": " px from the top", "value": ""}[aspect]
    less, more = ("below", "above") if aspect == "value" else ("less than", "more than")
    if low is None or high is None:
        if low is None and high is None:
            return "at some place"
        return f"{less} {high:.0f}{unit}" if low is None else f"{more} {low:.0f}{unit}"
    return f"between {low:.0f} and {high:.0f}{unit}"


def kind_name(words: Vocabulary, index: int, game: Game) -> str:
    """Return what a kind of things is called before a person names it."""
    kind = words.kinds[index]
    if index == words.player:
        return "what you steer"
    width, height = round(sum(kind.width) / 2), round(sum(kind.height) / 2)
    return f"the {colour_name(_rgb(kind.colour, game))} thing of {width}x{height} px"


def _rgb(colour: int, game: Game) -> Array:
    palette = game.screen.palette
    if palette is not None:
        rgb: Array = palette[colour].astype(np.float64)
        return rgb
    return np.array([colour & 0xE0, (colour & 0x1C) << 3, (colour & 3) << 6], np.float64) + 16


def colour_name(rgb: Array) -> str:
    """Return the name of the nearest of fourteen colours."""
    names = list(_COLOURS)
    distance = np.linalg.norm(np.array(list(_COLOURS.values())) - rgb, axis=1)
    return names[int(distance.argmin())]
