"""Names of things: by a person, by the game, or by colour and size; and keys that stay the same."""

from __future__ import annotations

import re

import numpy as np
import numpy.typing as npt

from tril.games.base import Game
from tril.vocabulary.facts import Vocabulary
from tril.vocabulary.formations import FORMATION
from tril.vocabulary.kinds import Kind, Look
from tril.vocabulary.pieces import PIECES
from tril.vocabulary.trace import rgb_of

Array = npt.NDArray[np.float64]

ONE_COLOUR = 0.6
"""Share of the pieces that have a colour by which all are called."""

_WITHOUT_LOOK = {PIECES: "pieces", FORMATION: "formation"}
_LOOK = re.compile(r"(\d+):(\d+)-(\d+)x(\d+)-(\d+)")
_DETERMINERS = frozenset(("the", "a", "an", "my", "our", "your", "his", "her", "their"))

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


def kind_name(words: Vocabulary, index: int, game: Game) -> str:
    """Return what a kind of things is called: by a person, by the game, or by colour and size."""
    given = given_name(words, index)
    if given is not None:
        return bare_name(given) if index in (PIECES, FORMATION) else _with_article(given)
    if index == PIECES:
        return pieces_name(words, game)
    if index == FORMATION:
        return game.formation or "things in formation"
    kind = words.kinds[index]
    thing = game.things.get(kind.name) if kind.name is not None else None
    if thing:
        return _with_article(thing.title)
    if index == words.player:
        return "what you steer"
    look = kind.looks[0]
    width, height = round(sum(look.width) / 2), round(sum(look.height) / 2)
    return f"the {colour_name(rgb_of(look.colour, game))} thing of {width}x{height} px"


def _with_article(name: str) -> str:
    """Return a thing's name as a sentence has it; proper names have no article."""
    bare = bare_name(name)
    if bare != name:
        return name[0].lower() + name[1:]
    return name if name[0].isupper() else f"the {name}"


def bare_name(name: str) -> str:
    """Return a name without the article or possessive that it begins with."""
    first, _, rest = name.partition(" ")
    return rest if rest and first.lower() in _DETERMINERS else name


def one_name(words: Vocabulary, index: int, game: Game) -> str:
    """Return what a kind is called where one of it is meant: of a formation the nearest item."""
    name = kind_name(words, index, game)
    return f"the nearest of the {name}" if index == FORMATION else name


def pieces_name(words: Vocabulary, game: Game) -> str:
    """Return what the pieces of the still picture are called: by the game, or by their colour."""
    if game.pieces:
        return game.pieces
    assert words.pieces is not None
    amounts = np.bincount(words.scene.beginning[words.pieces])
    colour = int(amounts.argmax())
    if amounts[colour] < ONE_COLOUR * amounts.sum():
        return "pieces of the picture"
    return f"{colour_name(rgb_of(colour, game))} pieces"


def colour_name(rgb: Array) -> str:
    """Return the name of the nearest of fourteen colours."""
    names = list(_COLOURS)
    distance = np.linalg.norm(np.array(list(_COLOURS.values())) - rgb, axis=1)
    return names[int(distance.argmin())]


def thing_key(words: Vocabulary, index: int) -> str:
    """Return the key of a kind of things, PIECES or FORMATION, in any vocabulary of the game."""
    if index in _WITHOUT_LOOK:
        return _WITHOUT_LOOK[index]
    return look_key(words.kinds[index])


def given_name(words: Vocabulary, index: int) -> str | None:
    """Return the name that a person gave to a kind of things, if any."""
    key = thing_key(words, index)
    if key in words.names:
        return words.names[key] or None
    # It was named when another of its looks was the most frequent one; the latest name counts.
    given = [name for old, name in words.names.items() if known_look(words, old) == key]
    return given[-1] or None if given else None


def known_look(words: Vocabulary, word: str) -> str:
    """Return the look by which a vocabulary names a thing that has this one; the word if none."""
    parsed = _LOOK.fullmatch(word)
    if parsed is None:
        return word
    colour, *sizes = map(int, parsed.groups())
    named = Look(colour, (sizes[0], sizes[1]), (sizes[2], sizes[3]))
    names = [look_key(kind) for kind in words.kinds]
    if word in names:
        return word
    for kind, name in zip(words.kinds, names, strict=True):
        if any(_overlap(look, named) for look in kind.looks):
            return name
    return word


def _overlap(look: Look, other: Look) -> bool:
    return look.colour == other.colour and all(
        low <= other_high and other_low <= high
        for (low, high), (other_low, other_high) in (
            (look.width, other.width),
            (look.height, other.height),
        )
    )


def look_key(kind: Kind) -> str:
    """Return the key of a kind's most frequent look: its colour and size."""
    look = kind.looks[0]
    (narrow, wide), (low, high) = look.width, look.height
    return f"{look.colour}:{narrow}-{wide}x{low}-{high}"
