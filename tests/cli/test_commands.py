"""The data commands, in process, on a data folder of their own."""

from __future__ import annotations

import html
import json
import zipfile
from pathlib import Path

import pytest
from typer.testing import CliRunner

from cli.main import app
from server.web import pages
from testsupport.databases import on_postgresql, settings_on
from testsupport.finished_runs import make_finished_run
from testsupport.workplace import Workplace
from trainer.reporting.run_report import write_report
from tril.analysis.blind import BlindAnswer
from tril.files.artifact_store import ArtifactStore
from tril.store import behaviours, players, processes
from tril.store.training import artifacts, blind_answers
from tril.vocabulary import making
from tril.vocabulary.facts import Vocabulary

DATA = Path(__file__).parents[1] / "data" / "column-1.jsonl"
runner = CliRunner()


def _run(*arguments: str, status: int = 0) -> str:
    done = runner.invoke(app, list(arguments))
    assert done.exit_code == status, done.output
    return done.output


def _judged(workplace: Workplace, run_id: str) -> str:
    """Let the owner judge one pair of a run blind; return what is said of it."""
    with workplace.database.writing() as session:
        owner = players.owner(session).id
        for answer in (BlindAnswer.EQUAL, BlindAnswer.ENDED):
            blind_answers.answer(session, run_id, owner, 1, 1, answer)
        result = blind_answers.result_of(session, run_id)
    assert result is not None
    assert "in 0.5 of 1 pair (5% to 95%)" in result.sentence
    return result.sentence


@pytest.fixture
def three(tmp_path: Path) -> Path:
    lines = DATA.read_text().splitlines()
    file = tmp_path / "three.jsonl"
    file.write_text("\n".join([lines[0], lines[5], "{}", lines[11]]) + "\n")
    return file


@pytest.mark.usefixtures("data_folder")
def test_recordings_are_imported_in_order_and_exported_again(three: Path, tmp_path: Path) -> None:
    output = _run("recordings", "import", str(three), "-b", "column-1", "--rank", status=1)
    assert "3 imported" in output
    assert "line 3 refused" in output
    (column_1, *_) = json.loads(_run("behaviours", "list", "--json"))
    assert (column_1["slug"], column_1["recordings"], column_1["ranked"]) == ("column-1", 3, 3)

    file = tmp_path / "out.jsonl"
    _run("recordings", "export", "-b", "column-1", "-o", str(file))
    given = [json.loads(line) for line in DATA.read_text().splitlines()]
    exported = [json.loads(line) for line in file.read_text().splitlines()]
    assert [e["actions"] for e in exported] == [given[i]["actions"] for i in (0, 5, 11)]
    assert [e["tier"] for e in exported] == [1, 2, 3]
    assert "3 of 3 recordings verify" in _run("recordings", "verify", "-b", "column-1")


@pytest.mark.usefixtures("data_folder")
def test_varied_games_are_borrowed_and_ranked_below_the_worst(three: Path) -> None:
    _run("recordings", "import", str(three), "-b", "column-1", "--rank", status=1)
    added = json.loads(_run("behaviours", "borrow", "column-2", "--count", "4", "--json"))
    assert (len(added["recordings"]), added["borrowed"]) == (4, 2)
    output = _run("behaviours", "borrow", "column-1", "--count", "2", "--below-worst")
    assert "added to column-1, ranked below the worst: 1 borrowed, 1 of varied play" in output
    listed = json.loads(_run("behaviours", "list", "--json"))
    ranked = {one["slug"]: (one["recordings"], one["ranked"]) for one in listed}
    assert (ranked["column-1"], ranked["column-2"]) == ((4, 5), (2, 0))
    assert "varied" in _run("recordings", "list", "-b", "column-1")


@pytest.mark.usefixtures("data_folder")
def test_a_training_without_a_ranking_is_refused() -> None:
    output = _run("train", "column-3", status=1)
    assert "at least two tiers" in output


