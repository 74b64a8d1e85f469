"""The results of a training as the API shows them."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable

from sqlalchemy.orm import Session

from server.api.schemas.measures import Measure, MeasureMean, MeasureRow
from server.api.schemas.rankings import UnderstoodStatement
from server.api.schemas.recordings import Recording
from server.api.schemas.runs import (
    Artifact,
    AttentionMap,
    ComparisonRow,
    ConfusedTiers,
    EvaluationGame,
    JudgedGames,
    PolicyGamesSummary,
    RankedReturn,
    RankingCheck,
    RewardAlarm,
    RunResults,
    TrainingGames,
    Verdict,
)
from server.api.things import statement_pictures
from server.api.views.recordings import RecordingViews
from server.api.views.runs import run_view
from server.vocabularies import VocabularyMaker
from tril.analysis.outcome import (
    AttentionState,
    CheckOutcome,
    CheckVerdict,
    RewardPercentiles,
    RewardState,
)
from tril.analysis.summary import winner
from tril.games import game_of
from tril.games.measuring import Measured, mean_of, measured_before
from tril.recipes import recipe_from_dict
from tril.store import behaviours, recordings
from tril.store.access.credentials import Identity
from tril.store.models import (
    ArtifactRow,
    BehaviourRow,
    EvaluationRow,
    RecordingRow,
    RunRow,
    Source,
)
from tril.store.training import artifacts, blind_answers, evaluations, training_games
from tril.store.training.alarms import alarm_of
from tril.store.training.demonstrations import best_demonstration
from tril.store.training.judged_games import judged_games
from tril.store.training.verdicts import verdict_of
from tril.teaching import proposals


def artifact_view(row: ArtifactRow) -> Artifact:
    """Show a file of a training."""
    return Artifact.of(row, url=f"/api/artifacts/{row.id}")


def run_results(
    session: Session, who: Identity, run: RunRow, vocabularies: VocabularyMaker
) -> RunResults:
    """Show the results of a training so far."""
    views = RecordingViews(session, who, run.behaviour_id)
    games = evaluations.listing(session, run.id)
    files = artifacts.listing(session, run.id)
    tiers = run.snapshot.tiers if run.snapshot else []
    alarm = alarm_of(session, run)
    headline_starts = recipe_from_dict(run.recipe).evaluation.start_numbers
    further = sorted({row.start_number for row in games} - set(headline_starts))
    demonstrations = recordings.by_ids(session, [i for tier in tiers for i in tier])
    shown = {key: views.view(row) for key, row in demonstrations.items()}
    best = best_demonstration(session, run)
    beside = evaluations.shown_game(games, best)
    said = verdict_of(session, run, alarm)
    n_targets = behaviours.n_targets(session, run.behaviour_id)
    proposed = proposals.proposed_games(games, headline_starts, n_targets)
    return RunResults(
        run=run_view(session, run),
        verdict=None if said is None else Verdict.model_validate(said),
        check=_check(session, run, shown, vocabularies),
        comparison=_comparison(headline_starts, games, views),
        further_comparison=_comparison(further, games, views),
        games=[_game(row, views) for row in games],
        proposed=[row.recording_id for row in proposed],
        shown_game=None if beside is None else beside.recording_id,
        training_games=_training_games(session, run.id, views),
        summaries=_summaries(games, n_targets),
        measures=_measures(session, run, games, demonstrations.values()),
        blind=blind_answers.result_of(session, run.id),
        best_demonstration=None if best is None else views.view(best),
        alarm=None if alarm is None else RewardAlarm.model_validate(alarm),
        judged=[JudgedGames.model_validate(one) for one in judged_games(session, run, games)],
        attention=_attention(files),
        percentiles=_percentiles(files),
        artifacts=[artifact_view(row) for row in files],
    )


def _training_games(session: Session, run_id: str, views: RecordingViews) -> TrainingGames | None:
    steps, rows = training_games.latest(session, run_id)
    return TrainingGames(steps=steps, games=[views.view(row) for row in rows]) if rows else None


def _check(
    session: Session, run: RunRow, shown: dict[int, Recording], vocabularies: VocabularyMaker
) -> RankingCheck | None:
    check = run.outcome.check
    if check is None:
        return None
    returns = check.predicted_returns
    tiers = run.snapshot.tiers if run.snapshot else []
    return RankingCheck(
        **check.model_dump(include=CheckVerdict.model_fields.keys() - {"statements"}),
        statements=_statements(session, run, check, vocabularies),
        confused=[
            ConfusedTiers.of(
                pair,
                better_tier=pair.better,
                worse_tier=pair.worse,
                better=tiers[pair.better - 1],
                worse=tiers[pair.worse - 1],
            )
            for pair in check.confused
        ],
        returns=[
            RankedReturn(
                tier=place,
                recording=shown[key],
                predicted_return=returns[key],
                final_level=check.final_levels.get(key),
            )
            for place, tier in enumerate(tiers, start=1)
            for key in tier
            if key in shown and key in returns
        ],
    )


def _statements(
    session: Session, run: RunRow, check: CheckOutcome, vocabularies: VocabularyMaker
) -> list[UnderstoodStatement]:
    game = game_of(behaviours.as_behaviour(session.get_one(BehaviourRow, run.behaviour_id)))
    pictures = statement_pictures(vocabularies, run.behaviour_id, game, check.statements)
    return [
        UnderstoodStatement(**statement.model_dump(), pictures=urls)
        for statement, urls in zip(check.statements, pictures, strict=True)
    ]


def _game(row: EvaluationRow, views: RecordingViews) -> EvaluationGame:
    return EvaluationGame.of(row, recording=views.view(row.recording))


def _comparison(
    starts: Iterable[int], games: list[EvaluationRow], views: RecordingViews
) -> list[ComparisonRow]:
    """Return the thesis' table: greedy games from these starts, side by side."""
    greedy = {
        (row.start_number, row.policy): row for row in games if row.action_selection == "greedy"
    }
    table = []
    for number in starts:
        ours, theirs = (greedy.get((number, policy)) for policy in evaluations.POLICIES)
        if ours is None and theirs is None:
            continue
        table.append(
            ComparisonRow(
                start_number=number,
                held_out=all(row.held_out for row in (ours, theirs) if row is not None),
                imitator=None if ours is None else _game(ours, views),
                clone=None if theirs is None else _game(theirs, views),
                winner=winner(
                    *(
                        None if row is None else evaluations.figures_of(row)
                        for row in (ours, theirs)
                    )
                ),
            )
        )
    return table


