"""The rankings, with every revision in the order in which it was made.

Revision 0 is the empty ranking that every behaviour begins with; it has no row. ``undo_to`` names
the revision whose tiers an undo brings back, ``redo_to`` the revision that was undone. Undo and
redo write new revisions.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from datetime import datetime

from sqlalchemy import Select, and_, or_, select, union
from sqlalchemy.orm import Session

from tril.errors import Conflict, Invalid
from tril.ranking import Ranking, normalise
from tril.store import audit
from tril.store.changes import note_change
from tril.store.models import (
    BehaviourRow,
    BorrowedGameRow,
    RankingRow,
    RecordingRow,
    RecordingState,
    Verification,
)

Tiers = Sequence[Sequence[int]]

_MAX_DELETIONS = 100
"""The latest deletions that tell where a restored recording was ranked."""

PART = 10_000
"""Most ids that one statement names: PostgreSQL's driver takes 65,535 parameters."""

RANKABLE = (
    RecordingRow.state == RecordingState.KEPT,
    RecordingRow.verification == Verification.VERIFIED,
    RecordingRow.deleted_at.is_(None),
)
"""What holds of every recording that can be ranked, of the behaviour's library or borrowed."""


class RankingConflict(Conflict):
    """Another order was saved first.

    Attributes:
        behaviour_id: The behaviour whose ranking it is.
        yours: The tiers that were not saved; None for an undo or redo.
    """

    def __init__(self, behaviour_id: int, yours: Tiers | None) -> None:
        super().__init__(
            "The ranking was changed elsewhere in the meantime, and yours was not saved. Look at "
            "both orders, then save yours again or go on with the other one."
        )
        self.behaviour_id = behaviour_id
        self.yours = yours


def current(session: Session, behaviour_id: int) -> RankingRow:
    """Return the newest revision; if there is none, revision 0, which is not stored."""
    row = session.scalar(
        select(RankingRow)
        .where(RankingRow.behaviour_id == behaviour_id)
        .order_by(RankingRow.revision.desc())
        .limit(1)
    )
    return row or _empty(behaviour_id)


def history(session: Session, behaviour_id: int) -> list[RankingRow]:
    """Return every revision, oldest first."""
    query = select(RankingRow).where(RankingRow.behaviour_id == behaviour_id)
    return list(session.scalars(query.order_by(RankingRow.revision)))


def restore_history(session: Session, behaviour_id: int, rows: Sequence[RankingRow]) -> None:
    """Add the revisions, oldest first, of a behaviour that has none yet.

    Raises:
        Conflict: The behaviour has revisions already.
        Invalid: The newest of them ranks a recording that can't be ranked.
    """
    if current(session, behaviour_id).revision:
        raise Conflict("The behaviour has a ranking already, which would be overwritten.")
    if not rows:
        return
    refuse_unrankable(session, behaviour_id, as_ranking(rows[-1]))
    session.add_all(rows)
    session.flush()
    note_change(session, "ranking", behaviour_id)


def as_ranking(row: RankingRow) -> Ranking:
    """Return the ranking that a revision holds."""
    return normalise(row.tiers)


def unranked(session: Session, row: RankingRow) -> list[int]:
    """Return the rankable recordings that are in no tier, newest first."""
    return sorted(_rankable(session, row.behaviour_id) - set(as_ranking(row).items), reverse=True)


def save(
    session: Session,
    behaviour_id: int,
    base_revision: int,
    tiers: Tiers,
    player_id: int | None = None,
    change: str = "edit",
) -> RankingRow:
    """Save an order as a new revision, unless it equals the newest one's.

    Args:
        session: The transaction.
        behaviour_id: Behaviour of the ranking.
        base_revision: The revision that was changed into this order.
        tiers: Recordings, best tier first.
        player_id: Player that saves the ranking.
        change: "edit", "import" or "example".

    Raises:
        RankingConflict: ``base_revision`` is not the newest any more.
        Invalid: A recording is named twice, is deleted, neither of the behaviour's library nor
            borrowed, not kept or not verified; all such recordings are named.
    """
    newest = lock(session, behaviour_id, base_revision, tiers)
    ranking = normalise(tiers)
    refuse_unrankable(session, behaviour_id, ranking)
    if ranking == as_ranking(newest):
        return newest
    return _add(session, newest, ranking, player_id, change, undo_to=newest.revision)


def undo(
    session: Session, behaviour_id: int, base_revision: int, player_id: int | None = None
) -> RankingRow:
    """Bring back the order before the last change.

    Raises:
        RankingConflict: ``base_revision`` is not the newest any more.
        Invalid: There is nothing to undo.
    """
    newest = lock(session, behaviour_id, base_revision)
    earlier = _revision(session, newest, newest.undo_to, "undo")
    links = {"undo_to": earlier.undo_to, "redo_to": newest.revision}
    return _add(session, newest, _rankable_part(session, earlier), player_id, "undo", **links)


