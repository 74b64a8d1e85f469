"""What version 0.1.0 stored opens with this version; tests/data/v0.1/README.md says what it is."""

from __future__ import annotations

import json
import shutil
import sqlite3
import tarfile
from collections import Counter
from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass
from datetime import timedelta
from pathlib import Path
from typing import Any

import pytest
from starlette.testclient import TestClient

from cli.workspace import migrate_databases
from server.play.rules import PlayRules
from server.web.security import is_token
from tests.server.clients import build_frontend, signed_in
from testsupport.libraries import unranked_in
from testsupport.workplace import Workplace
from trainer.policy.networks import load_policy
from trainer.reporting.digests import recipe_digest
from trainer.reporting.ledger import Ledger
from trainer.reporting.results_page import write_page
from trainer.reporting.run_entry import read_entry
from trainer.reward.model import RewardModel, predicted_return
from tril.exchange.backup import check_backup, make_backup
from tril.exchange.behaviour_transfer import import_behaviour
from tril.exchange.recording_transfer import import_recordings
from tril.games.space_invaders import SPACE_INVADERS
from tril.jobs import Jobs, prepare_queue
from tril.recipes import FORMER_NAMES, RECIPES, recipe_from_dict
from tril.recording import trajectory, verify
from tril.settings import Settings
from tril.store import behaviours, players, rankings, recordings
from tril.store.database import create_database
from tril.store.schema import check_schema, upgrade
from tril.store.training import runs

FILES = Path(__file__).parent / "data" / "v0.1"
EXPORTED = "second-column-in-order"
OWN = 8
"""Id of the behaviour that was exported."""

DEMO = ("fast", "Column 1", 0, 512)
ALARMED = ("fast", "Column 1", 1, 256)
GAIL = ("gail", "Column 1", 2, 256)
SIX = ("fast", "Row 1", 0, 256)
DONE = (DEMO, ALARMED, GAIL, SIX)
"""Recipe, behaviour, training seed and steps of the finished runs."""

GONE = {
    "dagger.expert_decay",
    "dagger.steps_per_iteration",
    "reward.disturbed_copies",
    "reward.disturbed_share",
    "reward.ensemble",
    "reward.fold_stride",
    "reward.free_share",
    "reward.perfect_share",
    "reward.weight_decay",
}
"""Values of recipes that there are no longer."""

FOR_EVER = timedelta(days=100_000)
NOTHING_ENDS = PlayRules(
    max_games=1, idle_after=FOR_EVER, abandoned_after=FOR_EVER, decided_after=FOR_EVER
)
"""Else the abandoned game ends and the undecided one is kept while the tests look at them."""

Json = dict[str, Any]


@dataclass(frozen=True)
class OldFolder:
    """A data folder of version 0.1.0 that this version has been started on.

    Attributes:
        workplace: The folder, upgraded.
        client: A client of a server on it.
        stored: What was in it before the upgrade, by run id: the rows of the runs.
    """

    workplace: Workplace
    client: TestClient
    stored: dict[str, Json]

    def get(self, path: str, **parameters: Any) -> Any:
        answer = self.client.get(f"/api{path}", params=parameters)
        assert answer.status_code == 200, answer.text
        return answer.json()

    def run(self, run: tuple[str, str, int, int]) -> Json:
        """The finished run of this recipe, behaviour, training seed and number of steps."""
        (found,) = (
            one
            for one in self.get("/runs")
            if (one["recipe"], one["behaviour_name"], one["training_seed"], one["steps"]) == run
        )
        return dict(found)

    def results(self, run: tuple[str, str, int, int]) -> Json:
        return dict(self.get(f"/runs/{self.run(run)['id']}/results"))


