"""Answers to statements: "this is it", "not this", and which statements they leave possible."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from tril.vocabulary.facts import Vocabulary
from tril.vocabulary.formations import FORMATION
from tril.vocabulary.groups import Group
from tril.vocabulary.names import known_look, look_key
from tril.vocabulary.pieces import PIECES

MOST_SUBJECTS = 2
"""Of a statement."""


@dataclass(frozen=True)
class Answer:
    """What a person said of a statement.

    Attributes:
        subjects: What the statement is about, see `subject_of`.
        meant: Whether it is what they mean; else it is not.
    """

    subjects: frozenset[str]
    meant: bool


def subject_of(words: Vocabulary, group: Group) -> str:
    """Return what a group is about: "thing 12:7-8x10-10 x", "memory 28 changes", "time played".

    It names a thing by its most frequent look, its colour and size, so that it means the same in
    another vocabulary of the game. A byte that tells a thing's place is that thing.
    """
    if group.twin is not None:
        aspect = group.twin.axis if group.aspect == "value" else "moves"
        return f"thing {look_key(words.kinds[group.twin.kind])} {aspect}"
    if group.source == "thing":
        kinds = " ~ ".join(look_key(words.kinds[index]) for index in group.subject)
        return f"thing {kinds} {group.aspect}"
    if group.source == "formation":
        # Of one formation and of one thing that is steered.
        return f"formation {group.aspect}"
    return " ".join([group.source, *map(str, group.subject), group.aspect])


def known_subject(words: Vocabulary, subject: str) -> str:
    """Return a subject as a vocabulary has it, if another vocabulary of the game named it.

    There a thing may have had another of its looks as the most frequent one, or was several, and a
    byte may not have told a place.
    """
    source, *rest = subject.split() or [subject]
    if source == "memory" and len(rest) == 2:
        for group in words.groups:
            is_twin = group.twin is not None and rest[0] == str(group.subject[0])
            if is_twin and rest[1] in (group.aspect, "bits"):
                return subject_of(words, group)
        return subject
    if source != "thing":
        return subject
    return " ".join([source, *(known_look(words, word) for word in rest)])


def kinds_about(words: Vocabulary, subjects: Sequence[str]) -> tuple[int, ...]:
    """Return the kinds of things that subjects are about; for a relation, that of the other thing.

    Args:
        words: A vocabulary of the game.
        subjects: Subjects, in the terms of any vocabulary of the game.
    """
    kinds: list[int] = []
    for subject in subjects:
        named = known_subject(words, subject).split() or [subject]
        if named[0] == "pieces" and words.pieces is not None:
            kinds.append(PIECES)
        if named[0] == "formation" and words.scene.formation is not None:
            kinds.append(FORMATION)
        looks = [word for word in named if ":" in word]
        kinds += [i for i, kind in enumerate(words.kinds) if looks[-1:] == [look_key(kind)]]
    return tuple(dict.fromkeys(kinds))


@dataclass(frozen=True)
class Conditions:
    """Which statements answers leave possible.

    Attributes:
        subjects: What each group of the vocabulary is about.
        meant: Subjects that a statement has to be about.
        excluded: Sets of subjects that no statement is about, all of a set at once.
    """

    subjects: tuple[str, ...]
    meant: frozenset[str]
    excluded: tuple[frozenset[str], ...]

    @classmethod
    def of(cls, words: Vocabulary, answers: Sequence[Answer]) -> Conditions:
        """Return the conditions that answers set.

        Answers about what is not in the vocabulary are left out. A statement is about two subjects
        at most; of more that are meant, those of the latest answers count. What is meant is not
        excluded.

        Args:
            words: The vocabulary.
            answers: The answers, the latest last.
        """
        subjects = tuple(subject_of(words, group) for group in words.groups)
        renamed = [
            replace(answer, subjects=frozenset(known_subject(words, s) for s in answer.subjects))
            for answer in answers
        ]
        known = [answer for answer in renamed if answer.subjects <= set(subjects)]
        meant: frozenset[str] = frozenset()
        for answer in reversed(known):
            if answer.meant and len(meant | answer.subjects) <= MOST_SUBJECTS:
                meant |= answer.subjects
        excluded = tuple(
            answer.subjects for answer in known if not answer.meant and not answer.subjects <= meant
        )
        return cls(subjects, meant, excluded)

    def allow(self, groups: Sequence[int]) -> bool:
        """Return whether a statement about these groups is possible."""
        about = {self.subjects[group] for group in groups}
        return self.meant <= about and not any(one <= about for one in self.excluded)

    @property
    def groups(self) -> tuple[int, ...]:
        """Groups that are about what is meant."""
        return tuple(i for i, subject in enumerate(self.subjects) if subject in self.meant)

    def log_prior(self, words: Vocabulary) -> npt.NDArray[np.float64]:
        """Return the log of the prior probability of each group, float64 (n_groups,).

        What is meant is certain. What is excluded by itself is impossible.
        """
        log_p = words.log_prior.copy()
        subjects = np.array(self.subjects)
        for subject in self.meant:
            about = subjects == subject
            log_p[about] -= np.logaddexp.reduce(log_p[about])
        for subject in {s for one in self.excluded if len(one) == 1 for s in one}:
            log_p[subjects == subject] = -np.inf
        return log_p
