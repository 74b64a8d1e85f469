"""Statements in words: "the green thing further to the left"."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt

from tril.games.base import Game
from tril.vocabulary.answers import subject_of
from tril.vocabulary.facts import Vocabulary
from tril.vocabulary.formations import FORMATION
from tril.vocabulary.groups import BY_PLACE, IN_ORDER, Group, Sign
from tril.vocabulary.names import kind_name, one_name
from tril.vocabulary.pieces import PIECES
from tril.vocabulary.posterior import Posterior, Statement

Array = npt.NDArray[np.float64]

MONOTONE = 0.75
"""Correlation of a group's weights with the order of its bins, from which on it has a direction."""

LEAST_SHARE = 0.3
"""Of the deviation of a statement's other group: a part that deviates less is left out."""

UNSEEN = "something that the screen does not show"
"""How a byte is called that nothing goes with."""
SURE_CORRELATION = 0.7
"""Between a fact of a byte and what goes with it, from which on one is told for the other."""

GONE = ("gone", *BY_PLACE, *IN_ORDER)
"""Aspects of what is cleared."""
_WAYS: dict[str, tuple[str, str]] = {
    "order x": ("from left to right", "from right to left"),
    "order y": ("from top to bottom", "from bottom to top"),
}


@dataclass(frozen=True)
class Telling:
    """A statement as a person reads it.

    Attributes:
        sentence: What it says, without a full stop.
        probability: Of all statements that say the same.
        groups: Indices of the groups of the most probable one of them.
        subjects: What they are about, in order; see `subject_of`.
        kinds: Kinds of things that it is about; for a relation, that of the other thing. PIECES
            stands for those of the still picture, FORMATION for the things in formation.
        detail: Which bytes of memory it was read from, for experts; empty if from none.
        statement: That statement.
    """

    sentence: str
    probability: float
    groups: tuple[int, ...]
    subjects: tuple[str, ...]
    kinds: tuple[int, ...]
    detail: str
    statement: Statement = field(compare=False, repr=False)


@dataclass(frozen=True)
class Phrase:
    """What a group of facts says.

    Attributes:
        text: A phrase of a sentence.
        kind: The kind of things that it is about; None if it is about none.
        detail: The byte of memory that it was read from, and what of it; empty if from none.
        is_seen: Whether it is about what the screen shows, or what has a name.
    """

    text: str
    kind: int | None = None
    detail: str = ""
    is_seen: bool = True


def tell(
    words: Vocabulary,
    posterior: Posterior,
    game: Game,
    meant: Collection[str] = (),
    n_tellings: int = 5,
) -> tuple[Telling, ...]:
    """Return what an order is about, the most probable first.

    Statements about the same count as one, told by the most probable of them: a byte that tells
    a thing's place is that thing, and a second group is left out where it changes little. So do
    statements that read the same.

    Args:
        words: The game's vocabulary.
        posterior: What was inferred from the order.
        game: The game.
        meant: Subjects that are told however little they change, since a person means them.
        n_tellings: How many are returned at most.
    """
    told: dict[tuple[str, ...], Telling] = {}
    reads: dict[str, tuple[str, ...]] = {}
    for statement in posterior.statements:
        parts = _parts(words, statement, game, meant)
        subject = tuple(sorted({subject_of(words, words.groups[part.group]) for part in parts}))
        sentence = ", and ".join(part.phrase.text for part in parts)
        # Bytes that nobody sees read the same and are not.
        if all(part.phrase.is_seen for part in parts):
            subject = reads.setdefault(sentence, subject)
        known = told.get(subject)
        if known is None:
            kinds = [part.phrase.kind for part in parts if part.phrase.kind is not None]
            told[subject] = Telling(
                sentence,
                statement.probability,
                tuple(part.group for part in parts),
                subject,
                tuple(dict.fromkeys(kinds)),
                "; ".join(part.phrase.detail for part in parts if part.phrase.detail),
                statement,
            )
        else:
            told[subject] = replace(known, probability=known.probability + statement.probability)
    return tuple(sorted(told.values(), key=lambda one: -one.probability)[:n_tellings])


@dataclass(frozen=True)
class _Part:
    """A group of a statement.

    Attributes:
        group: Its index.
        phrase: What it says.
        deviation: How much it differs between varied games.
    """

    group: int
    phrase: Phrase
    deviation: float