def redo(
    session: Session, behaviour_id: int, base_revision: int, player_id: int | None = None
) -> RankingRow:
    """Bring back the order that was undone last.

    Raises:
        RankingConflict: ``base_revision`` is not the newest any more.
        Invalid: There is nothing to redo.
    """
    newest = lock(session, behaviour_id, base_revision)
    undone = _revision(session, newest, newest.redo_to, "redo")
    links = {"undo_to": undone.undo_to, "redo_to": undone.redo_to}
    return _add(session, newest, _rankable_part(session, undone), player_id, "redo", **links)


def remove_recordings(
    session: Session, recording_ids: Collection[int], player_id: int | None = None
) -> None:
    """Save a revision without deleted recordings of each ranking that holds any of them.

    Undo and redo pass over it: a deletion is undone by restoring the recordings.
    """
    for behaviour_id in _ranking_behaviour_ids(session, recording_ids):
        newest = lock(session, behaviour_id)
        ranking = as_ranking(newest)
        if set(ranking.items).isdisjoint(recording_ids):
            continue
        _add(
            session,
            newest,
            ranking.without(set(recording_ids)),
            player_id,
            "deletion",
            undo_to=newest.undo_to,
            redo_to=newest.redo_to,
        )


def restore_recordings(
    session: Session, deleted_at: Mapping[int, datetime], player_id: int | None = None
) -> None:
    """Put restored recordings back into the rankings that lost them, as a revision of each.

    They return to their former tiers, see Ranking.with_restored. Undo and redo skip this revision
    and the deletion, unless the order was changed in between: then an undo takes them out again.

    Args:
        session: The transaction.
        deleted_at: When each of the recordings was deleted, by id.
        player_id: Player that restores the recordings.
    """
    for behaviour_id in _ranking_behaviour_ids(session, deleted_at):
        newest = lock(session, behaviour_id)
        rankable = _rankable(session, behaviour_id, deleted_at)
        ranking = as_ranking(newest)
        for recording_id, former in _former_rankings(session, newest, deleted_at):
            if recording_id in rankable and recording_id not in ranking.items:
                ranking = ranking.with_restored(recording_id, former)
        if ranking == as_ranking(newest):
            continue
        # Restoring one by one, each passes over the one before, too.
        passes_over = newest.change in {"deletion", "undo"}
        _add(
            session,
            newest,
            ranking,
            player_id,
            "undo",
            undo_to=newest.undo_to if passes_over else newest.revision,
            redo_to=newest.redo_to if passes_over else None,
        )


def _former_rankings(
    session: Session, newest: RankingRow, deleted_at: Mapping[int, datetime]
) -> list[tuple[int, Ranking]]:
    """Return deleted recordings with the ranking that their deletion took them out of.

    What was deleted before is put back into these rankings, so that neighbours that were deleted
    one after the other find each other again. What was deleted last comes first.
    """
    latest = (
        select(RankingRow)
        .where(RankingRow.behaviour_id == newest.behaviour_id, RankingRow.change == "deletion")
        .order_by(RankingRow.revision.desc())
        .limit(_MAX_DELETIONS)
    )
    former_rankings: list[tuple[int, Ranking]] = []
    former_of: dict[int, Ranking] = {}
    for row in reversed(session.scalars(latest).all()) if deleted_at else ():
        former = as_ranking(_revision(session, newest, row.revision - 1, "put back"))
        taken_out = set(former.items) - set(as_ranking(row).items)
        for item, earlier in former_of.items():
            if item not in former.items:
                former = former.with_restored(item, earlier)
        for item in former.items:
            if item in taken_out:
                former_of[item] = former
                # An earlier deletion doesn't tell whether it was ranked at its last one.
                if item in deleted_at and row.created_at >= deleted_at[item]:
                    former_rankings.append((item, former))
    return former_rankings[::-1]


def _ranking_behaviour_ids(session: Session, recording_ids: Collection[int]) -> list[int]:
    """Return the behaviours that own or have borrowed recordings, in locking order."""
    behaviour_ids: set[int] = set()
    for part in chunks(sorted(recording_ids), PART):
        owners = select(RecordingRow.behaviour_id).where(RecordingRow.id.in_(part))
        borrowers = select(BorrowedGameRow.behaviour_id).where(
            BorrowedGameRow.recording_id.in_(part)
        )
        behaviour_ids.update(session.scalars(union(owners, borrowers)))
    return sorted(behaviour_ids)


def chunks(ids: Sequence[int], size: int) -> Iterator[Sequence[int]]:
    """Yield ids in chunks of at most ``size``."""
    for start in range(0, len(ids), size):
        yield ids[start : start + size]


