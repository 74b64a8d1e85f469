"""Names of things: kept as they were given, the latest counts."""

from __future__ import annotations

import pytest
from sqlalchemy import select

from testsupport.workplace import Workplace
from tril.store import audit, thing_names
from tril.store.models import ThingNameRow
from tril.text import TextRefused

BALL = "40:2-2x2-2"


def test_the_latest_name_of_a_thing_counts_and_all_are_kept(workplace: Workplace) -> None:
    with workplace.database.writing() as session:
        thing_names.give(session, "pong", BALL, "ball")
        thing_names.give(session, "pong", BALL, "  puck ")
        thing_names.give(session, "pong", BALL, "puck")
        thing_names.give(session, "pong", "pieces", "crumbs")
        thing_names.give(session, "pong", "pieces", "")
        thing_names.give(session, "freeway", BALL, "hen")
    with workplace.database.reading() as session:
        assert thing_names.current(session, "pong") == {
            BALL: "puck",
            "pieces": "",
        }
        assert thing_names.current(session, "freeway") == {BALL: "hen"}
        assert thing_names.current(session, "boxing") == {}
        rows = session.scalars(select(ThingNameRow.name).order_by(ThingNameRow.id)).all()
        # What was named so already is not named again.
        assert rows == ["ball", "puck", "crumbs", "", "hen"]
        noted = audit.page(session)[3]
        assert noted.action == audit.Action.RENAMED
        assert noted.details == {"game": "pong", "before": "ball", "after": "puck"}


def test_a_name_that_cannot_be_shown_is_refused(workplace: Workplace) -> None:
    with pytest.raises(TextRefused), workplace.database.writing() as session:
        thing_names.give(session, "pong", BALL, "a\u202eb")