def _parts(
    words: Vocabulary, statement: Statement, game: Game, meant: Collection[str]
) -> list[_Part]:
    """Return a statement's groups with what each says.

    The most important comes first; one that is about the same, or hardly matters beside it, is left
    out, unless it is meant.
    """
    parts: list[_Part] = []
    begin = 0
    for index in statement.groups:
        group, columns = words.groups[index], words.columns[index]
        weights = statement.weights[begin : begin + group.n_facts]
        begin += group.n_facts
        deviation = float((words.pool[:, columns] @ weights).std())
        parts.append(_Part(index, phrase(words, group, weights, game), deviation))
    parts.sort(key=lambda part: -part.deviation)
    subjects = [subject_of(words, words.groups[part.group]) for part in parts]
    if len(set(subjects)) == 1:
        return parts[:1]
    kept = [
        part
        for part, subject in zip(parts, subjects, strict=True)
        if part.deviation >= LEAST_SHARE * parts[0].deviation or subject in meant
    ]
    # A thing, and a byte that goes with it, read the same.
    is_same = len({part.phrase.text for part in kept}) == 1 and kept[0].phrase.is_seen
    return kept[:1] if is_same else kept


def phrase(words: Vocabulary, group: Group, weights: Array, game: Game) -> Phrase:
    """Return what a group's weights say.

    Args:
        words: The game's vocabulary.
        group: The group.
        weights: Of its facts, not standardised, float64 (n_facts,).
        game: The game.
    """
    if group.source == "memory":
        return _of_byte(words, group, weights, game)
    return Phrase(_of_seen(words, group, weights, game), kind_of(group))


def _of_seen(words: Vocabulary, group: Group, weights: Array, game: Game) -> str:
    """Return what the weights of a group say that is about no byte."""
    if group.source == "button":
        fact = _telling_fact(words, group, weights)
        button, amount = game.controls.buttons[group.subject[0]], _amount(weights[fact])
        return (f"holding {button} {amount}", f"pressing {button} {amount} often")[fact]
    if group.source == "time":
        return f"the game going on {'longer' if weights.sum() > 0 else 'less long'}"
    if group.aspect in GONE:
        pieces = kind_name(words, _seen_kind(group), game)
        if group.aspect in BY_PLACE:
            return _of_cleared(words, group, pieces, weights)
        if group.aspect in IN_ORDER:
            # Varied games may clear nothing one of the ways. Less of one is the other.
            fact = int(np.argmax(np.abs(weights)))
            way = _WAYS[group.aspect][fact if weights[fact] > 0 else 1 - fact]
            return f"{pieces} cleared {way}"
        fact = _telling_fact(words, group, weights)
        if fact == 0:
            return f"{'more' if weights[fact] > 0 else 'fewer'} {pieces} cleared"
        return f"{pieces} cleared {_amount(weights[fact])} often"
    name = one_name(words, _seen_kind(group), game)
    if group.aspect == "count":
        fact = _telling_fact(words, group, weights)
        return f"{'more' if weights[fact] > 0 else 'fewer'} of {name}"
    if group.aspect == "comes":
        fact = _telling_fact(words, group, weights)
        how = ("appearing", "vanishing")[fact]
        return f"{name} {how} {_amount(weights[fact])} often"
    if group.aspect == "moves":
        fact = _telling_fact(words, group, weights)
        way = ("right", "left", "down", "up")[fact]
        return f"{name} moving {way} {_amount(weights[fact])}"
    if group.aspect in ("x", "y"):
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


def _of_cleared(words: Vocabulary, group: Group, pieces: str, weights: Array) -> str:
    """Return where pieces are cleared, and whether they are not elsewhere."""
    if _direction(weights):
        return f"more {pieces} cleared {_part(words, group, weights)}"
    unwanted = weights <= -np.abs(weights).max() / 2
    spared = np.flatnonzero(unwanted)
    is_inner = len(spared) > 0 and spared[0] > 0 and spared[-1] < len(weights) - 1
    if is_inner and len(spared) == np.ptp(spared) + 1:
        return f"fewer {pieces} cleared {_part(words, group, unwanted.astype(np.float64))}"
    part = _part(words, group, weights)
    good = weights > (weights.max() + weights.min()) / 2
    if not len(spared) or not (unwanted | good).all():
        return f"more {pieces} cleared {part}"
    only = "" if part.startswith("anywhere") else "only "
    return f"{pieces} cleared {only}{part}"


def _amount(weight: float) -> str:
    """Return whether what has a weight is wanted or not."""
    return "more" if weight > 0 else "less"


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


