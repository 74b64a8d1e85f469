"""Names that people give to the things of a game, which all behaviours of the game share."""

from __future__ import annotations

from sqlalchemy import select
from sqlalchemy.orm import Session

from tril.store import audit
from tril.store.models import ThingNameRow
from tril.text import clean_line


def current(session: Session, game: str) -> dict[str, str]:
    """Return the names of a game's things by their keys, the latest last.

    See tril.vocabulary.names.thing_key. A name that was removed is empty.
    """
    query = select(ThingNameRow).where(ThingNameRow.game == game).order_by(ThingNameRow.id)
    names: dict[str, str] = {}
    for row in session.scalars(query):
        names.pop(row.thing, None)
        names[row.thing] = row.name
    return names


def give(session: Session, game: str, thing: str, name: str, player_id: int | None = None) -> None:
    """Name a thing; rows are only ever added.

    Args:
        session: The transaction.
        game: Name of the game.
        thing: Key of the thing.
        name: The name; an empty one removes it.
        player_id: Player that names it.

    Raises:
        TextRefused: The name can't be accepted.
    """
    name = clean_line(name)
    before = current(session, game).get(thing)
    if name == before:
        return
    session.add(ThingNameRow(game=game, thing=thing, name=name, player_id=player_id))
    session.flush()
    names = {"before": before or "", "after": name}
    audit.note(session, audit.Action.RENAMED, player_id, f"thing {thing}", game=game, **names)
