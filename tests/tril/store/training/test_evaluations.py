"""Evaluation games on a migrated database: which were played and what they come to."""

from __future__ import annotations

from testsupport.libraries import replay_of
from testsupport.workplace import Workplace
from tril.games.behaviours import Score
from tril.store import recordings
from tril.store.models import EvaluationRow, RecordingRow, Source
from tril.store.training import evaluations
from tril.store.training.evaluations import EvaluationKey


def play(
    workplace: Workplace, run_id: str, key: EvaluationKey, targets: int, held_out: bool
) -> None:
    with workplace.database.writing() as session:
        score = Score(targets, 0, 0)
        evaluations.add(session, run_id, key, workplace.ranked[0], held_out, 1.0, 0.5, score)


def test_means_are_over_held_out_starts_by_policy_and_action_selection(
    workplace: Workplace,
) -> None:
    run_id = workplace.make_run()
    play(workplace, run_id, EvaluationKey("clone", "sticky", 0), 1, held_out=True)
    play(workplace, run_id, EvaluationKey("imitator", "sticky", 0), 2, held_out=True)
    play(workplace, run_id, EvaluationKey("imitator", "sticky", 1), 4, held_out=True)
    play(workplace, run_id, EvaluationKey("imitator", "sticky", 2), 6, held_out=False)
    play(workplace, run_id, EvaluationKey("imitator", "greedy", 0), 5, held_out=True)
    with workplace.database.reading() as session:
        found = evaluations.summaries(evaluations.listing(session, run_id), n_targets=4)
    # No sampled games, as in runs of earlier versions.
    assert list(found) == [("imitator", "greedy"), ("imitator", "sticky"), ("clone", "sticky")]
    sticky = found["imitator", "sticky"].targets
    assert sticky is not None
    assert (sticky.mean, sticky.n) == (3.0, 2)
    perfect = found["imitator", "sticky"].perfect
    assert perfect is not None
    assert perfect.mean == 0.5


def test_each_action_selection_is_a_game_of_its_own(workplace: Workplace) -> None:
    run_id = workplace.make_run()
    keys = {
        EvaluationKey("imitator", action_selection, 0)
        for action_selection in evaluations.ACTION_SELECTIONS
    }
    for key in keys:
        play(workplace, run_id, key, 1, held_out=True)
    with workplace.database.reading() as session:
        assert evaluations.played(session, run_id) == keys


def test_the_game_that_is_shown_began_nearest_to_the_best_one_and_from_a_held_out_start(
    workplace: Workplace,
) -> None:
    run_id = workplace.make_run()
    begun = {("imitator", "greedy"): (40, 10, 28), ("clone", "greedy"): (30,)}
    begun |= {("imitator", "sticky"): (30,)}
    for (policy, how), starts in begun.items():
        for number, idle_frames in enumerate(starts):
            # Of the three greedy ones the nearest began from a start that was seen.
            game = EvaluationKey(policy, how, number)
            play(workplace, run_id, game, 1, held_out=idle_frames != 28)
            _begin_after(workplace, run_id, idle_frames)
    with workplace.database.reading() as session:
        games = evaluations.listing(session, run_id)
        best = games[0].recording
        best.start = {"idle_frames": 30}

        def shown(among: list[EvaluationRow], beside: RecordingRow | None = best) -> int | None:
            row = evaluations.shown_game(among, beside)
            return None if row is None else row.recording.start["idle_frames"]

        assert shown(games) == 40
        assert shown([row for row in games if not row.held_out]) == 28
        assert shown(games, None) == 40
        assert shown([row for row in games if row.policy == "clone"]) is None


def _begin_after(workplace: Workplace, run_id: str, idle_frames: int) -> None:
    """Give the newest evaluation game a recording of its own that begins after so many frames."""
    with workplace.database.writing() as session:
        row = max(evaluations.listing(session, run_id), key=lambda row: row.id)
        source = recordings.get(session, workplace.ranked[0])
        copy = recordings.add(
            session,
            workplace.behaviour_id,
            recordings.as_recording(source),
            replay_of(source),
            Source.POLICY,
            run_id=run_id,
        )
        copy.start = {"idle_frames": idle_frames}
        row.recording_id = copy.id
