"""What a person can point at in a game, and what a statement can say of it."""

from __future__ import annotations

from dataclasses import dataclass

from tril.games.base import Game
from tril.vocabulary.answers import subject_of
from tril.vocabulary.facts import Vocabulary
from tril.vocabulary.groups import Group
from tril.vocabulary.names import kind_name, one_name
from tril.vocabulary.sentences import GONE, kind_of

_OF_THING = {
    "x": "{thing} further to the left or right",
    "y": "{thing} higher up or lower down",
    "count": "more or fewer of {thing}",
    "comes": "{thing} appearing or vanishing more or less often",
    "moves": "{thing} moving more or less",
}
_OF_RELATION = {
    "dx": "{thing} more to the left or right of {player}",
    "dy": "{thing} more above or below {player}",
    "level x": "{player} in line with {thing} or not",
    "level y": "{player} level with {thing} or not",
    "near": "{player} near {thing} or away from it",
}
_OF_GONE = {
    "gone": "more or fewer {things} cleared",
    "gone x": "{things} cleared further to the left or right",
    "gone y": "{things} cleared higher up or lower down",
    "order x": "{things} cleared from left to right or from right to left",
    "order y": "{things} cleared from top to bottom or from bottom to top",
}
_OF_MEMORY = {
    "value": "{memory}: larger or smaller",
    "changes": "{memory}: changing more or less often",
    "bits": "{memory}: in one state or another",
}


@dataclass(frozen=True)
class Pointed:
    """What can be meant of a thing, or of something that has no place on the screen.

    Attributes:
        subject: See `tril.vocabulary.answers.subject_of`.
        sentence: What differs between games; the order says which way is better.
        kind: Index of the thing's kind; None if it is no thing.
    """

    subject: str
    sentence: str
    kind: int | None


def meanings_of(words: Vocabulary, game: Game) -> tuple[Pointed, ...]:
    """Return all that a vocabulary has groups for and a person can name, each once.

    Bytes of memory that neither tell a thing's place nor have a name are left out.
    """
    pointed: dict[str, Pointed] = {}
    for group in words.groups:
        subject, sentence = subject_of(words, group), _open_sentence(words, group, game)
        if sentence is not None and subject not in pointed:
            pointed[subject] = Pointed(subject, sentence, kind_of(group))
    return tuple(pointed.values())


def _open_sentence(words: Vocabulary, group: Group, game: Game) -> str | None:
    """Return what a group can say, with neither way preferred; None where nobody can name it."""
    kind = kind_of(group)
    if kind is not None:
        thing = kind_name(words, kind, game)
        if group.aspect in GONE:
            return _OF_GONE[group.aspect].format(things=thing)
        if group.twin is not None:
            aspect = group.twin.axis if group.aspect == "value" else "moves"
            return _OF_THING[aspect].format(thing=thing)
        if group.aspect in _OF_THING:
            return _OF_THING[group.aspect].format(thing=thing)
        player = kind_name(words, group.subject[0], game)
        return _OF_RELATION[group.aspect].format(thing=one_name(words, kind, game), player=player)
    if group.source == "button":
        return f"holding {game.controls.buttons[group.subject[0]]} more or less"
    if group.source == "time":
        return "the game lasting longer or shorter"
    byte = group.subject[0]
    named = game.memory_names.get(byte)
    return named and _OF_MEMORY[group.aspect].format(memory=named)
