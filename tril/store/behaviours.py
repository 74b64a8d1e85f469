"""The behaviours that are taught."""

from __future__ import annotations

import re
import unicodedata
from collections import defaultdict
from collections.abc import Collection
from dataclasses import dataclass, replace

from sqlalchemy import func, select
from sqlalchemy.orm import Session

from tril.errors import Conflict, NameTaken, NotFound
from tril.games import DEFAULT_GAME, game_of, published
from tril.games.base import Cell
from tril.games.behaviours import Behaviour
from tril.games.measures import Measure, measures_from_json
from tril.games.measuring import check_measures
from tril.games.settings import UNSET, GameSettings
from tril.store import audit
from tril.store.changes import note_change
from tril.store.models import (
    NOT_OVER,
    BehaviourRow,
    RankingRow,
    RecordingRow,
    RecordingState,
    RunRow,
    Source,
    Verification,
    now,
)
from tril.text import clean_line, folded, shown_line

MAX_BEHAVIOURS = 500
"""Most behaviours that can exist at the same time."""

MAX_STORED = 5_000
"""Most behaviours that are stored, deleted ones included."""

MAX_NAME_LENGTH = 120


@dataclass(frozen=True)
class Counts:
    """How much of a behaviour is stored.

    Attributes:
        n_recordings: Recordings in the library that can be ranked.
        n_ranked: Recordings in the ranking, borrowed ones included.
        n_perfect: Recordings in the library that are marked as perfect.
        n_runs: Trainings.
        has_example: Whether scripted demonstrations are in the library.
    """

    n_recordings: int = 0
    n_ranked: int = 0
    n_perfect: int = 0
    n_runs: int = 0
    has_example: bool = False


def as_behaviour(row: BehaviourRow) -> Behaviour:
    """Return the behaviour that a row holds."""
    target = None if row.target is None else tuple((r, c) for r, c in row.target)
    return Behaviour(
        slug=row.slug,
        name=row.name,
        description=row.description,
        game=row.game,
        target=target,
        ordered=row.ordered,
        settings=GameSettings.from_json(row.settings or {}),
        measures=measures_from_json(row.measures or []),
    )


def get(session: Session, behaviour_id: int) -> BehaviourRow:
    """Return a behaviour; raises NotFound if there is none or it was deleted."""
    row = session.get(BehaviourRow, behaviour_id)
    if row is None or row.deleted_at is not None:
        raise NotFound(f"There is no behaviour {behaviour_id} (any more).")
    return row


def n_targets(session: Session, behaviour_id: int) -> int | None:
    """Return the number of a behaviour's target cells, deleted or not; None without any."""
    row = session.get_one(BehaviourRow, behaviour_id)
    return None if row.target is None else len(row.target)


def by_slug(session: Session, slug: str) -> BehaviourRow:
    """Return a behaviour by its short name; raises NotFound naming those there are."""
    row = session.scalar(
        select(BehaviourRow).where(BehaviourRow.slug == slug, BehaviourRow.deleted_at.is_(None))
    )
    if row is None:
        slugs = ", ".join(row.slug for row in listing(session))
        raise NotFound(f"There is no behaviour {slug!r}; there are {slugs}.")
    return row


def listing(
    session: Session,
    *,
    ids: Collection[int] | None = None,
    after: int | None = None,
    limit: int | None = None,
) -> list[BehaviourRow]:
    """Return the behaviours, built-in ones first, then by age.

    Args:
        session: The transaction.
        ids: Only these.
        after: Only those that follow this one in the list, even if it was deleted since.
        limit: Most behaviours that are returned.

    Raises:
        NotFound: There has never been the behaviour of ``after``.
    """
    query = select(BehaviourRow).where(BehaviourRow.deleted_at.is_(None))
    if ids is not None:
        query = query.where(BehaviourRow.id.in_(ids))
    if after is not None:
        last = session.get(BehaviourRow, after)
        if last is None:
            raise NotFound("There is no such behaviour.")
        follows = (BehaviourRow.built_in == last.built_in) & (BehaviourRow.id > last.id)
        query = query.where(follows | ~BehaviourRow.built_in if last.built_in else follows)
    order = (BehaviourRow.built_in.desc(), BehaviourRow.id)
    return list(session.scalars(query.order_by(*order).limit(limit)))


