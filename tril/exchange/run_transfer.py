"""Export and import of a finished run: its row, its games, its curves and its files."""

from __future__ import annotations

import secrets
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from typing import Any, TypeVar

from sqlalchemy.orm import Session

from tril import __version__
from tril.analysis.outcome import (
    AttentionDetails,
    RewardPercentiles,
    RewardState,
    RunOutcome,
    RunSnapshot,
    ToldStatement,
)
from tril.demonstrators import kind_named
from tril.exchange.behaviour_transfer import add_behaviour, describe, replay_all
from tril.exchange.blind_transfer import add_blind_answers, blind_objects
from tril.exchange.formats.recording_file import as_recording
from tril.exchange.formats.recording_object import RecordingObject
from tril.exchange.formats.run_file import (
    RUN_FORMAT,
    RUN_VERSION,
    CurvePoint,
    EvaluationGame,
    PlayedGame,
    RunObject,
    RunRefused,
    TaughtBehaviour,
)
from tril.exchange.run_archive import NETWORKS, PICTURES, RunArchive, picture_name
from tril.files.artifact_store import ArtifactStore
from tril.games.base import Taken
from tril.games.behaviours import score
from tril.recipes import checked, recipe_from_dict
from tril.recording import Recording, Replay
from tril.stages import Stage
from tril.store import audit, behaviours, rankings, recordings
from tril.store.changes import note_change
from tril.store.database import Database
from tril.store.models import (
    BehaviourRow,
    EvaluationRow,
    RankingRow,
    RecordingRow,
    RunRow,
    RunStatus,
    Source,
)
from tril.store.training import artifacts, evaluations, metrics, runs
from tril.store.training.evaluations import EvaluationKey

State = TypeVar("State", bound=RewardState)

MAX_RECIPE_NAME = 40
UNFINISHED = "imports"
"""Folder of the artifact store where the files of a run wait until its row is written."""
UNFINISHED_FOR = timedelta(hours=1)
"""An import takes minutes: after so long, its process has ended."""
_MOMENT = "%Y%m%dT%H%M%S"
PNG = "image/png"
_BYTES = "application/octet-stream"


@dataclass(frozen=True)
class ExportedRun:
    """A run with the rows of its recordings, in the order in which ``run`` lists them."""

    run: RunObject
    ranked: list[RecordingRow]
    unranked: list[RecordingRow]
    evaluation: list[EvaluationRow]


@dataclass(frozen=True)
class RunImportResult:
    """The result of importing a run.

    Attributes:
        run_id: The run, which has the id that it had where it was trained.
        behaviour_id: Behaviour of the run.
        was_there: Whether it had been imported, or trained here, before; then nothing was changed
            but that it is shown again if it was deleted.
    """

    run_id: str
    behaviour_id: int
    was_there: bool


def export_run(session: Session, run_id: str) -> ExportedRun:
    """Return a finished run.

    Raises:
        NotFound: No such run, or its behaviour was deleted.
        Conflict: It is not finished.
    """
    row = runs.get_done(session, run_id)
    assert row.snapshot is not None
    assert row.finished_at is not None
    taught = behaviours.as_behaviour(behaviours.get(session, row.behaviour_id))
    ids = set(row.snapshot.recordings)
    rows = recordings.by_ids(session, ids)
    ranked = [rows[number] for number in row.snapshot.ranked]
    ranked_ids = {game.id for game in ranked}
    unranked = [rows[number] for number in row.snapshot.perfect if number not in ranked_ids]
    games = evaluations.listing(session, run_id)
    files = artifacts.listing(session, run_id)
    percentiles = [file for file in files if file.kind == "reward_percentiles"]
    run = RunObject(
        format=RUN_FORMAT,
        version=RUN_VERSION,
        game=taught.game,
        tril=__version__,
        id=row.id,
        name=row.name,
        notes=row.notes,
        behaviour=TaughtBehaviour(**describe(taught)),
        recipe=row.recipe,
        steps=row.steps,
        training_seed=row.training_seed,
        go_on_anyway=row.go_on_anyway,
        example=row.example,
        example_kind=row.example_kind,
        versions=row.versions,
        finished_stages={Stage(stage): s for stage, s in row.finished_stages.items()},
        created_at=row.created_at,
        started_at=row.started_at,
        finished_at=row.finished_at,
        tiers=row.snapshot.tiers,
        perfect=row.snapshot.perfect,
        outcome=row.outcome,
        curves=_points(session, run_id),
        percentiles=RewardPercentiles.model_validate(percentiles[0].details).states
        if percentiles
        else [],
        attention=[
            AttentionDetails.model_validate(file.details)
            for file in files
            if file.kind == "attention_map"
        ],
        ranked=[PlayedGame(**_played(game)) for game in ranked],
        unranked=[PlayedGame(**_played(game)) for game in unranked],
        evaluation=[
            EvaluationGame(
                **_played(game.recording),
                policy=game.policy,  # type: ignore[arg-type]
                action_selection=game.action_selection,  # type: ignore[arg-type]
                start_number=game.start_number,
                held_out=game.held_out,
                predicted_return=game.predicted_return,
                final_level=game.final_level,
            )
            for game in games
        ],
        **blind_objects(session, run_id),
    )
    return ExportedRun(run, ranked, unranked, games)


