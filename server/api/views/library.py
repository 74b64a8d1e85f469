"""A library in brief, in columns: one list for each field."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from fastapi import Response
from pydantic_core import to_json
from sqlalchemy.orm import Session

from server.api.schemas.library import LibraryColumns
from tril.games import game_of
from tril.games.behaviours import Behaviour, score
from tril.store import behaviours, library, rankings
from tril.store.access.credentials import Identity
from tril.store.database import parse_json
from tril.store.models import BehaviourRow

_OF_GAMES = ("n_hits", "targets", "strays", "order_errors")


def library_response(
    session: Session,
    who: Identity,
    behaviour: BehaviourRow,
    brief: library.Brief,
    *,
    borrowed: bool = False,
) -> Response:
    """Show a library, or what of it changed, by a behaviour's target: a ``Library`` as JSON.

    It is written here, column by column, since FastAPI would do it in the event loop: 30 ms for
    20,000 recordings, in which no game goes on.

    Args:
        session: The transaction.
        who: Who reads it. A participant is told nothing of marks, ranking and parents.
        behaviour: The behaviour that it is shown for.
        brief: The library.
        borrowed: Whether it is what the behaviour has borrowed, which is never perfect there.
    """
    knows_all = not who.is_participant
    columns = _columns(behaviours.as_behaviour(behaviour), brief.entries)
    unknown = () if knows_all else ("run_id", "parent_id", "parent_frame")
    n_entries = len(brief.entries)
    columns |= dict.fromkeys(unknown, [None] * n_entries)
    if not borrowed:
        columns["behaviour_name"] = [None] * n_entries
    if borrowed or not knows_all:
        columns["perfect"] = [False] * n_entries
    ranking = rankings.as_ranking(rankings.current(session, behaviour.id))
    content = _object(
        {
            "cursor": to_json(brief.cursor),
            "whole": to_json(brief.whole),
            "removed": to_json(brief.removed),
            "ranked": to_json(list(ranking.items) if knows_all else []),
            "recordings": _object(
                {name: to_json(columns[name]) for name in LibraryColumns.model_fields}
            ),
        }
    )
    return Response(content, media_type="application/json")


def _columns(behaviour: Behaviour, entries: Sequence[library.Entry]) -> dict[str, Any]:
    """Return the lists of all fields."""
    game = game_of(behaviour)
    columns: dict[str, Any] = _transposed(library.COLUMNS, entries)
    columns["n_steps"] = [game.clock.n_steps(n_frames) for n_frames in columns["n_frames"]]
    of_games = [_of_game(behaviour, taken) for taken in columns["taken"]]
    columns |= _transposed(_OF_GAMES, of_games)
    counters = _parsed(columns["counters"])
    columns["counters"] = {name: [one.get(name, 0) for one in counters] for name in game.counters}
    measured = _parsed(columns["measured"]) if behaviour.measures else []
    columns["measured"] = [
        [one.get(measure.key) for one in measured] for measure in behaviour.measures
    ]
    return columns


def _transposed(names: Sequence[str], rows: Sequence[Sequence[Any]]) -> dict[str, Sequence[Any]]:
    """Return the columns of rows by their names; empty ones if there are no rows."""
    if not rows:
        return dict.fromkeys(names, ())
    return dict(zip(names, zip(*rows, strict=True), strict=True))


def _of_game(behaviour: Behaviour, taken: str) -> tuple[int, int | None, int | None, int | None]:
    """Return the number of hits, and of targets, strays and errors of order."""
    cells = tuple((row, column) for row, column, _ in parse_json(taken))
    found = score(behaviour, cells)
    if found is None:
        return len(cells), None, None, None
    return len(cells), found.targets, found.strays, found.order_errors


def _parsed(column: Sequence[str]) -> list[Mapping[str, Any]]:
    """Parse a column of JSON in which most values occur often."""
    known = {text: parse_json(text) for text in set(column)}
    return [known[text] for text in column]


def _object(members: Mapping[str, bytes]) -> bytes:
    """Write a JSON object of members that are JSON already."""
    return b"{" + b",".join(to_json(key) + b":" + value for key, value in members.items()) + b"}"
