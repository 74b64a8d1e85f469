"""Blind comparisons of the games of runs: what people answered, and what follows from it."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import groupby

from sqlalchemy import select
from sqlalchemy.orm import Session

from tril.analysis.blind import (
    BlindAnswer,
    BlindPair,
    BlindResult,
    JudgedPair,
    blind_result,
    draw_pairs,
)
from tril.errors import Conflict
from tril.ranking import best_ranked
from tril.store import audit, recordings
from tril.store.changes import note_change
from tril.store.models import BlindAnswerRow, EvaluationRow, RecordingRow, RunRow, RunStatus, Source
from tril.store.training import runs
from tril.store.training.judged_games import PLAYERS

UPPER_SHARE = 0.5
"""Share of the ranked games that the imitator is compared with, besides the best efforts."""


class BlindConflict(Conflict):
    """An answer that does not follow what was answered before."""


@dataclass(frozen=True)
class BlindRound:
    """A round of a person.

    Attributes:
        player_id: Person, None if they are not known.
        number: Number among their rounds of the run, from 1.
        judged: Judged pairs, in order.
        is_over: Whether it was ended, after which nothing is added to it.
    """

    player_id: int | None
    number: int
    judged: tuple[JudgedPair, ...] = ()
    is_over: bool = False


def pairs_of(session: Session, run: RunRow, round_number: int) -> list[BlindPair]:
    """Return the pairs of a round of a run; none before the run is done.

    The games of the policies are greedy ones from held-out starts, as the headline's. The others
    are demonstrations that a person or the demonstrator played, of the best efforts and of the
    upper half of the ranking that the run has learned from.
    """
    if run.status != RunStatus.DONE or run.snapshot is None:
        return []
    # Without the recordings, whose actions take most of the time to read.
    query = select(EvaluationRow.start_number, EvaluationRow.policy, EvaluationRow.recording_id)
    is_shown = (EvaluationRow.held_out, EvaluationRow.action_selection == "greedy")
    games = session.execute(query.where(EvaluationRow.run_id == run.id, *is_shown))
    greedy = {(start, policy): recording_id for start, policy, recording_id in games}
    starts = [
        (greedy[start, "imitator"], greedy[start, "clone"])
        for start in sorted({start for start, _ in greedy})
        if (start, "imitator") in greedy and (start, "clone") in greedy
    ]
    best = best_ranked(run.snapshot.tiers, UPPER_SHARE)
    ids = list(dict.fromkeys([*run.snapshot.perfect, *best]))
    sources = {
        key: row.source for key, row in recordings.by_ids(session, ids, RecordingRow.source).items()
    }
    own = [key for key in ids if sources.get(key) in (Source.PERSON, Source.SCRIPTED)]
    return draw_pairs(run.id, round_number, starts, own)


def rows_of(session: Session, run_id: str) -> list[BlindAnswerRow]:
    """Return everything that was done in blind comparisons of a run, oldest first."""
    query = select(BlindAnswerRow).where(BlindAnswerRow.run_id == run_id)
    return list(session.scalars(query.order_by(BlindAnswerRow.id)))


def rounds_of(session: Session, run_id: str) -> list[BlindRound]:
    """Return the rounds of all people, each person's in order."""
    rows = rows_of(session, run_id)
    others = recordings.by_ids(session, {row.other_id for row in rows}, RecordingRow.source)

    def key(row: BlindAnswerRow) -> tuple[int, int]:
        return (row.player_id or 0, row.round)

    return [
        _round(list(group), others)
        # Sorting is stable: within a round they stay in the order of time.
        for _, group in groupby(sorted(rows, key=key), key=key)
    ]


def _round(rows: list[BlindAnswerRow], others: dict[int, RecordingRow]) -> BlindRound:
    judged: dict[int, JudgedPair] = {}
    is_over = False
    for row in rows:
        answer = BlindAnswer(row.answer)
        if answer is BlindAnswer.ENDED:
            is_over = True
        elif answer is BlindAnswer.TAKEN_BACK:
            judged.pop(row.pair, None)
        else:
            source = others[row.other_id].source
            judged[row.pair] = JudgedPair(
                row.imitator_id,
                row.other_id,
                row.imitator_left,
                row.pair,
                "clone" if source == Source.POLICY else PLAYERS[source],
                answer,
            )
    ordered = tuple(judged[number] for number in sorted(judged))
    return BlindRound(rows[0].player_id, rows[0].round, ordered, is_over)


def own_rounds(rounds: Iterable[BlindRound], player_id: int) -> tuple[list[BlindRound], BlindRound]:
    """Return a person's rounds that are over, in order, and the one that they are in or begin."""
    own = [blind_round for blind_round in rounds if blind_round.player_id == player_id]
    if own and not own[-1].is_over:
        return own[:-1], own[-1]
    return own, BlindRound(player_id, own[-1].number + 1 if own else 1)


def result_of(session: Session, run_id: str) -> BlindResult | None:
    """Return the result of a run's latest round of each person, of those that are over."""
    rounds = rounds_of(session, run_id)
    latest = {
        blind_round.player_id: blind_round.judged for blind_round in rounds if blind_round.is_over
    }
    return blind_result(latest.values())


def answer(
    session: Session,
    run_id: str,
    player_id: int,
    round_number: int,
    pair_number: int,
    given: BlindAnswer,
) -> None:
    """Keep what a person does in their round.

    Args:
        session: The transaction.
        run_id: The run.
        player_id: The person.
        round_number: Number of the round.
        pair_number: The pair that is judged, for TAKEN_BACK and ENDED, the last judged pair.
        given: What they do.

    Raises:
        NotFound: No such run.
        BlindConflict: It does not follow what they did before, as when two tabs are open.
    """
    run = runs.get(session, run_id, for_update=True)
    _, current = own_rounds(rounds_of(session, run_id), player_id)
    pairs = pairs_of(session, run, current.number)
    n_judged = len(current.judged)
    judges = given not in (BlindAnswer.TAKEN_BACK, BlindAnswer.ENDED)
    expected = (current.number, n_judged + 1 if judges else n_judged)
    if (round_number, pair_number) != expected or not 1 <= pair_number <= len(pairs):
        raise BlindConflict(
            "This comparison was continued elsewhere, for example in another tab. It is shown as it"
            " stands now."
        )
    shown = pairs[pair_number - 1]
    session.add(
        BlindAnswerRow(
            run_id=run_id,
            player_id=player_id,
            round=round_number,
            pair=pair_number,
            imitator_id=shown.imitator_id,
            other_id=shown.other_id,
            imitator_left=shown.imitator_left,
            answer=given,
        )
    )
    session.flush()
    if given is BlindAnswer.ENDED:
        audit.note(session, audit.Action.COMPARED, player_id, f"run {run_id}", round=round_number)
        note_change(session, "run", run_id)
