"""What people said of the statements that Tril makes about a behaviour's ranking."""

from __future__ import annotations

from collections.abc import Sequence

from sqlalchemy import select
from sqlalchemy.orm import Session

from tril.analysis.outcome import StatementAnswer
from tril.store import audit
from tril.store.changes import note_change
from tril.store.models import StatementAnswerRow


def current(session: Session, behaviour_id: int) -> list[StatementAnswer]:
    """Return the valid answers of a behaviour, as ``current_rows`` does."""
    return [
        StatementAnswer(subjects=row.subjects, sentence=row.sentence, meant=bool(row.meant))
        for row in current_rows(session, behaviour_id)
    ]


def current_rows(session: Session, behaviour_id: int) -> list[StatementAnswerRow]:
    """Return the valid answers of a behaviour, the latest last.

    Of each statement that is the latest answer, unless it was taken back.
    """
    query = select(StatementAnswerRow).where(StatementAnswerRow.behaviour_id == behaviour_id)
    latest: dict[tuple[str, ...], StatementAnswerRow] = {}
    for row in session.scalars(query.order_by(StatementAnswerRow.id)):
        key = tuple(row.subjects)
        latest.pop(key, None)
        latest[key] = row
    return [row for row in latest.values() if row.meant is not None]


def give(
    session: Session,
    behaviour_id: int,
    subjects: Sequence[str],
    sentence: str,
    meant: bool | None,
    player_id: int | None = None,
) -> None:
    """Keep what a person says of a statement.

    Args:
        session: The transaction.
        behaviour_id: Behaviour of the ranking.
        subjects: Subjects of the statement, see tril.vocabulary.answers.
        sentence: Sentence shown to the person.
        meant: Whether it is what they mean; None takes back what was said of it before.
        player_id: Player that answers.
    """
    session.add(
        StatementAnswerRow(
            behaviour_id=behaviour_id,
            player_id=player_id,
            subjects=sorted(set(subjects)),
            sentence=sentence,
            meant=meant,
        )
    )
    session.flush()
    audit.note(
        session,
        audit.Action.ANSWERED,
        player_id,
        f"behaviour {behaviour_id}",
        sentence=sentence,
        meant=meant,
    )
    note_change(session, "ranking", behaviour_id)