@pytest.mark.usefixtures("data_folder")
def test_a_training_continues_from_a_run_that_has_an_imitator(workplace: Workplace) -> None:
    parent = workplace.make_run()
    command = ("train", "column-1", "--no-wait", "--continue-from")
    assert "has no imitator yet" in _run(*command, parent, status=1)
    with workplace.database.writing() as session:
        artifacts.save(session, parent, "imitator", "imitator.zip", "application/zip", 1)
    child = _run(*command, parent).split()[-1]
    assert workplace.run(child).parent_run_id == parent
    assert f"Continues run {parent}." in _run("runs", "show", child)
    listed = json.loads(_run("runs", "list", "--json"))
    assert {one["id"]: one["parent_run_id"] for one in listed} == {child: parent, parent: None}
    assert {line.split()[0] for line in _run("runs", "list").splitlines()} >= {child, parent}
    assert "no such training" in _run(*command, "missing", status=1)


@pytest.mark.usefixtures("data_folder")
def test_a_run_for_a_gpu_says_that_no_worker_has_one_until_one_has(workplace: Workplace) -> None:
    command = ("train", "column-1", "--no-wait", "--device", "gpu")
    assert "waits for a worker with a GPU; none is running" in _run(*command)
    with workplace.database.writing() as session:
        details = {"runs": [], "host": "lab-3", "cores": 8, "gpu": "NVIDIA T4"}
        processes.beat(session, "worker-0-abc", "worker", details)
    assert "waits for a worker" not in _run(*command)
    assert "worker-0-abc: running, lab-3, NVIDIA T4, 8 cores" in _run("status")
    (listed,) = map(json.loads, _run("status", "--json").splitlines())
    assert (listed["name"], listed["alive"], listed["details"]) == ("worker-0-abc", True, details)
    (one, _) = json.loads(_run("runs", "list", "--json"))
    assert one["device"] == "gpu"


@pytest.mark.usefixtures("data_folder")
def test_an_unknown_behaviour_names_those_there_are() -> None:
    output = _run("recordings", "list", "-b", "column-7", status=1)
    assert "column-6" in output


@pytest.mark.usefixtures("data_folder")
def test_a_behaviour_is_added_with_an_order_and_deleted() -> None:
    added = _run(
        "behaviours", "add", "Two corners", "--target", "1,1", "--target", "6,6", "--ordered"
    )
    assert "two-corners" in added
    entry = json.loads(_run("behaviours", "list", "--json"))[-1]
    assert (entry["target"], entry["ordered"]) == ([[0, 0], [5, 5]], True)
    _run("behaviours", "delete", "two-corners")
    assert "two-corners" not in _run("behaviours", "list", "--json")


@pytest.mark.usefixtures("data_folder")
def test_a_behaviour_is_added_with_measures_or_ready_made(tmp_path: Path) -> None:
    measures = ["--measure", '{"kind": "score", "at_least": 100}', "--measure", '{"kind": "alive"}']
    _run("behaviours", "add", "Hundred", *measures)
    file = tmp_path / "hundred.json"
    _run("behaviours", "export", "hundred", "-o", str(file))
    assert json.loads(file.read_text())["measures"] == [
        {"kind": "score", "at_least": 100},
        {"kind": "alive"},
    ]
    assert "stay-up" in _run("behaviours", "add", "--game", "pong", "--ready-made", "stay-up")
    entry = json.loads(_run("behaviours", "list", "--json"))[-1]
    assert (entry["slug"], entry["name"]) == ("stay-up", "Stay up")
    again = _run("behaviours", "add", "Up again", "--game", "pong", "--ready-made", "stay-up")
    assert "up-again" in again
    assert "stay-up" in _run("games", "show", "pong")


