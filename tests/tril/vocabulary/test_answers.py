"""What answers to statements leave possible."""

from __future__ import annotations

import numpy as np
import pytest

from tests.tril.vocabulary.test_facts import played
from tril.games import game_named
from tril.vocabulary.answers import Answer, Conditions, kinds_about, known_subject, subject_of
from tril.vocabulary.facts import Vocabulary
from tril.vocabulary.names import kind_name, thing_key
from tril.vocabulary.posterior import NothingPossible
from tril.vocabulary.sentences import Telling, tell
from tril.vocabulary.understanding import understand


def told(words: Vocabulary, *answers: Answer) -> tuple[Telling, ...]:
    games = [played(100 + place, centre=18.0 * place + 12) for place in range(8)]
    summaries = np.stack([words.summary(words.facts(one)) for one in games])
    understood = understand(words, summaries, [[place] for place in range(8)], answers=answers)
    return tell(words, understood.posterior, game_named("pong"), understood.meant)


def answer(telling: Telling, meant: bool) -> Answer:
    return Answer(frozenset(telling.subjects), meant)


def test_subjects_name_things_by_their_looks_and_a_byte_by_what_it_follows(
    words: Vocabulary,
) -> None:
    subjects = {subject_of(words, group) for group in words.groups}
    assert {"thing 40:8-8x6-6 x", "memory 5 value", "button 1 held", "time played"} <= subjects
    # Byte 3 is the steered thing's place.
    assert "memory 3 value" not in subjects


def test_what_is_meant_is_part_of_every_statement(words: Vocabulary) -> None:
    meant = told(words)[1]
    after = told(words, answer(meant, True))
    assert all(set(meant.subjects) <= set(one.subjects) for one in after)
    assert sum(one.probability for one in after) == pytest.approx(1, abs=0.2)


def test_what_is_not_meant_is_gone_however_it_is_seen(words: Vocabulary) -> None:
    first = told(words)[0]
    after = told(words, answer(first, False))
    assert after
    assert not any(set(first.subjects) <= set(one.subjects) for one in after)


def test_two_that_are_meant_hold_together_and_of_three_the_latest(words: Vocabulary) -> None:
    buttons = [Answer(frozenset({f"button {number} held"}), True) for number in range(2)]
    assert {one.subjects for one in told(words, *buttons)} == {("button 0 held", "button 1 held")}
    place = Answer(frozenset({"thing 40:8-8x6-6 x"}), True)
    conditions = Conditions.of(words, [*buttons, place])
    assert conditions.meant == {"button 1 held", "thing 40:8-8x6-6 x"}


def test_an_answer_about_what_is_not_in_the_vocabulary_is_ignored(words: Vocabulary) -> None:
    for subject in ("thing 99:1-2x1-2 x", "memory 3", "memory", "thing", " "):
        assert kinds_about(words, [subject]) == ()
        for meant in (True, False):
            assert told(words, Answer(frozenset({subject}), meant)) == told(words)


def test_a_thing_is_called_by_the_name_that_a_person_gave_it(words: Vocabulary) -> None:
    pong = game_named("pong")
    steered = thing_key(words, 0)
    assert steered == "40:8-8x6-6"
    for name, shown in (
        ("bat", "the bat"),
        ("the bat", "the bat"),
        ("My bat", "my bat"),
        ("Bob", "Bob"),
    ):
        assert kind_name(words.with_names({steered: name}), 0, pong) == shown
        assert kind_name(words.with_names({steered: name}), 1, pong) == kind_name(words, 1, pong)
    # It was named by an earlier vocabulary, in which another of its looks was the most frequent.
    assert kind_name(words.with_names({"40:7-9x5-6": "bat"}), 0, pong) == "the bat"
    # The latest name counts, under whichever look, and an empty one removes it.
    older = {"40:7-9x5-6": "bat", "40:8-9x6-6": "club"}
    assert kind_name(words.with_names(older), 0, pong) == "the club"
    assert kind_name(words.with_names(older | {steered: ""}), 0, pong) == "what you steer"
    # A name of what this vocabulary does not have.
    assert kind_name(words.with_names({"99:1-2x1-2": "bat"}), 0, pong) == "what you steer"


@pytest.mark.parametrize(
    ("former", "today"),
    [
        ("thing 40:7-9x5-6 x", "thing 40:8-8x6-6 x"),
        ("thing 40:7-9x5-6 ~ 80:3-4x4-4 dx", "thing 40:8-8x6-6 ~ 80:4-4x4-4 dx"),
        ("memory 3 value", "thing 40:8-8x6-6 x"),
        ("memory 3 changes", "thing 40:8-8x6-6 moves"),
        ("memory 5 value", "memory 5 value"),
        ("thing 41:8-8x6-6 x", "thing 41:8-8x6-6 x"),
        ("time played", "time played"),
    ],
)
def test_what_another_vocabulary_named_is_still_known(
    words: Vocabulary, former: str, today: str
) -> None:
    assert known_subject(words, former) == today
    conditions = Conditions.of(words, [Answer(frozenset({former}), True)])
    assert conditions.meant == ({today} if "41" not in today else frozenset())


def test_things_are_found_by_subjects(words: Vocabulary) -> None:
    player = words.player
    assert player is not None
    assert kinds_about(words, ["memory 3 value", "button 0 held"]) == (player,)
    assert kinds_about(words, ["thing 40:8-8x6-6 ~ 80:3-4x4-4 dx"]) == (1 - player,)
    assert kinds_about(words, ["thing 99:8-8x6-6 x", "time played"]) == ()


def test_where_everything_is_rejected_nothing_is_possible(words: Vocabulary) -> None:
    subjects = {subject_of(words, group) for group in words.groups}
    with pytest.raises(NothingPossible):
        told(words, *(Answer(frozenset({one}), False) for one in subjects))


def test_what_is_meant_is_not_rejected_with_what_it_is_a_part_of(words: Vocabulary) -> None:
    one, both = frozenset({"button 0 held"}), frozenset({"button 0 held", "button 1 held"})
    conditions = Conditions.of(words, [Answer(both, True), Answer(one, False)])
    assert conditions.meant == both
    assert conditions.excluded == ()