def counts(session: Session, behaviour_id: int | None = None) -> dict[int, Counts]:
    """Return the counts of each behaviour, or of one; those with nothing are left out."""
    counts_by_id: dict[int, Counts] = defaultdict(Counts)
    in_library = select(
        RecordingRow.behaviour_id,
        func.count(),
        func.count().filter(RecordingRow.perfect),
        func.count().filter(RecordingRow.source == Source.SCRIPTED),
    ).where(
        RecordingRow.deleted_at.is_(None),
        RecordingRow.state == RecordingState.KEPT,
        RecordingRow.verification == Verification.VERIFIED,
        RecordingRow.run_id.is_(None),
    )
    trained = select(RunRow.behaviour_id, func.count()).where(RunRow.deleted_at.is_(None))
    newest = (
        select(RankingRow.behaviour_id, func.max(RankingRow.revision).label("revision"))
        .group_by(RankingRow.behaviour_id)
        .subquery()
    )
    ranked = select(RankingRow.behaviour_id, RankingRow.tiers).join(
        newest,
        (RankingRow.behaviour_id == newest.c.behaviour_id)
        & (RankingRow.revision == newest.c.revision),
    )
    if behaviour_id is not None:
        in_library = in_library.where(RecordingRow.behaviour_id == behaviour_id)
        trained = trained.where(RunRow.behaviour_id == behaviour_id)
        ranked = ranked.where(RankingRow.behaviour_id == behaviour_id)
    in_library = in_library.group_by(RecordingRow.behaviour_id)
    for key, n, perfect, scripted in session.execute(in_library):
        counts_by_id[key] = Counts(n, n_perfect=perfect, has_example=scripted > 0)
    for key, n in session.execute(trained.group_by(RunRow.behaviour_id)):
        counts_by_id[key] = replace(counts_by_id[key], n_runs=n)
    for key, tiers in session.execute(ranked):
        counts_by_id[key] = replace(counts_by_id[key], n_ranked=sum(len(tier) for tier in tiers))
    return counts_by_id


def create(
    session: Session,
    name: str,
    description: str = "",
    target: tuple[Cell, ...] | None = None,
    ordered: bool = False,
    game: str = DEFAULT_GAME,
    settings: GameSettings = UNSET,
    measures: tuple[Measure, ...] = (),
) -> BehaviourRow:
    """Add a person's own behaviour.

    Raises:
        UnknownGame: There is no such game.
        Invalid: The name is empty, or the target, a setting or a measure is not valid.
        TextRefused: The name or the description can't be accepted.
        NameTaken: There is one of this name.
        Conflict: There are MAX_BEHAVIOURS already, or MAX_STORED with those that were deleted.
    """
    _refuse_too_many(session)
    n_stored = session.scalar(select(func.count()).select_from(BehaviourRow)) or 0
    if n_stored >= MAX_STORED:
        raise Conflict(
            f"{n_stored} behaviours are stored, deleted ones included, and no more can be."
        )
    name = clean_line(name, MAX_NAME_LENGTH)
    slug = _free_slug(session, name)
    behaviour = Behaviour(slug, name, description, game, target, ordered, settings, measures)
    _check(behaviour)
    _refuse_taken_name(session, behaviour.name)
    return _add(session, behaviour, built_in=False)


def update(
    session: Session,
    row: BehaviourRow,
    name: str,
    description: str,
    target: tuple[Cell, ...] | None,
    ordered: bool,
    player_id: int | None = None,
    settings: GameSettings | None = None,
    measures: tuple[Measure, ...] | None = None,
) -> None:
    """Change a behaviour, as somebody or, without ``player_id``, as a command in the terminal.

    Measures can always change: nothing was learned from them.

    Raises:
        Invalid: The name is empty, or the target, a setting or a measure is not valid.
        NameTaken: Another behaviour has this name.
        Conflict: The target or a setting would change although the behaviour is built-in or has
            recordings or runs, which were ranked and judged by it. What is hidden from learning can
            change until there are runs.
    """
    before = as_behaviour(row)
    settings = before.settings if settings is None else settings
    name = clean_line(name)
    measures = before.measures if measures is None else measures
    changed = Behaviour(row.slug, name, description, row.game, target, ordered, settings, measures)
    _check(changed)
    if settings != before.settings:
        _refuse_other_settings(session, row, settings, before.settings)
    if changed.name != before.name:
        _refuse_taken_name(session, changed.name, besides=row.id)
    if (changed.target, changed.ordered) != (before.target, before.ordered):
        if row.built_in:
            raise Conflict(
                "The target of a built-in behaviour can't be changed. Make a copy with another "
                "target instead."
            )
        if _in_use(session, row.id):
            raise Conflict(
                "The target can't be changed any more: games were ranked and runs judged by it. "
                "Make a copy with another target instead."
            )
    subject = f"behaviour {row.id}"
    if changed.name != before.name:
        names = {"before": before.name, "after": changed.name}
        audit.note(session, audit.Action.RENAMED, player_id, subject, **names)
    if replace(changed, name=before.name) != before:
        audit.note(session, audit.Action.CHANGED, player_id, subject, name=changed.name)
    row.name, row.description = changed.name, changed.description
    row.target, row.ordered = _target_json(changed), changed.ordered
    row.settings = changed.settings.to_json()
    row.measures = [measure.to_json() for measure in changed.measures]
    note_change(session, "behaviour", row.id)