def lock(
    session: Session,
    behaviour_id: int,
    base_revision: int | None = None,
    yours: Tiers | None = None,
) -> RankingRow:
    """Lock the ranking until the transaction ends; return its newest revision.

    Raises:
        RankingConflict: ``base_revision`` is given and not the newest any more.
    """
    session.execute(
        select(BehaviourRow.id).where(BehaviourRow.id == behaviour_id).with_for_update()
    )
    newest = current(session, behaviour_id)
    if base_revision is not None and newest.revision != base_revision:
        raise RankingConflict(behaviour_id, yours)
    return newest


def _revision(session: Session, newest: RankingRow, revision: int | None, step: str) -> RankingRow:
    if revision is None:
        raise Invalid(f"There is nothing to {step}.")
    if revision == 0:
        return _empty(newest.behaviour_id)
    return session.scalars(
        select(RankingRow).where(
            RankingRow.behaviour_id == newest.behaviour_id, RankingRow.revision == revision
        )
    ).one()


def _empty(behaviour_id: int) -> RankingRow:
    return RankingRow(behaviour_id=behaviour_id, revision=0, tiers=[], change="edit")


def _add(
    session: Session,
    newest: RankingRow,
    ranking: Ranking,
    player_id: int | None,
    change: str,
    *,
    undo_to: int | None,
    redo_to: int | None = None,
) -> RankingRow:
    row = RankingRow(
        behaviour_id=newest.behaviour_id,
        player_id=player_id,
        revision=newest.revision + 1,
        tiers=[list(tier) for tier in ranking.tiers],
        change=change,
        undo_to=undo_to,
        redo_to=redo_to,
    )
    session.add(row)
    session.flush()
    audit.note(
        session,
        audit.Action.RANKED,
        player_id,
        f"behaviour {row.behaviour_id}",
        revision=row.revision,
        change=change,
    )
    note_change(session, "ranking", row.behaviour_id)
    return row


def _rankable(
    session: Session, behaviour_id: int, among: Collection[int] | None = None
) -> set[int]:
    """Return the recordings that a behaviour's ranking may hold, of all or of some."""
    is_own = and_(RecordingRow.behaviour_id == behaviour_id, RecordingRow.run_id.is_(None))
    is_borrowed = RecordingRow.id.in_(borrowed_ids(behaviour_id))
    query = select(RecordingRow.id).where(or_(is_own, is_borrowed), *RANKABLE)
    if among is None:
        return set(session.scalars(query))
    parts = chunks(sorted(among), PART)
    return {
        key for part in parts for key in session.scalars(query.where(RecordingRow.id.in_(part)))
    }


def borrowed_ids(behaviour_id: int) -> Select[int]:
    """Return the query of the recordings that a behaviour has borrowed, deleted ones too."""
    return select(BorrowedGameRow.recording_id).where(BorrowedGameRow.behaviour_id == behaviour_id)


def without_unrankable(session: Session, behaviour_id: int, ranking: Ranking) -> Ranking:
    """Return a ranking without what a behaviour's ranking may not hold."""
    return ranking.without(set(ranking.items) - _rankable(session, behaviour_id, ranking.items))


def _rankable_part(session: Session, row: RankingRow) -> Ranking:
    return without_unrankable(session, row.behaviour_id, as_ranking(row))


def refuse_unrankable(session: Session, behaviour_id: int, ranking: Ranking) -> None:
    """Raise Invalid, naming the recordings, if any of a ranking's can't be ranked."""
    wrong = sorted(set(ranking.items) - _rankable(session, behaviour_id, ranking.items))
    if not wrong:
        return
    query = select(RecordingRow).where(RecordingRow.id.in_(wrong))
    rows = {row.id: row for row in session.scalars(query)}
    reasons = (
        f"{named(session, behaviour_id, rows[key])} {_refusal(rows[key])}"
        if key in rows
        else f"a recording with the id {key} does not exist"
        for key in wrong
    )
    raise Invalid(f"This order can't be used: {', '.join(reasons)}. Take it out of the ranking.")


def ranking_refusal(row: RecordingRow) -> str | None:
    """Say what of RANKABLE doesn't hold of a recording: "is not verified"; None if all does."""
    if row.deleted_at is not None:
        return "has been deleted"
    if row.state != RecordingState.KEPT:
        return "is not kept in the library"
    if row.verification != Verification.VERIFIED:
        return "is not verified"
    return None


def named(session: Session, behaviour_id: int, row: RecordingRow) -> str:
    """Return how a sentence names a recording: "recording 3", with its origin if it has another."""
    name = f"{row.title[0].lower()}{row.title[1:]}"
    if row.run_id is not None:
        return f"{name} of run {row.run_id[:6]}"
    if row.behaviour_id != behaviour_id:
        return f"{name} of {session.get_one(BehaviourRow, row.behaviour_id).name}"
    return name


def _refusal(row: RecordingRow) -> str:
    if row.run_id is not None:
        return ranking_refusal(row) or "belongs to a training and is not borrowed"
    return ranking_refusal(row) or "is of another behaviour and not borrowed"
