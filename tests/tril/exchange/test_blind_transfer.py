"""Blind comparisons in a run's file: of namesakes, and of more answers than fit."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from testsupport.finished_runs import make_finished_run
from testsupport.workplace import Workplace
from tril.analysis.blind import BlindAnswer
from tril.exchange import blind_transfer
from tril.exchange.blind_transfer import add_blind_answers, blind_objects
from tril.store import players
from tril.store.models import BlindAnswerRow, Role
from tril.store.training import blind_answers


@pytest.fixture
def run_id(workplace: Workplace) -> str:
    return make_finished_run(workplace)


def judge(workplace: Workplace, run_id: str, player_id: int, *answers: BlindAnswer) -> None:
    """Judge the first pair of the round that a person is in, again and again, and end it."""
    with workplace.database.writing() as session:
        rounds = blind_answers.rounds_of(session, run_id)
        _, current = blind_answers.own_rounds(rounds, player_id)
        for given in (*answers, BlindAnswer.ENDED):
            blind_answers.answer(session, run_id, player_id, current.number, 1, given)


def test_what_a_namesake_judged_is_not_the_owners_and_namesakes_stay_apart(
    workplace: Workplace, run_id: str
) -> None:
    with workplace.database.writing() as session:
        owner = players.owner(session)
        namesake = players.add(session, owner.name, Role.PARTICIPANT).id
        owner_id, name = owner.id, owner.name
    judge(workplace, run_id, owner_id, BlindAnswer.LEFT)
    judge(workplace, run_id, namesake, BlindAnswer.RIGHT)
    with workplace.database.writing() as session:
        exported = blind_objects(session, run_id)["blind"]
        assert {one.player for one in exported} == {name, f"{name} (2)"}
        result = blind_answers.result_of(session, run_id)
        rows = blind_answers.rows_of(session, run_id)
        ids = {key: key for row in rows for key in (row.imitator_id, row.other_id)}
        session.query(BlindAnswerRow).delete()
        imported = SimpleNamespace(id=run_id, blind=exported)
        add_blind_answers(session, imported, ids)  # type: ignore[arg-type]
        rounds = blind_answers.rounds_of(session, run_id)
        assert len(rounds) == 2
        assert owner_id not in {one.player_id for one in rounds}
        assert blind_answers.result_of(session, run_id) == result


def test_of_more_answers_than_fit_those_are_kept_from_which_the_result_follows(
    workplace: Workplace, run_id: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    with workplace.database.writing() as session:
        owner = players.owner(session).id
    left, right, back = BlindAnswer.LEFT, BlindAnswer.RIGHT, BlindAnswer.TAKEN_BACK
    for _ in range(3):
        judge(workplace, run_id, owner, left, back, right, back, left, back, right)
    with workplace.database.reading() as session:
        assert len(blind_objects(session, run_id)["blind"]) == 24
        monkeypatch.setattr(blind_transfer, "MAX_BLIND_ANSWERS", 5)
        kept = blind_objects(session, run_id)["blind"]
    assert [(one.round, one.answer) for one in kept] == [
        (2, right),
        (2, BlindAnswer.ENDED),
        (3, right),
        (3, BlindAnswer.ENDED),
    ]
