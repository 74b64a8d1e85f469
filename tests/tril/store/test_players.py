"""Whom imported games belong to."""

from __future__ import annotations

from testsupport.workplace import Workplace
from tril.store import players
from tril.store.access import credentials
from tril.store.models import Role


def test_imported_games_of_one_name_belong_to_one_person(workplace: Workplace) -> None:
    with workplace.database.writing() as session:
        first = players.named(session, "Ada")
        assert players.named(session, "Ada").id == first.id


def test_somebody_who_has_signed_in_is_not_given_a_namesakes_games(workplace: Workplace) -> None:
    with workplace.database.writing() as session:
        present = players.add(session, "Ada", Role.PARTICIPANT)
        credentials.sign_in(session, present.id, "Firefox on Linux", None)
        assert players.named(session, "Ada").id != present.id


def test_the_owner_gets_their_own_games_back(workplace: Workplace) -> None:
    with workplace.database.writing() as session:
        owner = players.owner(session)
        credentials.sign_in(session, owner.id, "Firefox on Linux", None)
        assert players.named(session, owner.name).id == owner.id
