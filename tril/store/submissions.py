"""What is submitted twice is done once: each submission has a key, made by whoever submits it.

The row of a key is committed with the changes that the submission made, so that neither is there
without the other, whichever process handles the second one. The header and the refusal of a key
with another request follow draft-ietf-httpapi-idempotency-key-header-07. Unlike there, a submission
that changed nothing may be sent again with its key.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from datetime import timedelta
from hashlib import sha256
from typing import Any

from sqlalchemy import delete, event, select
from sqlalchemy.orm import Session

from tril.errors import Invalid
from tril.store.database import Database, database_now
from tril.store.models import SubmissionRow

LIFETIME = timedelta(hours=24)
"""How long a key is kept."""
MAX_PER_PLAYER = 1_000
"""Most keys of a person; the oldest make room."""
MAX_RESPONSE_BYTES = 128 * 1024
"""A longer response is not kept."""


class SubmittedBefore(Exception):
    """The submission was done already; ``submission_id`` names its row."""

    def __init__(self, submission_id: int) -> None:
        """Name the row of the first one."""
        super().__init__(f"Submission {submission_id} was done already.")
        self.submission_id = submission_id


@dataclass
class Submission:
    """A request that carries a key; guards the transactions that handle it.

    Attributes:
        player_id: Player that submits; keys are per player.
        key: The key.
        content: Digest of what is submitted, complete once the request has been read.
        row_id: Its row, once its changes are committed.
    """

    player_id: int
    key: str
    content: Any = field(default_factory=sha256)
    row_id: int | None = None

    def check(self, session: Session) -> None:
        """Refuse what was done already; called first in each transaction that writes.

        Raises:
            SubmittedBefore: It was done already.
            Invalid: The key was used for something else.
        """
        if self.row_id is not None:
            return
        event.listen(session, "after_flush", _note_flush)
        row = session.scalar(
            select(SubmissionRow).where(
                SubmissionRow.player_id == self.player_id,
                SubmissionRow.key == self.key,
                SubmissionRow.created_at >= database_now(session) - LIFETIME,
            )
        )
        if row is None:
            return
        if row.content != self.content.hexdigest():
            raise Invalid(
                "The Idempotency-Key was used for another request. Send each with a key of its own."
            )
        raise SubmittedBefore(row.id)

    def note(self, session: Session) -> None:
        """Add the key's row to a transaction that changed something; called last in it."""
        session.flush()
        if self.row_id is not None or not session.info.get(_FLUSHED, False):
            return
        moment = database_now(session)
        session.execute(delete(SubmissionRow).where(SubmissionRow.created_at < moment - LIFETIME))
        oldest = session.scalar(
            select(SubmissionRow.id)
            .where(SubmissionRow.player_id == self.player_id)
            .order_by(SubmissionRow.id.desc())
            .offset(MAX_PER_PLAYER - 1)
            .limit(1)
        )
        if oldest is not None:
            is_own = SubmissionRow.player_id == self.player_id
            session.execute(delete(SubmissionRow).where(is_own, SubmissionRow.id <= oldest))
        row = SubmissionRow(
            player_id=self.player_id,
            key=self.key,
            content=self.content.hexdigest(),
            created_at=moment,
        )
        session.add(row)
        session.flush()
        row_id = row.id
        event.listen(session, "after_commit", lambda _: self._committed(row_id), once=True)

    def _committed(self, row_id: int) -> None:
        self.row_id = row_id


def keep_response(
    database: Database, submission_id: int, status: int, response: bytes | None
) -> None:
    """Keep the response to a submission for those that repeat it; None keeps only its status."""
    if response is not None and len(response) > MAX_RESPONSE_BYTES:
        response = None
    with database.writing() as session:
        row = session.get(SubmissionRow, submission_id)
        if row is not None:
            row.status, row.response = status, response


def find(database: Database, submission_id: int) -> SubmissionRow | None:
    """Return the row of a submission; None if it is no longer kept."""
    with database.reading() as session:
        return session.get(SubmissionRow, submission_id)


_FLUSHED = "tril_flushed"


def _note_flush(session: Session, _context: Any) -> None:
    session.info[_FLUSHED] = True
