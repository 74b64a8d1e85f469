"""What people said of statements: kept as it was said, counted as it stands."""

from __future__ import annotations

from sqlalchemy import select

from testsupport.workplace import Workplace
from tril.store import answers, audit
from tril.store.models import StatementAnswerRow
from tril.store.training import runs

LEFT = ("thing 40:8-8x6-6 x",)
BOTH = ("button 0 held", "memory 28 bits")


def test_the_latest_answer_to_a_statement_counts_and_all_are_kept(workplace: Workplace) -> None:
    with workplace.database.writing() as session:
        answers.give(session, 1, LEFT, "further to the left", True)
        answers.give(session, 1, BOTH[::-1], "both", False)
        answers.give(session, 1, LEFT, "further to the left", False)
        answers.give(session, 2, LEFT, "of another behaviour", True)
    with workplace.database.reading() as session:
        standing = answers.current(session, 1)
        assert [(tuple(one.subjects), one.meant) for one in standing] == [
            (BOTH, False),
            (LEFT, False),
        ]
    with workplace.database.writing() as session:
        answers.give(session, 1, BOTH, "both", None)
    with workplace.database.reading() as session:
        assert [one.sentence for one in answers.current(session, 1)] == ["further to the left"]
        rows = session.scalars(select(StatementAnswerRow).order_by(StatementAnswerRow.id)).all()
        assert [row.meant for row in rows] == [True, False, False, True, None]
        assert audit.page(session)[0].action == audit.Action.ANSWERED


def test_a_run_keeps_the_answers_that_were_there_when_it_was_made(workplace: Workplace) -> None:
    with workplace.database.writing() as session:
        answers.give(session, workplace.behaviour_id, LEFT, "further to the left", True)
    run_id = workplace.make_run()
    with workplace.database.writing() as session:
        answers.give(session, workplace.behaviour_id, LEFT, "further to the left", None)
    with workplace.database.reading() as session:
        kept = runs.get(session, run_id).snapshot
    assert kept is not None
    assert [(one.subjects, one.meant) for one in kept.answers] == [(list(LEFT), True)]