@pytest.mark.usefixtures("data_folder")
@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["A", "--measure", "score"], "as JSON"),
        (["A", "--measure", '{"kind": "speed"}'], "one of the kinds"),
        (["A", "--measure", '{"kind": "counter", "counter": "divers"}'], "it has shots"),
        (["--game", "pong", "--ready-made", "left-tunnel"], "it has stay-up"),
        (["--ready-made", "keep-left", "--ordered"], "added as it is"),
        ([], "needs a name"),
    ],
)
def test_measures_that_make_no_sense_are_refused(options: list[str], message: str) -> None:
    assert message in _run("behaviours", "add", *options, status=1)


@pytest.mark.usefixtures("data_folder")
def test_an_exported_behaviour_is_imported_as_a_new_one(three: Path, tmp_path: Path) -> None:
    _run("recordings", "import", str(three), "-b", "column-1", "--rank", status=1)
    file = tmp_path / "column-1.tril.json"
    output = _run("behaviours", "export", "column-1", "-o", str(file))
    assert "3 recordings, 1 revisions" in output
    outcome = json.loads(_run("behaviours", "import", str(file), "--name", "Again", "--json"))
    assert (outcome["slug"], outcome["n_recordings"], outcome["n_revisions"]) == ("again", 3, 1)
    entry = json.loads(_run("behaviours", "list", "--json"))[-1]
    assert (entry["slug"], entry["ranked"], entry["target"]) == (
        "again",
        3,
        [[row, 0] for row in range(6)],
    )
    assert "3 of 3 recordings verify" in _run("recordings", "verify", "-b", "again")


@pytest.mark.usefixtures("data_folder")
def test_a_file_of_something_else_is_no_behaviour(three: Path, tmp_path: Path) -> None:
    assert "tril recordings import" in _run("behaviours", "import", str(three), status=1)
    assert "can't be read" in _run("behaviours", "import", str(tmp_path / "no"), status=1)
    nowhere = str(tmp_path / "file" / "column-1.json")
    (tmp_path / "file").write_text("")
    assert "can't be written" in _run("behaviours", "export", "column-1", "-o", nowhere, status=1)