def _of_byte(words: Vocabulary, group: Group, weights: Array, game: Game) -> Phrase:
    """Return what the weights of a byte's facts say: of a thing, or of what goes with the byte."""
    twin, byte = group.twin, group.subject[0]
    named = game.memory_names.get(byte)
    bare = _of_bare_byte(words, group, weights)
    detail = f"memory {byte}" + (f" ({named})" if named else "") + f" {bare}"
    if twin is not None and group.aspect == "value":
        placed = Group("thing", (twin.kind,), twin.axis, group.edges)
        return Phrase(_of_seen(words, placed, weights, game), twin.kind, detail)
    if twin is not None:
        rises, falls, _ = weights * (1, 1, 0)
        ways = ("right", "left") if twin.axis == "x" else ("down", "up")
        if (rises > 0) == (falls > 0):
            way = f"{ways[1]} or {ways[0]}" if twin.axis == "x" else "up or down"
        else:
            way = ways[int((abs(rises) >= abs(falls)) != (twin.direction > 0))]
        amount = _amount(rises if abs(rises) >= abs(falls) else falls)
        name = kind_name(words, twin.kind, game)
        return Phrase(f"{name} moving {way} {amount}", twin.kind, detail)
    if named:
        return Phrase(f"{named}: {bare}", None, detail)
    fact = _telling_fact(words, group, weights)
    is_more = bool(weights[fact] > 0)
    sign = group.signs[fact] if group.signs else None
    if sign is None:
        how = "in one of its states" if group.aspect == "bits" else bare
        return Phrase(f"{UNSEEN}, {how}", None, detail, is_seen=False)
    kind = kind_of(sign.group)
    if abs(sign.correlation) >= SURE_CORRELATION:
        return Phrase(_of_sign(words, sign, is_more == (sign.correlation > 0), game), kind, detail)
    # What is hardly ever there with it and is less often: its opposite is more often, with it.
    often = "more often" if is_more == (sign.correlation > 0) else "less often"
    clause = _clause(words, sign, game)
    return Phrase(f"something that happens {often}, mostly while {clause}", kind, detail)


def _of_bare_byte(words: Vocabulary, group: Group, weights: Array) -> str:
    """Return what the weights of a byte's facts say of the byte."""
    if group.aspect == "changes":
        rises, falls, _ = weights
        if rises > 0 and falls > 0:
            return "changing more often"
        if rises <= 0 and falls <= 0:
            return "changing less often"
        up = abs(rises) >= abs(falls)
        amount = _amount(rises if up else falls)
        return f"{'rising' if up else 'falling'} {amount} often"
    if group.aspect == "bits":
        bit = _telling_fact(words, group, weights)
        return f"with bit {bit} {'on' if weights[bit] > 0 else 'off'}"
    if group.twin is not None and not group.twin.direction:
        return "by a table"
    if group.twin is not None and group.twin.direction < 0:
        weights = weights[::-1]
    return _range(group, weights, "value") if group.twin is None or _direction(weights) else ""


def _of_sign(words: Vocabulary, sign: Sign, is_more: bool, game: Game) -> str:
    """Return that what goes with a byte is there, or happens, more or less."""
    group = sign.group
    if group.edges:
        return f"{_clause(words, sign, game)} {'more' if is_more else 'less'} often"
    weights = np.zeros(group.n_facts)
    weights[sign.fact] = 1 if is_more else -1
    if group.aspect == "count" and sign.fact == 0:
        often = f"{'more' if is_more else 'less'} often"
        return f"{kind_name(words, group.subject[0], game)} there {often}"
    return _of_seen(words, group, weights, game)


def _clause(words: Vocabulary, sign: Sign, game: Game) -> str:
    """Return what goes with a byte as it is said after "while"."""
    group, fact = sign.group, sign.fact
    if group.source == "button":
        return f"{game.controls.buttons[group.subject[0]]} is {('held', 'pressed')[fact]}"
    if group.aspect in GONE:
        pieces = kind_name(words, _seen_kind(group), game)
        if group.aspect == "gone":
            return f"{pieces} are {('cleared', 'being cleared')[fact]}"
        weights = np.eye(group.n_facts)[fact]
        return f"{pieces} are cleared {_part(words, group, weights)}"
    name = one_name(words, _seen_kind(group), game)
    if group.aspect == "count":
        return f"{name} is there" if fact == 0 else f"there are more of {name}"
    if group.aspect == "comes":
        return f"{name} {('appears', 'vanishes')[fact]}"
    if group.aspect == "moves":
        return f"{name} moves {('right', 'left', 'down', 'up')[fact]}"
    if group.aspect in ("x", "y"):
        weights = np.zeros(group.n_facts)
        weights[fact] = 1
        return f"{name} is {_span(*_bounds(group, weights), group.aspect)}"
    player = kind_name(words, group.subject[0], game)
    if group.aspect in ("dx", "dy"):
        weights = np.zeros(group.n_facts)
        weights[fact] = 1
        return f"{name} is {_offset(*_bounds(group, weights), group.aspect[-1])} {player}"
    how = {"near": "near", "level x": "in line with", "level y": "level with"}[group.aspect]
    return f"{player} is {how} {name}"


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


