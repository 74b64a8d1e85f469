"""What a person can mean by pointing at a thing."""

from __future__ import annotations

from tril.games import game_named
from tril.vocabulary.answers import Answer, Conditions, subject_of
from tril.vocabulary.facts import Vocabulary
from tril.vocabulary.names import kind_name
from tril.vocabulary.pointing import meanings_of


def test_each_thing_has_what_the_vocabulary_has_groups_for(words: Vocabulary) -> None:
    pong = game_named("pong")
    pointed = meanings_of(words, pong)
    assert words.player is not None
    of_player = [one.sentence for one in pointed if one.kind == words.player]
    assert of_player == [
        "what you steer further to the left or right",
        "what you steer moving more or less",
    ]
    other = kind_name(words, 1 - words.player, pong)
    of_other = {
        one.sentence.replace(other, "it") for one in pointed if one.kind == 1 - words.player
    }
    assert "it further to the left or right" in of_other
    assert "what you steer near it or away from it" in of_other
    assert "it more to the left or right of what you steer" in of_other
    # It is always at the same height, and there is always one.
    assert not any("higher" in one or "fewer" in one for one in of_other)


def test_what_is_no_thing_has_a_place_only_if_a_person_can_name_it(words: Vocabulary) -> None:
    rest = [one.sentence for one in meanings_of(words, game_named("pong")) if one.kind is None]
    assert "the game lasting longer or shorter" in rest
    assert sum(one.startswith("holding ") for one in rest) == 2
    assert not any("memory" in one for one in rest)


def test_each_is_meant_once_and_leaves_its_statements_possible(words: Vocabulary) -> None:
    pointed = meanings_of(words, game_named("pong"))
    subjects = [one.subject for one in pointed]
    assert len(set(subjects)) == len(subjects)
    known = {subject_of(words, group) for group in words.groups}
    for subject in subjects:
        assert subject in known
        conditions = Conditions.of(words, [Answer(frozenset({subject}), True)])
        assert conditions.groups