def _points(session: Session, run_id: str) -> list[CurvePoint]:
    by_step: dict[tuple[str, int], dict[str, float]] = {}
    for stage, curves in metrics.series(session, run_id)[1].items():
        for name, curve in curves.items():
            for step, value in curve:
                by_step.setdefault((stage, step), {})[name] = value
    return [
        CurvePoint(stage=Stage(stage), step=step, values=values)
        for (stage, step), values in by_step.items()
    ]


def _played(row: RecordingRow) -> dict[str, Any]:
    return {
        "number": row.id,
        "counters": row.counters,
        "score": row.score or 0.0,
        "taken_frames": [frame for *_, frame in row.taken],
        "played_at": row.created_at,
    }


def import_run(
    database: Database,
    store: ArtifactStore,
    archive: RunArchive,
    *,
    name: str | None = None,
    trusted: bool = False,
    player_id: int | None = None,
) -> RunImportResult:
    """Add a run with its behaviour, recordings, ranking and files, as if it had been trained here.

    A matching built-in behaviour that is still empty is filled; otherwise a new one is made, with a
    number after its name if there is one of that name. A run that is here already is not added
    again; if it or its behaviour was deleted, it is restored.

    Args:
        database: The application's database.
        store: The artifact store.
        archive: The run.
        name: Name of a new behaviour for it; None fills a built-in one if it can.
        trusted: Whether its recordings are taken as they are, without replaying them, since the
            file ships with Tril.
        player_id: Player that imports the run; None for a command in the terminal.

    Raises:
        RunRefused: A recording does not replay to what the file says.
        Invalid: Its recipe or its kind of example is none of this version.
        NameTaken: A deleted behaviour of the run can't be restored since another has its name.
        Conflict: There are too many behaviours.
    """
    run = archive.run
    with database.writing() as session:
        if (imported := _restored(session, run.id, player_id)) is not None:
            return imported
    recipe = checked(recipe_from_dict(run.recipe))
    if len(recipe.name) > MAX_RECIPE_NAME:
        raise RunRefused("The name of the run's recipe is too long.")
    kind_named(run.example_kind)
    if trusted:
        replayed = recorded(archive)
    else:
        numbered = (
            (game.number, played) for game, played in (*archive.demonstrations, *archive.games)
        )
        replayed = {
            number: (imported.recording, imported.replay)
            for number, imported in replay_all(numbered, RunRefused).items()
        }
    remove_unfinished_imports(store)
    folder = f"{UNFINISHED}/{datetime.now(UTC):{_MOMENT}}-{secrets.token_hex(8)}"
    try:
        paths = _put_files(store, archive, folder)
        with database.writing() as session:
            # Another process may have imported it meanwhile.
            if (imported := _restored(session, run.id, player_id)) is not None:
                store.remove_folder(folder)
                return imported
            # Nobody else moves files there before this transaction ends.
            store.move_folder(folder, artifacts.folder_of(run.id))
            new_name = name and behaviours.free_name(session, name)
            behaviour, _ = add_behaviour(session, run.behaviour, run.game, new_name)
            ids = {
                game.number: _add(
                    session,
                    behaviour.id,
                    game,
                    recording_object,
                    replayed[game.number],
                    run.perfect,
                )
                for game, recording_object in archive.demonstrations
            }
            _rank(session, behaviour.id, run, ids)
            row = RunRow(
                id=run.id,
                behaviour_id=behaviour.id,
                example=run.example,
                example_kind=run.example_kind,
                recipe_name=recipe.name,
                recipe=recipe.to_dict(),
                training_seed=run.training_seed,
                steps=run.steps,
                go_on_anyway=run.go_on_anyway,
                snapshot=RunSnapshot(
                    ranking_revision=1,
                    tiers=_renumbered(run.tiers, ids),
                    perfect=[ids[number] for number in run.perfect],
                ),
                versions=run.versions,
                status=RunStatus.DONE,
                stage=Stage.ATTENTION,
                stage_done=1.0,
                finished_stages={str(stage): s for stage, s in run.finished_stages.items()},
                outcome=_outcome(run.outcome, ids),
                created_at=run.created_at,
                started_at=run.started_at,
                finished_at=run.finished_at,
            )
            session.add(row)
            session.flush()
            runs.describe(session, run.id, run.name, run.notes)
            _add_results(session, archive, behaviour, ids, replayed)
            _name_files(session, run, ids, paths)
            _keep_percentiles(session, store, run, ids)
            audit.note(session, audit.Action.IMPORTED, player_id, f"run {run.id}")
            note_change(session, "run", run.id)
            return RunImportResult(run.id, behaviour.id, was_there=False)
    except BaseException:
        store.remove_folder(folder)
        with database.writing() as session:
            if session.get(RunRow, run.id) is None:
                store.remove_folder(artifacts.folder_of(run.id))
        raise