@pytest.mark.usefixtures("data_folder")
@pytest.mark.skipif(on_postgresql(), reason="a backup is a data folder with SQLite alone")
def test_a_backup_is_made_checked_and_worked_on(
    three: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert "nothing to back up" in _run("backup", str(tmp_path / "backup"), status=1)
    _run("recordings", "import", str(three), "-b", "column-1", "--rank", status=1)
    assert "Backed up" in _run("backup", str(tmp_path / "backup"))
    found = json.loads(_run("backup", str(tmp_path / "backup"), "--check", "--json"))
    assert (found["n_recordings"], found["n_runs"]) == (3, 0)
    assert "not empty" in _run("backup", str(tmp_path / "backup"), status=1)
    assert "Name the folder" in _run("backup", "--check", status=1)
    assert "not a Tril backup" in _run("backup", str(tmp_path), "--check", status=1)
    monkeypatch.setenv("TRIL_DATA", str(tmp_path / "backup"))
    assert "3 of 3 recordings verify" in _run("recordings", "verify", "-b", "column-1")


@pytest.mark.usefixtures("data_folder")
@pytest.mark.parametrize("starts", ["", "a", "1-", "2,2", "5-3"])
def test_starts_that_make_no_sense_are_refused(starts: str) -> None:
    assert "Expected" in _run("evaluate", "no-run", "--starts", starts, status=1)


@pytest.mark.usefixtures("data_folder")
def test_unknown_demonstrations_name_those_there_are() -> None:
    output = _run("demo", "-b", "column-1", "--demonstrations", "seven", status=1)
    assert "choose one of scripted, human, person-150, person-250, person-350, six," in output


@pytest.mark.usefixtures("data_folder")
def test_a_run_is_written_as_a_page_and_all_behaviours_as_a_gallery(
    workplace: Workplace, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("TRIL_DATA", str(workplace.settings.data))
    monkeypatch.setenv("TRIL_DATABASE_URL", workplace.settings.database_url)
    monkeypatch.setattr(pages, "share_parts", lambda: ("p{}", "void 0;"))
    file = tmp_path / "column-1.html"
    assert "has no finished run yet" in _run("runs", "share", "column-1", "-o", str(file), status=1)
    assert "has a finished run yet" in _run("gallery", str(tmp_path / "none"), status=1)
    run_id = make_finished_run(workplace)
    assert "Wrote" in _run("runs", "share", "column-1", "-o", str(file))
    assert file.with_suffix(".png").read_bytes().startswith(b"\x89PNG")
    own = tmp_path / "own.png"
    own.write_bytes(b"\x89PNG of mine")
    refusal = _run("runs", "share", run_id, "-o", str(own.with_suffix(".html")), status=1)
    assert "would overwrite" in refusal
    assert "choose another name" in " ".join(refusal.split())
    assert own.read_bytes() == b"\x89PNG of mine"
    assert not own.with_suffix(".html").exists()
    # A page that is written again replaces its own poster.
    assert "Wrote" in _run("runs", "share", "column-1", "-o", str(file))
    by_id = tmp_path / "again.html"
    _run("runs", "share", run_id, "-o", str(by_id))
    assert by_id.read_bytes() == file.read_bytes()
    assert "ends in .html" in _run("runs", "share", run_id, "-o", str(tmp_path / "x"), status=1)
    folder = tmp_path / "gallery"
    assert "Wrote" in _run("gallery", str(folder))
    names = {one.name for one in folder.iterdir()}
    assert names == {"index.html", "column-1.html", "column-1.png"}
    index = (folder / "index.html").read_text()
    assert 'href="column-1.html"' in index
    assert index.count("data:image/png;base64,") == 1
    assert (folder / "column-1.html").read_bytes() == file.read_bytes()
    assert _run("audit").count(f"exported run {run_id}") == 4
    with workplace.database.writing() as session:
        behaviours.get(session, workplace.behaviour_id).game = "gym:gone-v0"
    told = " ".join(_run("gallery", str(folder), status=1).split())
    assert "column-1 is left out" in told
    assert "'gone-v0'" in told
    assert "No behaviour of a game that is installed" in told


@pytest.mark.usefixtures("data_folder")
def test_a_run_is_exported_and_imported_where_it_is_not(
    workplace: Workplace, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run_id = make_finished_run(workplace)
    said = _judged(workplace, run_id)
    file = tmp_path / "run.zip"
    monkeypatch.setenv("TRIL_DATA", str(workplace.settings.data))
    monkeypatch.setenv("TRIL_DATABASE_URL", workplace.settings.database_url)
    assert "Wrote" in _run("runs", "export", run_id, "-o", str(file))
    with zipfile.ZipFile(file) as archive:
        assert said in html.unescape(archive.read("report.html").decode())
        assert said in archive.read("model-card.md").decode()
    store = ArtifactStore(workplace.settings.artifact_root)
    assert said in write_report(workplace.database, store, run_id, tmp_path / "page").read_text()
    assert "is here already" in _run("runs", "import", str(file))
    folder = tmp_path / "events"
    assert "Wrote" in _run("runs", "tensorboard", run_id, "-o", str(folder))
    assert [one.name.startswith("events.out.tfevents.") for one in folder.iterdir()] == [True]
    unfinished = _run("runs", "export", workplace.make_run(), "-o", str(file), status=1)
    assert "It can be taken away once it is done" in " ".join(unfinished.split())

    elsewhere = settings_on(tmp_path / "elsewhere")
    monkeypatch.setenv("TRIL_DATA", str(elsewhere.data))
    monkeypatch.setenv("TRIL_DATABASE_URL", elsewhere.database_url)
    output = _run("runs", "import", str(file), "--name", "Another")
    assert "was imported; it teaches Another (another)." in output
    assert said in " ".join(_run("runs", "show", run_id).split())
    assert json.loads(_run("runs", "show", run_id, "--json"))["blind"]["wins"] == 0.5
    (listed,) = json.loads(_run("runs", "list", "--json"))
    assert (listed["id"], listed["status"], listed["progress"]) == (run_id, "done", 1.0)
    (taught,) = (
        one for one in json.loads(_run("behaviours", "list", "--json")) if one["name"] == "Another"
    )
    assert (taught["recordings"], taught["ranked"], taught["perfect"], taught["runs"]) == (
        4,
        4,
        1,
        1,
    )
    again = tmp_path / "again.zip"
    _run("runs", "export", run_id, "-o", str(again))
    with zipfile.ZipFile(again) as archive:
        # An imported run has no files of stable-baselines3; they are made from its weights.
        assert {"policy/imitator.zip", "report.html"} <= set(archive.namelist())
    assert "is here already" in _run("runs", "import", str(again))
    assert "not a run that Tril exported" in " ".join(
        _run("runs", "import", str(DATA), status=1).split()
    )


@pytest.mark.usefixtures("data_folder")
@pytest.mark.parametrize(
    "arguments",
    [
        ("behaviours", "delete", "²"),
        ("behaviours", "delete", "9" * 5_000),
        ("behaviours", "add", "A", "--target", "9" * 5_000 + ",1"),
        ("behaviours", "add", "A", "--target", "1,1e9"),
        ("recordings", "list", "-b", "9" * 30),
        ("recordings", "import", "nothing.jsonl", "-b", "column-1"),
        ("recordings", "import", "/", "-b", "column-1"),
        ("behaviours", "import", "/"),
        ("runs", "import", "/"),
        ("runs", "import", "/dev/null"),
        ("train", "column-1", "--steps", "9" * 30),
        ("train", "column-1", "--training-seed", "9" * 30),
        ("train", "column-1", "--set", "evaluation.start_numbers=" + "1," * 100_000),
        ("train", "column-1", "--set", "policy.n_steps=" + "9" * 5_000),
        ("evaluate", "x", "--starts", "0-99999999999"),
        ("evaluate", "x", "--starts", "9" * 5_000),
        ("people", "role", "9" * 30, "researcher"),
        ("backup", "--check", "/"),
        ("backup", "/proc/nowhere/backup"),
        ("behaviours", "export", "column-1", "-o", "/proc/nowhere/a.json"),
        ("recordings", "export", "-b", "column-1", "-o", "/proc/nowhere/a.jsonl"),
    ],
    ids=lambda arguments: " ".join(arguments)[:40],
)
def test_arguments_that_make_no_sense_are_refused_with_a_sentence(
    arguments: tuple[str, ...],
) -> None:
    done = runner.invoke(app, list(arguments))
    assert done.exit_code in {1, 2}, done.output
    assert isinstance(done.exception, SystemExit), done.exception
    assert "Error" in done.output


@pytest.mark.usefixtures("data_folder")
def test_names_are_no_markup_of_the_terminal(tmp_path: Path) -> None:
    _run("behaviours", "add", "A [/bold] name")
    assert "A [/bold] name" in _run("behaviours", "list")
    lines = DATA.read_text().splitlines()
    file = tmp_path / "one.jsonl"
    file.write_text(json.dumps({**json.loads(lines[0]), "notes": "[/red]", "[/x]": 1}) + "\n")
    assert "[/x]" in _run("recordings", "import", str(file), "-b", "column-1")
    assert "[/red]" in _run("recordings", "list", "-b", "column-1")


def test_a_game_is_looked_at_beforehand(data_folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(making, "N_GAMES", 2)
    assert "kinds of things" in _run("games", "prepare", "pong")
    (kept,) = (data_folder / making.FOLDER).glob("*.npz")
    assert Vocabulary.load(kept).pool.shape[0] == 2
