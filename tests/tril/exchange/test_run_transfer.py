"""A run goes from one data folder to another, and hostile files go nowhere."""

from __future__ import annotations

import errno
import io
import json
import pickle
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from safetensors.numpy import load, save

from testsupport.databases import on_postgresql
from testsupport.finished_runs import make_finished_run
from testsupport.libraries import replay_of
from testsupport.workplace import Workplace, make_workplace
from trainer.archive.run_archive import check_networks, write_archive
from trainer.policy.networks import load_policy
from tril.analysis.blind import BlindAnswer
from tril.analysis.outcome import ShownMoment, ToldStatement
from tril.errors import Conflict, Invalid
from tril.exchange import example, run_archive, run_transfer
from tril.exchange.example import BEHAVIOUR_NAME, open_example
from tril.exchange.run_archive import NETWORKS, RANKED, RUN_FILE, read_archive
from tril.exchange.run_transfer import RunImportResult, import_run
from tril.files.artifact_store import ArtifactStore
from tril.store import behaviours, players, rankings, recordings
from tril.store.database import Database, create_database
from tril.store.models import RecordingRow, RunRow, RunStatus
from tril.store.schema import upgrade
from tril.store.training import artifacts, blind_answers, evaluations, metrics, runs
from tril.store.training.judged_games import judged_games
from tril.store.training.verdicts import verdict_of

Members = dict[str, bytes]


@pytest.fixture(scope="module")
def exported(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Workplace, str, Path]]:
    folder = tmp_path_factory.mktemp("exported")
    made = make_workplace(folder / "data")
    run_id = make_finished_run(made)
    with made.database.writing() as session:
        owner = players.owner(session).id
        blind_answers.answer(session, run_id, owner, 1, 1, BlindAnswer.LEFT)
        blind_answers.answer(session, run_id, owner, 1, 1, BlindAnswer.ENDED)
        runs.describe(session, run_id, "Wide column", "Ann\u2019s games.\nAgain with more.")
        row = runs.get(session, run_id)
        assert row.outcome.check is not None
        moments = [
            ShownMoment(recording_id=made.ranked[place], first_frame=0, n_frames=60)
            for place in (0, 3)
        ]
        told = ToldStatement(
            sentence="FIRE held less", probability=0.8, shown=moments[0], contrast=moments[1]
        )
        check = row.outcome.check.model_copy(update={"statements": [told]})
        row.outcome = row.outcome.model_copy(update={"check": check})
    path = folder / "run.zip"
    store = ArtifactStore(made.settings.artifact_root)
    write_archive(made.database, store, run_id, path, lambda _: b"", compact=True)
    yield made, run_id, path
    made.database.close()