def remove_unfinished_imports(store: ArtifactStore, now: datetime | None = None) -> None:
    """Remove the files of imports whose process ended before they had a run."""
    oldest = (now or datetime.now(UTC)) - UNFINISHED_FOR
    for name in store.names(UNFINISHED):
        if name < f"{oldest:{_MOMENT}}":
            store.remove_folder(f"{UNFINISHED}/{name}")


def _restored(session: Session, run_id: str, player_id: int | None) -> RunImportResult | None:
    """Return a run that is here already, restored with its behaviour if one was deleted."""
    row = session.get(RunRow, run_id)
    if row is None:
        return None
    behaviours.restore(session, row.behaviour_id, player_id)
    if row.deleted_at is not None:
        row.deleted_at = None
        audit.note(session, audit.Action.RESTORED, player_id, f"run {run_id}")
        note_change(session, "run", run_id)
    return RunImportResult(run_id, row.behaviour_id, was_there=True)


def recorded(archive: RunArchive) -> dict[int, tuple[Recording, Replay]]:
    """Return the recordings with what the file says happened in them."""
    recordings = {}
    for game, recording_object in (*archive.demonstrations, *archive.games):
        recording = as_recording(recording_object)
        taken = tuple(
            Taken(row, column, frame)
            for (row, column), frame in zip(
                recording_object.taken or (), game.taken_frames, strict=True
            )
        )
        end = (
            None if recording_object.end is None else recording.game.end(recording_object.end).name
        )
        recordings[game.number] = (
            recording,
            Replay(taken, end, recording.n_frames, game.counters, game.score, recording.hashes),
        )
    return recordings


def _put_files(
    store: ArtifactStore, archive: RunArchive, folder: str
) -> dict[str, tuple[str, int, str]]:
    """Write the run's files.

    Returns:
        Their names, sizes and digests by kind of network or picture's name.
    """
    files = {kind: (NETWORKS[kind], content) for kind, content in archive.networks.items()}
    files |= {name: (name, content) for name, content in archive.pictures.items()}
    written = {}
    for key, (name, content) in files.items():
        plain = name.rpartition("/")[2]
        size = store.put(f"{folder}/{plain}", content)
        written[key] = (plain, size, artifacts.digest(content))
    return written


def _add(
    session: Session,
    behaviour_id: int,
    game: PlayedGame,
    recording_object: RecordingObject,
    replayed: tuple[Recording, Replay],
    perfect: Iterable[int],
) -> int:
    recording, played = replayed
    row = recordings.add(
        session,
        behaviour_id,
        recording,
        played,
        Source(recording_object.source or Source.PERSON),
        perfect=game.number in perfect,
        notes=recording_object.notes or "",
        conditions=recording_object.conditions,
    )
    row.created_at = row.finished_at = game.played_at
    return row.id