@pytest.fixture(scope="module")
def folders(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The data folder and the backup as they were, not to be changed."""
    folder = tmp_path_factory.mktemp("v0.1")
    with tarfile.open(FILES / "folders.tar.xz") as archive:
        archive.extractall(folder, filter="data")
    return folder


def start_on(data: Path) -> Workplace:
    """Do what every command does first on a data folder."""
    settings = Settings(data=data, learning_threads=1)
    database = create_database(settings.application_url)
    upgrade(database)
    check_schema(database)
    prepare_queue(settings)
    with database.reading() as session:
        tiers = rankings.current(session, OWN).tiers
    return Workplace(settings, database, OWN, tuple(key for tier in tiers for key in tier))


@pytest.fixture(scope="module")
def old(folders: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[OldFolder]:
    """A server on the upgraded data folder, which the tests that use it don't change."""
    folder = tmp_path_factory.mktemp("old")
    shutil.copytree(folders / "data", folder / "data")
    with closing(sqlite3.connect(folders / "data" / "tril.sqlite")) as before:
        before.row_factory = sqlite3.Row
        stored = {row["id"]: dict(row) for row in before.execute("SELECT * FROM runs")}
    workplace = start_on(folder / "data")
    with signed_in(workplace, build_frontend(folder), NOTHING_ENDS) as client:
        yield OldFolder(workplace, client, stored)
    workplace.database.close()


@pytest.fixture
def changed(folders: Path, tmp_path: Path) -> Iterator[tuple[Workplace, TestClient]]:
    """A server on an upgraded data folder that a test may change."""
    shutil.copytree(folders / "data", tmp_path / "data")
    workplace = start_on(tmp_path / "data")
    with signed_in(workplace, build_frontend(tmp_path), NOTHING_ENDS) as client:
        yield workplace, client
    workplace.database.close()


def test_the_database_is_kept_as_it_was_before_the_upgrade(folders: Path, tmp_path: Path) -> None:
    shutil.copytree(folders / "data", tmp_path / "data")
    settings = Settings(data=tmp_path / "data")
    migrate_databases(settings)
    (kept,) = settings.upgrade_copies.iterdir()
    with closing(sqlite3.connect(kept)) as before:
        (revision,) = before.execute("SELECT version_num FROM alembic_version").fetchone()
        runs_of_then = before.execute("SELECT count(*) FROM runs").fetchone()
    with closing(sqlite3.connect(folders / "data" / "tril.sqlite")) as original:
        assert original.execute("SELECT version_num FROM alembic_version").fetchone() == (revision,)
        assert original.execute("SELECT count(*) FROM runs").fetchone() == runs_of_then
    database = create_database(settings.application_url)
    check_schema(database)
    database.close()
    migrate_databases(settings)
    assert list(settings.upgrade_copies.iterdir()) == [kept]


def test_behaviours_are_there_with_what_belongs_to_them(old: OldFolder) -> None:
    shown = {one["slug"]: one for one in old.get("/behaviours")}
    assert [one["id"] for one in shown.values()] == list(range(1, 10)), "the deleted one is not"
    counts = {
        slug: (one["n_recordings"], one["n_ranked"], one["n_perfect"], one["n_runs"])
        for slug, one in shown.items()
    }
    assert counts["column-1"] == (14, 12, 2, 6)
    assert counts["row-1"] == (0, 0, 0, 1)
    assert counts[EXPORTED] == (18, 16, 4, 3)
    assert counts["play-nicely"] == (0, 0, 0, 0)
    assert sum(one["built_in"] for one in shown.values()) == 7
    own = shown[EXPORTED]
    assert (own["target"], own["ordered"]) == ([[row, 1] for row in range(6)], True)
    assert shown["play-nicely"]["target"] is None
    assert old.get("/player")["name"] == "Ada"


def test_a_persons_recordings_say_how_they_were_played(old: OldFolder) -> None:
    shown = {
        one["id"]: one for one in old.get(f"/behaviours/{OWN}/recordings", include=["deleted"])
    }
    assert len(shown) == 21
    assert {key for key, one in shown.items() if one["deleted"]} == {4, 20}
    assert {key for key, one in shown.items() if one["perfect"]} == {13, 14, 15, 18}
    branch = shown[16]
    assert branch["parent"] == {"recording_id": 17, "number": 17, "frame": 100}
    assert branch["notes"] == "Ran back by twenty frames \u2013 b\u00f6ser Fehler."
    assert (branch["slowest_percent"], branch["single_steps"]) == (50, 3)
    assert branch["latency"] == {
        "presses": 5,
        "p50_ms": 52.5,
        "p95_ms": 140.0,
        "frames_dropped": 0,
        "is_bad": True,
    }
    assert shown[19]["parent"] == {"recording_id": 18, "number": 18, "frame": 100}
    states = {key: old.get(f"/recordings/{key}")["state"] for key in (20, 21)}
    assert states == {20: "finished", 21: "finished"}
    assert old.get("/recordings/20")["deleted"]
    assert len(old.get("/recordings/17/course")["actions"]) == 120


def test_recordings_of_every_kind_replay(old: OldFolder) -> None:
    console = SPACE_INVADERS.make_console()
    with old.workplace.database.reading() as session:
        played = recordings.listing(session, OWN, with_deleted=True)
        rows = [row for row in played if row.source == "person" or row.id % 5 == 4]
        policies = recordings.listing(session, 1, with_policies=True)
        rows += [row for row in policies if row.run_id is not None][::9]
        for row in rows:
            hits = [(hit.row, hit.column) for hit in recordings.taken_of(row)]
            assert verify(recordings.as_recording(row), hits, console).n_cut == 0
    assert Counter(str(row.source) for row in rows) == {"scripted": 3, "person": 4, "policy": 6}


def test_the_ranking_has_its_history_and_undo_goes_on_from_it(
    changed: tuple[Workplace, TestClient],
) -> None:
    workplace, client = changed
    path = f"/api/behaviours/{OWN}/ranking"
    ranking = client.get(path).json()
    tiers = [[key] for key in (1, 2, 3, *range(6, 17))] + [[18, 19]]
    assert (ranking["revision"], ranking["tiers"]) == (8, tiers)
    assert ranking["n_pairs"] == 119
    assert unranked_in(client, f"/api/behaviours/{OWN}") == [17, 5]
    with workplace.database.reading() as session:
        revisions = rankings.history(session, OWN)
        names = players.names(session)
    assert [row.change for row in revisions] == [
        *["import", "edit", "edit", "undo", "undo", "redo", "deletion", "deletion"]
    ]
    assert {names[row.player_id or 0] for row in revisions} == {"Ada"}
    redone = client.post(f"{path}/redo", json={"base_revision": 8}).json()
    assert redone["tiers"][0] == [18], "the second edit is back"
    undone = client.post(f"{path}/undo", json={"base_revision": 9}).json()
    assert (undone["revision"], undone["tiers"][0]) == (10, [1])


def test_runs_stand_where_they_stood(old: OldFolder) -> None:
    shown = {one["id"]: one for one in old.get("/runs")}
    assert Counter((one["recipe"], one["status"]) for one in shown.values()) == {
        ("fast", "done"): 3,
        ("gail", "done"): 1,
        ("fast", "stopped"): 1,
        ("fast", "failed"): 1,
        ("fast", "cancelled"): 2,
        ("dagger", "cancelled"): 1,
        ("paper", "queued"): 1,
        ("gail", "queued"): 1,
    }
    for key, one in shown.items():
        stored = old.stored[key]
        assert (one["steps"], one["stage"]) == (stored["steps"], stored["stage"])
        assert one["message"] == stored["message"]
        assert one["progress"] == 1.0 or one["status"] != "done"
        if stored["snapshot"] is not None:
            tiers = json.loads(stored["snapshot"])["tiers"]
            assert one["n_ranked"] == sum(len(tier) for tier in tiers)


def test_recipes_have_the_values_that_they_were_started_with(old: OldFolder) -> None:
    with old.workplace.database.reading() as session:
        recipes = {row.id: recipe_from_dict(row.recipe) for row in runs.listing(session)}
    assert len(recipes) == 11
    for key, recipe in recipes.items():
        stored = _by_path(json.loads(old.stored[key]["recipe"]))
        now = _by_path(json.loads(json.dumps(recipe.to_dict())))
        assert {path: now[path] for path in stored.keys() & now.keys()} == {
            path: value for path, value in stored.items() if path in now
        }
        assert stored.keys() - now.keys() == GONE
        # What came later is off: death forfeit, openings, sticky actions, pretraining, frozen
        # convolutions, other steps for aliens in order.
        assert not any(now[path] for path in now.keys() - stored.keys())
    demo = recipes[old.run(DEMO)["id"]]
    assert (demo.policy.n_envs, demo.policy.n_steps, demo.policy.n_epochs) == (2, 32, 1)
    assert (demo.policy.kl_coef, demo.policy.clip_range) == (0.03, 0.2)
    assert (demo.policy.snapshot_steps, demo.evaluation.start_numbers) == ((256,), (0, 1))
    assert (demo.reward.method, demo.reward.updates) == ("fast", 4)
    assert demo.reward.pairs_per_update == 16
    assert {recipe.method for recipe in recipes.values()} == {"ppo", "dagger", "gail"}
    assert [r.policy.own_starts for r in recipes.values() if r.policy.own_starts] == [(2,)]
    # What was started as published is still the recipe of its name.
    paper = next(recipe for recipe in recipes.values() if recipe.name == "paper")
    assert recipe_digest(paper) == recipe_digest(RECIPES["paper"])


def _by_path(recipe: Json, part: str = "") -> Json:
    """What a recipe's values are, by today's names."""
    found: Json = {}
    for name, value in recipe.items():
        path = f"{part}{name}"
        found |= _by_path(value, f"{path}.") if isinstance(value, dict) else {path: value}
    return {FORMER_NAMES.get(path, path): value for path, value in found.items()}


@pytest.mark.parametrize(
    ("run", "tau", "pair_accuracy", "held_out_accuracy", "n_confused"),
    [
        (DEMO, 0.8181818181818182, 0.749, 0.8627450980392157, 18),
        (ALARMED, 0.8787878787878788, 0.667, 0.7843137254901961, 22),
        (GAIL, 0.8181818181818182, 0.7164, 0.8235294117647058, 23),
        (SIX, 1 / 3, 0.5984, 2 / 3, 11),
    ],
)
def test_the_check_of_a_finished_run_is_shown_as_it_is_stored(
    old: OldFolder,
    run: tuple[str, str, int, int],
    tau: float,
    pair_accuracy: float,
    held_out_accuracy: float,
    n_confused: int,
) -> None:
    results = old.results(run)
    check = results["check"]
    stored = json.loads(old.stored[results["run"]["id"]]["outcome"])
    assert (check["tau"], check["pair_accuracy"]) == (tau, pair_accuracy)
    assert check["held_out_accuracy"] == held_out_accuracy
    assert not check["passed"]
    assert check["advice"] == stored["check"]["advice"]
    assert len(check["confused"]) == n_confused
    assert {
        str(one["recording"]["id"]): one["predicted_return"] for one in check["returns"]
    } == stored["check"]["predicted_returns"]
    assert len(results["games"]) == 18
    assert [row["winner"] for row in results["comparison"]] == ["tie", "tie"]
    assert len(results["attention"]) == 4
    headline, kept = results["run"]["headline"], stored["headline"]
    assert headline["imitator"]["targets"] == kept["imitator"]["targets"]
    assert headline["clone"]["predicted_return"] == kept["clone"]["predicted_return"]
    assert headline["imitator"]["death_rate"]["mean"] == kept["imitator"]["hit_share"]["mean"] == 1


def test_runs_that_ended_early_show_how_far_they_came(old: OldFolder) -> None:
    by_status = {one["status"]: one for one in old.get("/runs")}
    stopped = old.get(f"/runs/{by_status['stopped']['id']}/results")
    assert stopped["check"]["tau"] == 0.04184137043778615
    assert len(stopped["check"]["confused"]) == 134
    assert stopped["run"]["message"] == stopped["check"]["advice"]
    assert [(one["player"], len(one["games"])) for one in stopped["judged"]] == [
        ("person", 3),
        ("demonstrator", 13),
    ]
    failed = old.get(f"/runs/{by_status['failed']['id']}/results")
    assert "'str' object cannot be interpreted" in failed["run"]["message"]
    assert failed["check"]["held_out_accuracy"] == 0.6263736263736264
    assert {one["kind"] for one in failed["artifacts"]} == {"reward_model", "clone"}


def test_evaluation_games_have_their_figures(old: OldFolder) -> None:
    games = {
        (one["policy"], one["action_selection"], one["start_number"]): one
        for one in old.results(DEMO)["games"]
    }
    assert len(games) == 18
    sampled = games["clone", "sampled", 3]
    assert (sampled["recording"]["targets"], sampled["recording"]["strays"]) == (4, 6)
    assert sampled["recording"]["n_steps"] == 209
    assert sampled["predicted_return"] == pytest.approx(83.486, abs=0.001)
    greedy = games["imitator", "greedy", 0]
    assert (greedy["recording"]["n_steps"], greedy["recording"]["end"]) == (108, "hit")
    course = old.get(f"/recordings/{games['imitator', 'sticky', 1]['recording']['id']}/course")
    assert course["conditions"]["action_selection"] == "sticky"


def test_the_curves_are_all_there_and_raise_the_alarm(old: OldFolder) -> None:
    lengths = {
        run: {
            stage: max(len(points) for points in curves.values())
            for stage, curves in old.get(f"/runs/{old.run(run)['id']}/metrics")["series"].items()
        }
        for run in DONE
    }
    assert lengths[DEMO] == {"reward": 4, "check": 2, "clone": 2, "imitator": 8}
    assert lengths[ALARMED]["imitator"] == 150
    alarm = old.results(ALARMED)["alarm"]
    assert (alarm["from_step"], alarm["to_step"]) == (200_704, 301_056)
    assert "rose from 507 to 575" in alarm["message"]
    assert [old.results(run)["alarm"] for run in (DEMO, GAIL, SIX)] == [None, None, None]


def test_stored_networks_answer_as_they_did(old: OldFolder) -> None:
    files = {one["kind"]: one for one in old.results(DEMO)["artifacts"]}
    folder = Path(old.workplace.settings.artifact_root) / "runs" / old.run(DEMO)["id"]
    for one in old.results(DEMO)["artifacts"]:
        content = old.client.get(one["url"]).content
        assert len(content) == one["size_bytes"] == (folder / one["name"]).stat().st_size
    model = RewardModel.load(folder / files["reward_model"]["name"])
    best = old.results(DEMO)["check"]["returns"][0]
    with old.workplace.database.reading() as session:
        row = recordings.get(session, best["recording"]["id"])
        replayed = trajectory(recordings.as_recording(row))
    found = predicted_return(model, replayed.observations)
    assert found == pytest.approx(best["predicted_return"], rel=1e-3)
    for kind in ("imitator", "clone"):
        policy = load_policy(folder / files[kind]["name"])
        assert policy.probabilities(replayed.observations[:8]).shape == (8, 6)


def test_finished_runs_are_results_for_the_ledger(old: OldFolder, tmp_path: Path) -> None:
    ledger = Ledger(tmp_path)
    for run in DONE:
        ledger.add(read_entry(old.workplace.database, old.run(run)["id"]))
    entries = Ledger(tmp_path).entries
    assert len(entries) == 4
    assert {entry.cell.demonstrations for entry in entries} == {"scripted", "six"}
    assert write_page(tmp_path).exists()


def test_the_queue_goes_on_with_what_was_in_it(changed: tuple[Workplace, TestClient]) -> None:
    workplace, client = changed
    jobs = Jobs(workplace.database, workplace.settings)
    jobs.reconcile()
    jobs.close()
    queued = [one for one in client.get("/api/runs").json() if one["status"] == "queued"]
    assert {one["recipe"] for one in queued} == {"paper", "gail"}
    stopped = next(o for o in client.get("/api/runs").json() if o["status"] == "stopped")
    for one in queued:
        assert client.post(f"/api/runs/{one['id']}/cancel").json()["status"] == "cancelled"
    for one in (*queued, stopped):
        resumed = client.post(f"/api/runs/{one['id']}/resume")
        if one["recipe"] == "paper":
            assert resumed.json()["status"] == "queued"
        else:
            # Its reward was learned by a method that is gone.
            assert resumed.status_code == 409
            assert "Start a new run" in resumed.json()["detail"]


def test_addresses_of_before_stay_good(folders: Path, old: OldFolder) -> None:
    stored = json.loads((folders / "data" / "secrets.json").read_text())
    assert is_token(old.workplace.settings.token_file, stored["token"])


def test_an_upgrade_repeated_changes_nothing(changed: tuple[Workplace, TestClient]) -> None:
    workplace, client = changed
    before = client.get("/api/runs").json()
    upgrade(workplace.database)
    prepare_queue(workplace.settings)
    assert client.get("/api/runs").json() == before


def test_a_backup_is_whole_and_can_be_worked_on(folders: Path, tmp_path: Path) -> None:
    found = check_backup(folders / "backup")
    assert (found.n_files, found.n_recordings, found.n_runs) == (101, 131, 12)
    shutil.copytree(folders / "backup", tmp_path / "data")
    workplace = start_on(tmp_path / "data")
    with signed_in(workplace, build_frontend(tmp_path), NOTHING_ENDS) as client:
        assert len(client.get("/api/runs").json()) == 11
        assert client.get(f"/api/behaviours/{OWN}/ranking").json()["n_pairs"] == 119
    workplace.database.close()
    again = make_backup(workplace.settings, tmp_path / "again")
    assert (again.n_recordings, again.n_runs) == (131, 12)


def test_a_behaviours_file_is_imported_with_its_history(workplace: Workplace) -> None:
    content = (FILES / f"{EXPORTED}.tril.json").read_bytes()
    outcome = import_behaviour(workplace.database, content)
    assert (outcome.slug, outcome.was_there) == (EXPORTED, False)
    assert (outcome.n_recordings, outcome.n_revisions, outcome.notices) == (19, 8, [])
    with workplace.database.writing() as session:
        behaviour = behaviours.by_slug(session, EXPORTED)
        rows = recordings.listing(session, behaviour.id)
        assert (len(rows), sum(row.perfect for row in rows)) == (18, 4)
        assert sum(row.parent_id is not None for row in rows) == 2
        played = [row.conditions["play"] for row in rows if row.source == "person"]
        assert max(len(one["presses"]) for one in played) == 5
        assert "Ada" in players.names(session).values()
        redone = rankings.redo(session, behaviour.id, 8)
        assert len(redone.tiers) == 16


def test_a_file_of_recordings_is_imported_in_its_order(workplace: Workplace) -> None:
    with workplace.database.writing() as session:
        behaviour_id = behaviours.create(session, "Empty").id
    with (FILES / f"{EXPORTED}.jsonl").open("rb") as file:
        outcome = import_recordings(workplace.database, behaviour_id, file, rank=True)
    assert (len(outcome.recording_ids), outcome.refusals) == (18, [])
    with workplace.database.reading() as session:
        tiers = rankings.current(session, behaviour_id).tiers
    assert [len(tier) for tier in tiers][:15] == [1] * 14 + [2]