def _summaries(games: list[EvaluationRow], n_targets: int | None) -> list[PolicyGamesSummary]:
    """Return means over the games from held-out starts."""
    return [
        PolicyGamesSummary(policy=policy, action_selection=how, summary=summary)
        for (policy, how), summary in evaluations.summaries(games, n_targets).items()
    ]


def _measures(
    session: Session,
    run: RunRow,
    games: Iterable[EvaluationRow],
    demonstrations: Iterable[RecordingRow],
) -> list[MeasureRow]:
    """Return the behaviour's measures over the games of imitator, clone and people."""
    behaviour = behaviours.as_behaviour(session.get_one(BehaviourRow, run.behaviour_id))
    played: dict[str, list[RecordingRow]] = {
        policy: [row.recording for row in evaluations.headline_games(games, policy)]
        for policy in evaluations.POLICIES
    }
    played["person"] = [row for row in demonstrations if row.source == Source.PERSON]
    values = {
        player: [measured_before(behaviour.measures, row.measured) for row in rows]
        for player, rows in played.items()
    }
    return [
        MeasureRow(
            measure=Measure.of_measure(measure),
            unit=measure.unit,
            **{player: _mean([game[place] for game in found]) for player, found in values.items()},
        )
        for place, measure in enumerate(behaviour.measures)
    ]


def _mean(games: list[Measured]) -> MeasureMean | None:
    mean = mean_of(games)
    return None if mean is None else MeasureMean.of(mean)


def _percentiles(files: list[ArtifactRow]) -> list[RewardState]:
    found = [row for row in files if row.kind == "reward_percentiles"]
    return RewardPercentiles.model_validate(found[0].details).states if found else []


def _attention(files: list[ArtifactRow]) -> list[AttentionMap]:
    """Show the states that have all three pictures, from the lowest R to the highest."""
    pictures: dict[str, dict[str, ArtifactRow]] = defaultdict(dict)
    for row in files:
        if row.kind.startswith("attention_"):
            pictures[row.details["state"]][row.kind] = row
    shown = []
    for state in AttentionState:
        found = pictures.get(state, {})
        if not {"attention_frame", "attention_map", "attention_red_blue"} <= found.keys():
            continue
        shown.append(
            AttentionMap(
                **found["attention_map"].details,
                frame_url=artifact_view(found["attention_frame"]).url,
                map_url=artifact_view(found["attention_map"]).url,
                red_blue_url=artifact_view(found["attention_red_blue"]).url,
            )
        )
    return shown