def _rank(session: Session, behaviour_id: int, run: RunObject, ids: Mapping[int, int]) -> None:
    revision = RankingRow(
        behaviour_id=behaviour_id,
        revision=1,
        tiers=_renumbered(run.tiers, ids),
        change="example" if run.example else "import",
        undo_to=0,
        created_at=run.created_at,
    )
    rankings.restore_history(session, behaviour_id, [revision])


def _add_results(
    session: Session,
    archive: RunArchive,
    behaviour: BehaviourRow,
    ids: Mapping[int, int],
    replayed: Mapping[int, tuple[Recording, Replay]],
) -> None:
    run_id, taught = archive.run.id, behaviours.as_behaviour(behaviour)
    numbered = dict(ids)
    for game, recording_object in archive.games:
        recording, played = replayed[game.number]
        row = recordings.add(
            session,
            behaviour.id,
            recording,
            played,
            Source.POLICY,
            run_id=run_id,
            conditions=recording_object.conditions,
        )
        row.created_at = row.finished_at = game.played_at
        numbered[game.number] = row.id
        evaluations.add(
            session,
            run_id,
            EvaluationKey(game.policy, game.action_selection, game.start_number),
            row.id,
            game.held_out,
            game.predicted_return,
            game.final_level,
            score(taught, tuple(item.cell for item in played.taken)),
        )
    points = [(str(point.stage), point.step, point.values) for point in archive.run.curves]
    metrics.add_curves(session, run_id, points)
    add_blind_answers(session, archive.run, numbered)


def _name_files(
    session: Session,
    run: RunObject,
    ids: Mapping[int, int],
    files: Mapping[str, tuple[str, int, str]],
) -> None:
    for kind in NETWORKS:
        name, size, digest = files[kind]
        artifacts.save(session, run.id, kind, name, _BYTES, size, sha256=digest)
    for state in run.attention:
        details = _moved(state, ids).model_dump(mode="json")
        for kind in PICTURES:
            name, size, digest = files[picture_name(state.state, kind)]
            artifacts.save(session, run.id, kind, name, PNG, size, details, digest)


def _keep_percentiles(
    session: Session, store: ArtifactStore, run: RunObject, ids: Mapping[int, int]
) -> None:
    if not run.percentiles:
        return
    name = "reward-percentiles.json"
    percentiles = RewardPercentiles(states=[_moved(state, ids) for state in run.percentiles])
    size = store.put(artifacts.path_of(run.id, name), percentiles.model_dump_json().encode())
    details = percentiles.model_dump(mode="json")
    artifacts.save(session, run.id, "reward_percentiles", name, "application/json", size, details)


def _outcome(outcome: RunOutcome, ids: Mapping[int, int]) -> RunOutcome:
    """Return an outcome that names the recordings by their ids here."""
    changed: dict[str, Any] = {}
    if check := outcome.check:
        changed["check"] = check.model_copy(
            update={
                "predicted_returns": {ids[k]: v for k, v in check.predicted_returns.items()},
                "final_levels": {ids[k]: v for k, v in check.final_levels.items()},
                "statements": [_about(statement, ids) for statement in check.statements],
            }
        )
    if example := outcome.example:
        lists = ("true_tiers", "given_tiers", "mistakes")
        moved = {name: _renumbered(getattr(example, name), ids) for name in lists}
        changed["example"] = example.model_copy(update=moved)
    return outcome.model_copy(update=changed)


def _about(statement: ToldStatement, ids: Mapping[int, int]) -> ToldStatement:
    """Return a statement whose moments are of the recordings by their ids here."""
    moments = {"shown": statement.shown, "contrast": statement.contrast}
    moved = {
        name: moment and moment.model_copy(update={"recording_id": ids[moment.recording_id]})
        for name, moment in moments.items()
    }
    return statement.model_copy(update=moved)


def _moved(state: State, ids: Mapping[int, int]) -> State:
    return state.model_copy(update={"recording_id": ids[state.recording_id]})


def _renumbered(tiers: Iterable[Iterable[int]], ids: Mapping[int, int]) -> list[list[int]]:
    return [[ids[number] for number in tier] for tier in tiers]