def delete(session: Session, row: BehaviourRow, player_id: int | None = None) -> None:
    """Take a behaviour out of the lists; ``restore`` brings it back.

    Its recordings, its ranking and its runs stay stored, and so does what it has borrowed and what
    others have borrowed of it.

    Raises:
        Conflict: It is built-in, or a training of it is under way.
    """
    if row.built_in:
        raise Conflict(f"{row.name} is built-in and can't be deleted.")
    under_way = select(RunRow.id).where(RunRow.behaviour_id == row.id, RunRow.status.in_(NOT_OVER))
    if session.scalar(under_way.limit(1)) is not None:
        raise Conflict(f"A training of {row.name} is under way; cancel it first.")
    row.deleted_at = now()
    audit.note(session, audit.Action.DELETED, player_id, f"behaviour {row.id}", name=row.name)
    note_change(session, "behaviour", row.id)


def restore(session: Session, behaviour_id: int, player_id: int | None = None) -> BehaviourRow:
    """Bring a deleted behaviour back, with everything it had.

    Raises:
        NotFound: There has never been such a behaviour.
        NameTaken: Another behaviour has its name by now.
        Conflict: There are MAX_BEHAVIOURS already.
    """
    row = session.get(BehaviourRow, behaviour_id)
    if row is None:
        raise NotFound(f"There is no behaviour {behaviour_id}.")
    if row.deleted_at is not None:
        _refuse_too_many(session)
        _refuse_taken_name(session, row.name, besides=row.id)
        row.deleted_at = None
        audit.note(session, audit.Action.RESTORED, player_id, f"behaviour {row.id}", name=row.name)
        note_change(session, "behaviour", row.id)
    return row


def free_name(session: Session, name: str) -> str:
    """Return a name, followed by a number if behaviours have it already: "Column 1 (2)"."""
    taken = {folded(row.name) for row in listing(session)}
    free, number = name, 1
    while folded(free) in taken:
        number += 1
        free = f"{shown_line(name, MAX_NAME_LENGTH - 6)} ({number})"
    return free


def seed_built_in(session: Session) -> None:
    """Add the built-in behaviours that are missing."""
    slugs = set(session.scalars(select(BehaviourRow.slug)))
    for behaviour in published():
        if behaviour.slug not in slugs:
            _add(session, behaviour, built_in=True)


def _refuse_too_many(session: Session) -> None:
    query = select(func.count()).select_from(BehaviourRow)
    n = session.scalar(query.where(BehaviourRow.deleted_at.is_(None))) or 0
    if n >= MAX_BEHAVIOURS:
        raise Conflict(f"There are {n} behaviours already; delete some first.")


def _add(session: Session, behaviour: Behaviour, built_in: bool) -> BehaviourRow:
    row = BehaviourRow(
        slug=behaviour.slug,
        name=behaviour.name,
        description=behaviour.description,
        target=_target_json(behaviour),
        ordered=behaviour.ordered,
        built_in=built_in,
        game=behaviour.game,
        settings=behaviour.settings.to_json(),
        measures=[measure.to_json() for measure in behaviour.measures],
    )
    session.add(row)
    session.flush()
    note_change(session, "behaviour", row.id)
    return row


def _check(behaviour: Behaviour) -> None:
    game = game_of(behaviour)
    game.check_target(behaviour)
    check_measures(game, behaviour.measures)


def _target_json(behaviour: Behaviour) -> list[list[int]] | None:
    return None if behaviour.target is None else [list(cell) for cell in behaviour.target]


def _refuse_other_settings(
    session: Session, row: BehaviourRow, settings: GameSettings, before: GameSettings
) -> None:
    if row.built_in:
        raise Conflict("The game of a built-in behaviour can't be set. Make a copy instead.")
    if replace(settings, hidden=before.hidden) != before and _in_use(session, row.id):
        raise Conflict(
            "How the game is played can't be changed any more: games were recorded so. Make a copy"
            " of the behaviour instead."
        )
    trained = select(RunRow.id).where(RunRow.behaviour_id == row.id).limit(1)
    if settings.hidden != before.hidden and session.scalar(trained) is not None:
        raise Conflict(
            "What is hidden from learning can't be changed any more: trainings learned without it."
            " Make a copy of the behaviour instead."
        )


def _in_use(session: Session, behaviour_id: int) -> bool:
    """Whether a behaviour has recordings or runs, deleted ones included: they can be restored."""
    played = select(RecordingRow.id).where(RecordingRow.behaviour_id == behaviour_id).limit(1)
    trained = select(RunRow.id).where(RunRow.behaviour_id == behaviour_id).limit(1)
    return session.scalar(played) is not None or session.scalar(trained) is not None


def _refuse_taken_name(session: Session, name: str, besides: int | None = None) -> None:
    for row in listing(session):
        if row.id != besides and folded(row.name) == folded(name):
            raise NameTaken(f"There is a behaviour named {row.name} already. Choose another name.")


def _free_slug(session: Session, name: str) -> str:
    plain = unicodedata.normalize("NFKD", name).encode("ascii", "ignore").decode().lower()
    base = re.sub(r"[^a-z0-9]+", "-", plain).strip("-")[:60] or "behaviour"
    taken = set(
        session.scalars(select(BehaviourRow.slug).where(BehaviourRow.slug.like(f"{base}%")))
    )
    number, slug = 1, base
    while slug in taken:
        number += 1
        slug = f"{base}-{number}"
    return slug