def _part(words: Vocabulary, group: Group, weights: Array) -> str:
    """Return where things are cleared: on the screen, or in a formation."""
    tell_part = _part_of_formation if group.source == "formation" else _part_of_screen
    return tell_part(words, group, weights)


def _part_of_formation(words: Vocabulary, group: Group, weights: Array) -> str:
    """Return where in a formation things are cleared: "in column 3 of 6 from the left"."""
    formation = words.scene.formation
    assert formation is not None
    is_column = group.aspect == "gone x"
    line = "column" if is_column else "row"
    direction = _direction(weights)
    if direction:
        near, far = ("left", "right") if is_column else ("top", "bottom")
        return f"towards the {far if direction > 0 else near}"
    low, high = _bounds(group, weights)
    n_lines = int(formation.lines[0 if is_column else 1].max()) + 1
    first = 1 if low is None else math.ceil(low) + 1
    last = n_lines if high is None else math.floor(high) + 1
    if not is_column:
        # As the lowest is the nearest in most games.
        first, last = n_lines - last + 1, n_lines - first + 1
    numbers = f"{line} {first}" if first == last else f"{line}s {first} to {last}"
    return f"in {numbers} of {n_lines} from the {'left' if is_column else 'bottom'}"


def _part_of_screen(words: Vocabulary, group: Group, weights: Array) -> str:
    """Return where pieces are cleared: "on the left (within 60 px of the edge)"."""
    axis = group.aspect[-1]
    near, far = {"x": ("left", "right"), "y": ("top", "bottom")}[axis]
    direction = _direction(weights)
    if direction:
        return f"towards the {far if direction > 0 else near}"
    low, high = _bounds(group, weights)
    height, width = words.scene.beginning.shape
    length = width if axis == "x" else height
    on = "on" if axis == "x" else "at"
    if low is not None and high is not None:
        is_middle = abs(low + high - length) <= length / 3
        extent = f"{low:.0f} to {high:.0f} px from the {near}"
        return f"in the middle ({extent})" if is_middle else extent
    if low is None and high is None:
        return _span(low, high, axis)
    side, other = (near, far) if low is None else (far, near)
    covered_px = length - low if low is not None else high or 0.0
    # What covers more than half is told by the edge that it leaves out.
    if covered_px <= length / 2:
        return f"{on} the {side} (within {covered_px:.0f} px of the edge)"
    return f"anywhere but {on} the {other} (within {length - covered_px:.0f} px of the edge)"


def _range(group: Group, weights: Array, aspect: str) -> str:
    direction = _direction(weights)
    if direction:
        ways = {
            "x": ("further to the left", "further to the right"),
            "y": ("higher up", "lower down"),
            "value": ("smaller", "larger"),
        }
        return ways[aspect][direction > 0]
    return _span(*_bounds(group, weights), aspect)


def _span(low: float | None, high: float | None, aspect: str) -> str:
    """Return what is from low to high; None has no bound."""
    unit = {"x": " px from the left", "y": " px from the top", "value": ""}[aspect]
    less, more = ("below", "above") if aspect == "value" else ("less than", "more than")
    if low is None or high is None:
        if low is None and high is None:
            return "at some place"
        return f"{less} {high:.0f}{unit}" if low is None else f"{more} {low:.0f}{unit}"
    return f"between {low:.0f} and {high:.0f}{unit}"


def kind_of(group: Group) -> int | None:
    """Return the kind that a group is about, or PIECES or FORMATION; None if it is about none.

    Of a relation it is the other thing.
    """
    if group.twin is not None:
        return group.twin.kind
    return _seen_kind(group) if group.source in ("thing", "pieces", "formation") else None


def _seen_kind(group: Group) -> int:
    """Return the kind of a group about what is seen, or PIECES or FORMATION."""
    if group.source == "pieces":
        return PIECES
    return FORMATION if group.source == "formation" else group.subject[-1]