@pytest.fixture(scope="module")
def migrated(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return an empty database, which tests copy instead of migrating one each."""
    path = tmp_path_factory.mktemp("migrated") / "tril.sqlite"
    database = create_database(f"sqlite:///{path}")
    upgrade(database)
    database.close()
    return path


@pytest.fixture
def elsewhere(migrated: Path, tmp_path: Path) -> Iterator[Database]:
    """Return an empty data folder's database."""
    database = create_database(f"sqlite:///{shutil.copy(migrated, tmp_path)}")
    yield database
    database.close()


@pytest.fixture
def store(tmp_path: Path) -> ArtifactStore:
    return ArtifactStore(str(tmp_path / "artifacts"))


@pytest.fixture
def shipped(exported: tuple[Workplace, str, Path], monkeypatch: pytest.MonkeyPatch) -> str:
    """Let the exported run ship; return its id."""
    monkeypatch.setattr(example, "EXAMPLE", exported[2])
    return exported[1]


def brought(
    database: Database, store: ArtifactStore, file: Path | io.BytesIO, **options: Any
) -> RunImportResult:
    archive = read_archive(file)
    check_networks(archive)
    return import_run(database, store, archive, **options)


def results_of(database: Database, run_id: str) -> dict[str, Any]:
    """Return what a run's page shows, without ids of recordings."""
    with database.reading() as session:
        run = runs.get(session, run_id)
        assert run.snapshot is not None
        assert run.outcome.check is not None
        games = evaluations.listing(session, run_id)
        shown = recordings.by_ids(session, run.snapshot.recordings)
        ranked = [shown[number] for number in run.snapshot.ranked]
        verdict = verdict_of(session, run, None)
        return {
            "verdict": verdict,
            "ranked": [(one.actions, one.taken, one.counters["shots"], one.end) for one in ranked],
            "perfect": [shown[number].actions for number in run.snapshot.perfect],
            "returns": [run.outcome.check.predicted_returns[one.id] for one in ranked],
            "moments": [
                shown[moment.recording_id].actions
                for told in run.outcome.check.statements
                for moment in (told.shown, told.contrast)
                if moment
            ],
            "headline": run.outcome.headline,
            "recipe": run.recipe,
            "versions": run.versions,
            "stages": run.finished_stages,
            "finished_at": run.finished_at,
            "games": [
                (
                    one.policy,
                    one.action_selection,
                    one.targets,
                    one.strays,
                    one.predicted_return,
                    one.final_level,
                )
                for one in games
            ],
            "judged": [
                [game.predicted for game in one.games] for one in judged_games(session, run, games)
            ],
            "blind": blind_answers.result_of(session, run_id),
            "curves": metrics.series(session, run_id)[1],
            "kinds": {one.kind for one in artifacts.listing(session, run_id)},
            "states": [
                {**one.details, "recording_id": shown[one.details["recording_id"]].actions}
                for one in artifacts.listing(session, run_id)
                if one.kind == "attention_map"
            ],
        }


@pytest.mark.parametrize("trusted", [False, True])
def test_an_imported_run_shows_what_it_showed_where_it_was_trained(
    exported: tuple[Workplace, str, Path],
    elsewhere: Database,
    store: ArtifactStore,
    trusted: bool,
) -> None:
    there, run_id, path = exported
    with elsewhere.writing() as session:
        # So that no recording keeps its number.
        of = behaviours.create(session, "Before")
        with there.database.reading() as other:
            shown = recordings.get(other, there.ranked[0])
            recordings.add(
                session,
                of.id,
                recordings.as_recording(shown),
                replay_of(shown),
                "person",  # type: ignore[arg-type]
            )
    found = brought(elsewhere, store, path, trusted=trusted)
    assert (found.run_id, found.was_there) == (run_id, False)
    assert results_of(elsewhere, run_id) == results_of(there.database, run_id)
    with elsewhere.reading() as session:
        run = runs.get(session, run_id)
        assert (run.status, run.is_imported) == (RunStatus.DONE, True)
        assert (run.name, run.notes) == ("Wide column", "Ann\u2019s games.\nAgain with more.")
        behaviour = behaviours.get(session, run.behaviour_id)
        assert (behaviour.slug, behaviour.built_in) == ("column-1", True)
        assert run.snapshot is not None
        ranking = rankings.current(session, behaviour.id)
        assert (ranking.revision, ranking.tiers) == (1, run.snapshot.tiers)
        # How fast this machine is, it does not tell.
        assert runs.latest_done(session, run.recipe_name) is None
    with there.database.reading() as session:
        assert not runs.get(session, run_id).is_imported


def test_its_policies_do_the_same(
    exported: tuple[Workplace, str, Path], elsewhere: Database, store: ArtifactStore
) -> None:
    there, run_id, path = exported
    brought(elsewhere, store, path, trusted=True)
    inputs = np.random.default_rng(0).integers(0, 256, (4, 4, 84, 84), np.uint8)
    there_store = ArtifactStore(there.settings.artifact_root)
    with artifacts.local_file(there.database, there_store, run_id, "imitator") as file:
        expected = load_policy(file).probabilities(inputs)
    with artifacts.local_file(elsewhere, store, run_id, "imitator") as file:
        # Of half precision.
        np.testing.assert_allclose(load_policy(file).probabilities(inputs), expected, atol=0.05)


def test_a_run_is_imported_once_and_restored_after_it_was_deleted(
    shipped: str, elsewhere: Database, store: ArtifactStore
) -> None:
    first = open_example(elsewhere, store)
    before = counts(elsewhere)
    assert open_example(elsewhere, store) == RunImportResult(
        shipped, first.behaviour_id, was_there=True
    )
    with elsewhere.writing() as session:
        runs.delete(session, shipped)
        of = behaviours.get(session, first.behaviour_id)
        assert of.name == BEHAVIOUR_NAME
        behaviours.delete(session, of)
    assert open_example(elsewhere, store).was_there
    assert counts(elsewhere) == before
    with elsewhere.reading() as session:
        assert runs.get(session, shipped).behaviour_id == first.behaviour_id
        assert behaviours.get(session, first.behaviour_id).name == BEHAVIOUR_NAME


def test_one_that_another_process_imports_meanwhile_keeps_its_files(
    exported: tuple[Workplace, str, Path],
    elsewhere: Database,
    store: ArtifactStore,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    _, run_id, path = exported
    archive = read_archive(path)
    put_files = run_transfer._put_files

    def meanwhile(*arguments: Any) -> Any:
        monkeypatch.setattr(run_transfer, "_put_files", put_files)
        assert not import_run(elsewhere, store, archive, trusted=True).was_there
        return put_files(*arguments)

    monkeypatch.setattr(run_transfer, "_put_files", meanwhile)
    assert import_run(elsewhere, store, archive, trusted=True).was_there
    assert counts(elsewhere)[1] == 1
    assert store.exists(artifacts.path_of(run_id, "clone.safetensors"))


def counts(database: Database) -> tuple[int, int]:
    with database.reading() as session:
        return session.query(RecordingRow).count(), session.query(RunRow).count()


def test_a_run_does_not_touch_what_is_there(
    exported: tuple[Workplace, str, Path], workplace: Workplace
) -> None:
    path = exported[2]
    store = ArtifactStore(workplace.settings.artifact_root)
    found = brought(workplace.database, store, path, trusted=True)
    assert found.behaviour_id != workplace.behaviour_id
    with workplace.database.reading() as session:
        assert behaviours.get(session, found.behaviour_id).name == "Column 1 (2)"
        library = recordings.listing(session, workplace.behaviour_id)
        assert {row.id for row in library} == set(workplace.ranked)


def members_of(path: Path) -> Members:
    with zipfile.ZipFile(path) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def zipped(members: Mapping[str, bytes]) -> io.BytesIO:
    target = io.BytesIO()
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in members.items():
            archive.writestr(name, content)
    return target


def changed(change: Callable[[dict[str, Any]], object]) -> Callable[[Members], object]:
    """Return what changes run.json."""

    def on(members: Members) -> None:
        run = json.loads(members[RUN_FILE])
        change(run)
        members[RUN_FILE] = json.dumps(run).encode()

    return on


def without(name: str) -> Callable[[Members], object]:
    return lambda members: members.pop(name)


def with_weights(change: Callable[[dict[str, np.ndarray]], object]) -> Callable[[Members], object]:
    def on(members: Members) -> None:
        content = members[NETWORKS["reward_model"]]
        header = json.loads(content[8 : 8 + int.from_bytes(content[:8], "little")])
        weights = load(content)
        change(weights)
        members[NETWORKS["reward_model"]] = save(weights, header["__metadata__"])

    return on


def poisoned(weights: dict[str, np.ndarray]) -> None:
    weights["0.output.bias"] = np.array([np.nan], np.float32)


def of_integers(weights: dict[str, np.ndarray]) -> None:
    weights["0.output.bias"] = np.array([1], np.int64)


def without_scale(members: Members) -> None:
    name = NETWORKS["reward_model"]
    changed = members[name].replace(rb"\"one\": 2.0", rb"\"one\":-1.0")
    # As a file of an earlier version, without a digest.
    members[name] = changed.replace(b"sha256", b"sha255")


def large_picture(members: Members) -> None:
    target = io.BytesIO()
    Image.new("RGB", (5000, 5000)).save(target, "PNG")
    members["attention/attention-maximum.png"] = target.getvalue()


HOSTILE: dict[str, tuple[Callable[[Members], object], str]] = {
    "no run.json": (without(RUN_FILE), "has no run.json"),
    "no recordings": (without(RANKED), "has no recordings/ranked.jsonl"),
    "no weights": (without(NETWORKS["clone"]), "has no policy/clone.safetensors"),
    "no JSON": (lambda m: m.update({RUN_FILE: b"{"}), "can't be read"),
    "deep JSON": (lambda m: m.update({RUN_FILE: b"[" * 100_000}), "can't be read"),
    "another format": (changed(lambda r: r.update(format="x")), "not a run that Tril exported"),
    "a newer version": (changed(lambda r: r.update(version=3)), "newer version"),
    "a path for an id": (changed(lambda r: r.update(id="../../etc/passwd")), "id"),
    "a name that is too long": (changed(lambda r: r.update(name="x" * 81)), "name"),
    "notes with a NUL": (changed(lambda r: r.update(notes="\0")), "can't be accepted"),
    "an unknown member": (changed(lambda r: r.update(more=1)), "more"),
    "infinity": (lambda m: m.update({RUN_FILE: b'{"format": "tril-run", "a": NaN}'}), "can't be"),
    "a NUL": (changed(lambda r: r["versions"].update(python="\0")), "can't be accepted"),
    "an unknown stage": (changed(lambda r: r["curves"][0].update(stage="x")), "stage"),
    "other tiers": (changed(lambda r: r["tiers"].pop()), "tiers are not"),
    "a foreign recording": (
        changed(lambda r: r["percentiles"][0].update(recording_id=99)),
        "not ranked",
    ),
    "a blind comparison of other games": (
        changed(lambda r: r["blind"][0].update(imitator=r["ranked"][0]["number"])),
        "of other games",
    ),
    "one number twice": (
        changed(lambda r: r["evaluation"][0].update(number=r["ranked"][0]["number"])),
        "the number",
    ),
    "too few lines": (
        lambda m: m.update({RANKED: m[RANKED].partition(b"\n")[2]}),
        "lines, but 4",
    ),
    "no recording": (
        lambda m: m.update({RANKED: b"{}\n" + m[RANKED].partition(b"\n")[2]}),
        "missing",
    ),
    "a pickle for weights": (
        lambda m: m.update({NETWORKS["imitator"]: pickle.dumps(print)}),
        "can't be read as safetensors",
    ),
    "weights that are no numbers": (with_weights(poisoned), "no finite"),
    "weights of integers": (with_weights(of_integers), "no finite"),
    "no picture": (
        lambda m: m.update({"attention/attention-maximum.png": b"<svg onload='x'/>"}),
        "is no picture",
    ),
    "a huge picture": (large_picture, "too large"),
    "a reward without a scale": (without_scale, "from low to high"),
    "a damaged member": (lambda m: m.update({RUN_FILE: m[RUN_FILE][:-9]}), "can't be read"),
    "too many members": (
        lambda m: m.update({f"more/{n}": b"" for n in range(600)}),
        "too many members",
    ),
    "no recipe": (changed(lambda r: r.update(recipe={"name": "x"})), "recipe"),
    "a recipe out of range": (
        changed(lambda r: r["recipe"]["policy"].update(n_envs=-1)),
        "policy.n_envs must be",
    ),
    "an unknown kind of example": (changed(lambda r: r.update(example_kind="x")), "x"),
    "a statement shown by a game that is not ranked": (
        changed(
            lambda r: r["outcome"]["check"]["statements"][0]["shown"].update(recording_id=7_000)
        ),
        "A statement names recordings that are not ranked",
    ),
    "weights of another network": (
        with_weights(lambda w: w.update({"0.hidden.weight": np.zeros((64, 3), np.float32)})),
        "cannot be read",
    ),
}


@pytest.mark.parametrize("what", HOSTILE)
def test_a_hostile_file_is_refused_and_leaves_nothing(
    exported: tuple[Workplace, str, Path], elsewhere: Database, store: ArtifactStore, what: str
) -> None:
    _, run_id, path = exported
    change, message = HOSTILE[what]
    members = members_of(path)
    change(members)
    with pytest.raises(Invalid, match=message):
        brought(elsewhere, store, zipped(members), trusted=True)
    assert counts(elsewhere) == (0, 0)
    assert not store.exists(artifacts.path_of(run_id, "clone.safetensors"))


def test_members_of_other_names_are_never_read(
    exported: tuple[Workplace, str, Path],
    elsewhere: Database,
    store: ArtifactStore,
    tmp_path: Path,
) -> None:
    path = exported[2]
    outside = {"../../outside.txt": b"x", "/tmp/outside.txt": b"x", "policy/imitator.zip": b"x"}
    found = read_archive(zipped(members_of(path) | outside))
    import_run(elsewhere, store, found, trusted=True)
    files = {one.name for one in tmp_path.rglob("*") if one.is_file()}
    assert not files & {"outside.txt", "imitator.zip"}


def test_a_member_that_is_too_large_is_not_unpacked(
    exported: tuple[Workplace, str, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    members = members_of(exported[2])
    # A megabyte of these is a kilobyte of the file.
    members[RUN_FILE] = b" " * (run_archive.MAX_JSON_BYTES + 1)
    file = zipped(members)
    monkeypatch.setattr(zipfile.ZipFile, "open", lambda *_: pytest.fail("It was unpacked."))
    with pytest.raises(Invalid, match="too large: at most 16 MiB"):
        read_archive(file)


def test_a_file_whose_bytes_were_changed_is_refused(exported: tuple[Workplace, str, Path]) -> None:
    content = bytearray(exported[2].read_bytes())
    with zipfile.ZipFile(exported[2]) as archive:
        begin = archive.getinfo(NETWORKS["clone"]).header_offset
    content[begin + 1000 : begin + 2000] = bytes(1000)
    with pytest.raises(Invalid, match="not a run that Tril exported"):
        read_archive(io.BytesIO(content))


def test_two_members_of_one_name_are_refused(exported: tuple[Workplace, str, Path]) -> None:
    target = zipped(members_of(exported[2]))
    with zipfile.ZipFile(target, "a") as archive, pytest.warns(UserWarning, match="Duplicate"):
        archive.writestr(RUN_FILE, b"{}")
    with pytest.raises(Invalid, match="several of one name"):
        read_archive(target)


def test_a_file_that_is_no_zip_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "run.zip"
    for content in (b"", b"PK\x03\x04", b"x" * 1000):
        path.write_bytes(content)
        with pytest.raises(Invalid, match="not a run that Tril exported"):
            read_archive(path)
    with pytest.raises(Invalid, match="not a run that Tril exported"):
        read_archive(tmp_path / "nothing.zip")


def test_recordings_of_a_file_from_elsewhere_have_to_replay(
    exported: tuple[Workplace, str, Path], elsewhere: Database, store: ArtifactStore
) -> None:
    members = members_of(exported[2])
    lines = [json.loads(line) for line in members[RANKED].splitlines()]
    lines[0]["hashes"][0] = "0" * 16
    members[RANKED] = "".join(f"{json.dumps(line)}\n" for line in lines).encode()
    archive = read_archive(zipped(members))
    with pytest.raises(Invalid, match=r"Nothing was imported. Recording \d+ was refused"):
        import_run(elsewhere, store, archive)
    assert counts(elsewhere) == (0, 0)


def test_a_deleted_example_whose_name_was_taken_is_not_restored(
    shipped: str, elsewhere: Database, store: ArtifactStore
) -> None:
    found = open_example(elsewhere, store)
    assert found.run_id == shipped
    with elsewhere.writing() as session:
        behaviours.delete(session, behaviours.get(session, found.behaviour_id))
        behaviours.create(session, BEHAVIOUR_NAME)
    with pytest.raises(Conflict, match="Choose another name"):
        open_example(elsewhere, store)


IMPORT = """
import sys
from pathlib import Path
from tril.exchange.run_archive import read_archive
from tril.exchange.run_transfer import import_run
from tril.files.artifact_store import ArtifactStore
from tril.store.database import create_database
database, store, path = create_database(sys.argv[1]), ArtifactStore(sys.argv[2]), Path(sys.argv[3])
archive = read_archive(path)
print("ready", flush=True)
sys.stdin.readline()
print(import_run(database, store, archive, trusted=True).was_there)
"""


def importing(database: Database, store: ArtifactStore, path: Path) -> subprocess.Popen[str]:
    """Start a process that has read an archive and waits for a line to import it."""
    url = database.engine.url.render_as_string(hide_password=False)
    process = subprocess.Popen(
        [sys.executable, "-c", IMPORT, url, store.url, str(path)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "ready\n"
    return process


@pytest.mark.skipif(on_postgresql(), reason="the databases are SQLite's")
def test_of_two_processes_that_import_a_run_at_once_one_does(
    exported: tuple[Workplace, str, Path], elsewhere: Database, store: ArtifactStore
) -> None:
    _, run_id, path = exported
    processes = [importing(elsewhere, store, path) for _ in range(2)]
    for process in processes:
        assert process.stdin is not None
        process.stdin.write("\n")
        process.stdin.flush()
    results = [process.communicate(timeout=120)[0] for process in processes]
    assert sorted(results) == ["False\n", "True\n"]
    assert counts(elsewhere)[1] == 1
    with elsewhere.reading() as session:
        for row in artifacts.listing(session, run_id):
            assert len(store.get(row.path)) == row.size_bytes
    assert store.names(run_transfer.UNFINISHED) == []


def test_the_files_of_one_that_is_there_are_never_touched(
    exported: tuple[Workplace, str, Path],
    elsewhere: Database,
    store: ArtifactStore,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    _, run_id, path = exported
    archive = read_archive(path)
    forged = replace(archive, networks={**archive.networks, "clone": b"forged"})
    put_files = run_transfer._put_files

    def meanwhile(*arguments: Any) -> Any:
        monkeypatch.setattr(run_transfer, "_put_files", put_files)
        assert not import_run(elsewhere, store, archive, trusted=True).was_there
        return put_files(*arguments)

    monkeypatch.setattr(run_transfer, "_put_files", meanwhile)
    assert import_run(elsewhere, store, forged, trusted=True).was_there
    assert store.get(artifacts.path_of(run_id, "clone.safetensors")) == archive.networks["clone"]
    assert store.names(run_transfer.UNFINISHED) == []


def test_what_a_killed_import_leaves_is_removed_by_a_later_one(
    exported: tuple[Workplace, str, Path],
    elsewhere: Database,
    store: ArtifactStore,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    _, run_id, path = exported
    archive = read_archive(path)
    with monkeypatch.context() as patch:
        # As by a signal: nothing is tidied up.
        patch.setattr(store, "move_folder", lambda *_: (_ for _ in ()).throw(KeyboardInterrupt))
        patch.setattr(store, "remove_folder", lambda *_: None)
        with pytest.raises(KeyboardInterrupt):
            import_run(elsewhere, store, archive, trusted=True)
    assert counts(elsewhere) == (0, 0)
    assert not store.exists(artifacts.path_of(run_id, "clone.safetensors"))
    assert len(store.names(run_transfer.UNFINISHED)) == 1
    # It may still be running.
    run_transfer.remove_unfinished_imports(store)
    assert len(store.names(run_transfer.UNFINISHED)) == 1
    later = datetime.now(UTC) + timedelta(hours=2)
    run_transfer.remove_unfinished_imports(store, later)
    assert store.names(run_transfer.UNFINISHED) == []


@pytest.mark.parametrize("failing", ["_put_files", "_add_results"])
def test_an_import_for_which_there_is_no_room_leaves_nothing(
    exported: tuple[Workplace, str, Path],
    elsewhere: Database,
    store: ArtifactStore,
    monkeypatch: pytest.MonkeyPatch,
    failing: str,
) -> None:
    _, run_id, path = exported

    def full(*_: Any) -> Any:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(run_transfer, failing, full)
    with pytest.raises(OSError, match="No space left"):
        import_run(elsewhere, store, read_archive(path), trusted=True)
    assert counts(elsewhere) == (0, 0)
    assert store.names(artifacts.folder_of(run_id)) == []
    assert store.names(run_transfer.UNFINISHED) == []
