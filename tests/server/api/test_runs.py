"""Trainings over HTTP: starting, stopping, curves, results."""

from __future__ import annotations

import pytest
from starlette.testclient import TestClient

from tests.trainings import HACKS, checked
from testsupport.libraries import replay_of
from testsupport.workplace import Workplace
from tril.analysis.outcome import Headline, RunOutcome
from tril.analysis.summary import summarise
from tril.files.artifact_store import ArtifactStore
from tril.games.behaviours import Score
from tril.recipes import RECIPES
from tril.stages import stages_of
from tril.store import recordings
from tril.store.models import RecordingRow, RunStatus, Source
from tril.store.training import artifacts, evaluations, leases, metrics, runs
from tril.store.training.evaluations import EvaluationKey

PERCENTILES = [{"reward": p / 10, "recording_id": 1, "step": p} for p in range(101)]


def test_the_recipes_say_what_they_cost(reader: TestClient) -> None:
    recipes = reader.get("/api/recipes").json()
    assert [recipe["name"] for recipe in recipes] == list(RECIPES)
    for recipe in recipes:
        assert recipe["steps_per_s"] > 0
        assert recipe["warm_up_steps"] == (
            12_000 if recipe["name"] in {"fast", "any", "gail"} else 0
        )
        assert not recipe["steps_per_s_measured"]
        assert recipe["values"]["policy"]["learning_rate"] == recipe["learning_rate"]


def test_a_run_is_made_with_what_the_page_chose_and_waits(
    client: TestClient, workplace: Workplace
) -> None:
    body = {
        "behaviour_id": 1,
        "recipe": "paper",
        "steps": 12_345,
        "learning_rate": 0.001,
        "training_seed": 7,
        "go_on_anyway": True,
    }
    answer = client.post("/api/runs", json=body)
    assert answer.status_code == 201
    run = answer.json()
    assert (run["status"], run["steps"], run["training_seed"]) == ("queued", 12_345, 7)
    assert run["learning_rate"] == run["recipe_values"]["policy"]["learning_rate"] == 0.001
    assert (run["n_ranked"], run["n_perfect"], run["ranking_revision"]) == (4, 1, 1)
    recipes = {recipe["name"]: recipe for recipe in client.get("/api/recipes").json()}
    assert run["stages"] == recipes["paper"]["stages"]
    assert [stage["name"] for stage in run["stages"]] == list(stages_of(example=False))
    assert all(stage["label"] and stage["summary"] for stage in run["stages"])
    assert run["progress"] == 0
    assert client.get(f"/api/runs/{run['id']}").json() == run
    assert client.get("/api/runs", params={"behaviour_id": 1}).json() == [run]
    assert client.get("/api/runs", params={"behaviour_id": 2}).json() == []
    assert client.get("/api/runs", params={"active": True}).json() == [run]
    assert client.get("/api/behaviours/1").json()["n_runs"] == 1


@pytest.mark.parametrize("recipe", ["fast", "paper"])
@pytest.mark.usefixtures("workplace")
def test_a_run_has_as_many_steps_as_its_recipe_proposes(client: TestClient, recipe: str) -> None:
    run = client.post("/api/runs", json={"behaviour_id": 1, "recipe": recipe}).json()
    assert run["steps"] == RECIPES[recipe].default_steps


def test_aliens_in_order_are_trained_on_for_longer(client: TestClient) -> None:
    slugs = {one["slug"]: one["id"] for one in client.get("/api/behaviours").json()}
    run = client.post("/api/runs", json={"behaviour_id": slugs["row-1"], "example": True}).json()
    proposed = {one["name"]: one for one in client.get("/api/recipes").json()}["fast"]
    assert run["steps"] == proposed["ordered_steps"] > proposed["default_steps"]


def test_a_ranking_that_does_not_suffice_says_what_to_do(
    client: TestClient, workplace: Workplace
) -> None:
    answer = client.post("/api/runs", json={"behaviour_id": 2})
    assert answer.status_code == 422
    assert "two tiers" in answer.json()["detail"]


@pytest.mark.usefixtures("workplace")
def test_what_does_not_exist_can_not_be_trained(client: TestClient) -> None:
    unknown = client.post("/api/runs", json={"behaviour_id": 1, "recipe": "secret"})
    assert unknown.status_code == 422
    assert "fast" in unknown.json()["detail"]
    assert client.post("/api/runs", json={"behaviour_id": 999}).status_code == 404


def test_a_run_continues_from_another_ones_imitator(
    client: TestClient, workplace: Workplace
) -> None:
    parent = workplace.make_run()
    new = {"behaviour_id": 1, "parent_run_id": parent}
    refused = client.post("/api/runs", json=new)
    assert refused.status_code == 409
    assert "has no imitator yet" in refused.json()["detail"]
    with workplace.database.writing() as session:
        artifacts.save(session, parent, "imitator", "imitator.zip", "application/zip", 1)
    child = client.post("/api/runs", json=new)
    assert child.status_code == 201, child.text
    assert child.json()["parent_run_id"] == parent
    assert client.get(f"/api/runs/{child.json()['id']}").json()["parent_run_id"] == parent
    assert client.get(f"/api/runs/{parent}").json()["parent_run_id"] is None
    for recipe in ("paper", "gail"):
        answer = client.post("/api/runs", json=new | {"recipe": recipe})
        assert answer.status_code == 422
        assert f"The recipe {recipe} can't continue" in answer.json()["detail"]
    unknown = {"behaviour_id": 1, "parent_run_id": "00000000-0000-4000-8000-000000000000"}
    assert client.post("/api/runs", json=unknown).status_code == 404
    assert client.post("/api/runs", json=new | {"parent_run_id": "x"}).status_code == 422


def test_a_run_takes_the_place_of_the_one_that_it_continues(
    client: TestClient, workplace: Workplace
) -> None:
    parent = workplace.make_run()
    with workplace.database.writing() as session:
        artifacts.save(session, parent, "imitator", "imitator.zip", "application/zip", 1)
    new = {"behaviour_id": 1, "parent_run_id": parent}
    assert client.post("/api/runs", json=new).status_code == 201
    assert client.get(f"/api/runs/{parent}").json()["status"] == "queued"
    for _ in range(2):  # The second time it is over already.
        assert client.post("/api/runs", json=new | {"cancel_parent": True}).status_code == 201
        assert client.get(f"/api/runs/{parent}").json()["status"] == "cancelled"


def test_a_run_is_cancelled_resumed_and_deleted(client: TestClient) -> None:
    run = client.post("/api/runs", json={"behaviour_id": 1}).json()
    path = f"/api/runs/{run['id']}"
    assert client.delete(path).status_code == 409
    assert client.post(f"{path}/resume").status_code == 409
    assert client.post(f"{path}/cancel").json()["status"] == "cancelled"
    assert client.post(f"{path}/resume").json()["status"] == "queued"
    assert client.post(f"{path}/cancel").json()["status"] == "cancelled"
    assert client.get("/api/runs", params={"active": True}).json() == []
    assert client.delete(path).status_code == 204
    assert client.get(path).status_code == 404
    assert client.get("/api/runs").json() == []


def test_a_run_is_named_and_annotated(client: TestClient) -> None:
    run = client.post("/api/runs", json={"behaviour_id": 1}).json()
    path = f"/api/runs/{run['id']}"
    assert (run["name"], run["notes"]) == ("", "")
    named = client.patch(path, json={"name": "  Bigger \t network "}).json()
    assert (named["name"], named["notes"]) == ("Bigger network", "")
    noted = client.patch(path, json={"notes": "Twice\nas wide.\n"}).json()
    assert (noted["name"], noted["notes"]) == ("Bigger network", "Twice\nas wide.")
    assert client.get("/api/runs").json() == [noted]
    assert client.patch(path, json={"name": ""}).json()["name"] == ""


@pytest.mark.parametrize(
    ("update", "wrong"),
    [
        ({"name": "x" * 81}, "Name can have at most 80 characters."),
        ({"notes": "x" * 4001}, "Notes can have at most 4000 characters."),
        (
            {"name": "a\0b"},
            "Name: character 2 is U+0000: a control character. Remove it, or type the text instead"
            " of pasting it.",
        ),
        ({"name": 3}, "Name has to be text."),
        ({"steps": 3}, "Steps is not known here."),
    ],
)
def test_a_name_or_notes_that_can_not_be_kept_say_why(
    client: TestClient, update: dict[str, object], wrong: str
) -> None:
    path = f"/api/runs/{client.post('/api/runs', json={'behaviour_id': 1}).json()['id']}"
    answer = client.patch(path, json=update)
    assert answer.status_code == 422
    assert answer.json()["detail"] == wrong
    assert client.get(path).json()["name"] == ""


def test_waiting_runs_say_their_place_in_the_queue(client: TestClient) -> None:
    first, second, third = (
        client.post("/api/runs", json={"behaviour_id": 1}).json()["id"] for _ in range(3)
    )

    def places() -> dict[str, int | None]:
        return {run["id"]: run["queue_position"] for run in client.get("/api/runs").json()}

    assert places() == {first: 1, second: 2, third: 3}
    client.post(f"/api/runs/{first}/cancel")
    assert places() == {first: None, second: 1, third: 2}
    client.post(f"/api/runs/{first}/resume")
    assert places() == {first: 1, second: 2, third: 3}


def test_a_deleted_run_is_restored_with_what_it_had(
    client: TestClient, workplace: Workplace
) -> None:
    run_id = fill_with_results(workplace)
    path = f"/api/runs/{run_id}"
    client.patch(path, json={"name": "Kept"})
    before = client.get(f"{path}/results").json()
    assert client.delete(path).status_code == 204
    assert client.get(path).status_code == 404
    assert client.patch(path, json={"name": "Gone"}).status_code == 404
    assert client.post(f"{path}/restore").json() == before["run"]
    assert client.get(f"{path}/results").json() == before
    assert client.post(f"{path}/restore").status_code == 200
    unknown = "00000000-0000-4000-8000-000000000000"
    assert client.post(f"/api/runs/{unknown}/restore").status_code == 404


def test_curves_come_in_pieces(client: TestClient, workplace: Workplace) -> None:
    run_id = workplace.make_run()
    with workplace.database.writing() as session:
        metrics.add(session, run_id, "reward", 1, {"loss": 0.7, "accuracy": 0.5})
        metrics.add(session, run_id, "reward", 2, {"loss": 0.6})
    first = client.get(f"/api/runs/{run_id}/metrics").json()
    assert first["series"] == {
        "reward": {"loss": [[1, 0.7], [2, 0.6]], "accuracy": [[1, 0.5]]},
    }
    with workplace.database.writing() as session:
        metrics.add(session, run_id, "imitator", 128, {"targets": 2.0})
    second = client.get(f"/api/runs/{run_id}/metrics", params={"after": first["last"]}).json()
    assert second["series"] == {"imitator": {"targets": [[128, 2.0]]}}
    third = client.get(f"/api/runs/{run_id}/metrics", params={"after": second["last"]}).json()
    assert (third["series"], third["last"]) == ({}, second["last"])


def fill_with_results(workplace: Workplace) -> str:
    """Make a finished run, its results written as a worker writes them."""
    run_id = workplace.make_run()
    games = {"imitator": (3, 1), "clone": (3, 2)}
    lease = workplace.lease(run_id)
    with workplace.database.writing() as session:
        played = recordings.get(session, workplace.ranked[0])
        for policy, (targets, strays) in games.items():
            for number, held_out in ((0, True), (1, False)):
                row = RecordingRow(
                    behaviour_id=1, run_id=run_id, source=Source.POLICY, state="kept"
                )
                recordings.fill(row, recordings.as_recording(played), replay_of(played))
                session.add(row)
                session.flush()
                key = EvaluationKey(policy, "greedy", number)
                evaluations.add(
                    session, run_id, key, row.id, held_out, 1.5, 0.5, Score(targets, strays, 0)
                )
        row_of_run = leases.finish_stage(session, lease, "evaluation", 1.0)
        found = [
            evaluations.figures_of(row)
            for row in evaluations.listing(session, run_id)
            if row.policy == "imitator" and row.held_out
        ]
        outcome = checked(
            {key: float(-key) for key in workplace.ranked},
            tau=0.8,
            confused=[{"better": 1, "worse": 2, "held_out": True}],
            passed=False,
            advice="It confuses tiers 1 and 2.",
        )
        assert outcome.check is not None
        headline = Headline(**outcome.check.figures, imitator=summarise(found), clone=None)
        row_of_run.outcome = outcome.updated_with(RunOutcome(headline=headline))
        for kind, suffix in (
            ("attention_map", ""),
            ("attention_red_blue", "-red-blue"),
            ("attention_frame", "-frame"),
        ):
            details = {
                "state": "maximum",
                "reward": 2.5,
                "recording_id": workplace.ranked[0],
                "step": 9,
            }
            name = f"attention-maximum{suffix}.png"
            artifacts.save(session, run_id, kind, name, "image/png", 3, details)
        name, every = "reward-percentiles.json", {"states": PERCENTILES}
        artifacts.save(session, run_id, "reward_percentiles", name, "application/json", 3, every)
        leases.end(session, lease, RunStatus.DONE)
    store = ArtifactStore(workplace.settings.artifact_root)
    store.put(artifacts.path_of(run_id, "attention-maximum.png"), b"png")
    return run_id


def test_results_are_shown_as_the_thesis_tables_them(
    client: TestClient, workplace: Workplace
) -> None:
    results = client.get(f"/api/runs/{fill_with_results(workplace)}/results").json()
    assert results["run"]["status"] == "done"
    assert results["run"]["progress"] == 1
    assert results["run"]["headline"]["imitator"]["targets"]["mean"] == 3
    check = results["check"]
    assert check["advice"] == "It confuses tiers 1 and 2."
    assert check["confused"] == [
        {
            "better_tier": 1,
            "worse_tier": 2,
            "held_out": True,
            "better": [workplace.ranked[0]],
            "worse": [workplace.ranked[1]],
            # A run of an earlier version has not counted.
            "n_right": None,
            "n_compared": None,
        }
    ]
    assert check["warning"] == ""
    assert [(row["tier"], row["predicted_return"]) for row in check["returns"]] == [
        (tier, -key) for tier, key in enumerate(workplace.ranked, start=1)
    ]
    (row,) = results["comparison"]
    assert (row["start_number"], row["winner"], row["held_out"]) == (0, "imitator", True)
    assert row["clone"]["recording"]["run_id"] == results["run"]["id"]
    # All others follow, be they held out or not.
    (further,) = results["further_comparison"]
    assert (further["start_number"], further["winner"], further["held_out"]) == (
        1,
        "imitator",
        False,
    )
    by_policy = {item["policy"]: item["summary"] for item in results["summaries"]}
    assert by_policy["clone"]["strays"] == {"mean": 2, "low": 2, "high": 2, "n": 1}
    assert results["best_demonstration"]["id"] == workplace.ranked[0]
    assert len(results["games"]) == 4
    assert results["verdict"]["sentence"].startswith("The imitator hits 3 of 6 targets")


def test_returns_are_shown_with_what_the_games_were_worth(
    client: TestClient, workplace: Workplace
) -> None:
    results = client.get(f"/api/runs/{fill_with_results(workplace)}/results").json()
    shown = {(one["player"], one["demonstrated"]): one for one in results["judged"]}
    assert list(shown) == [("demonstrator", True), ("imitator", False), ("clone", False)]
    learned_from = shown["demonstrator", True]["games"]
    assert {game["recording_id"] for game in learned_from} == set(workplace.ranked)
    assert shown["demonstrator", True]["measure"] == "predicted_return"
    assert all(game["predicted"] == -game["recording_id"] for game in learned_from)
    assert [game["true_quantity"] for game in shown["imitator", False]["games"]] == [2, 2]
    assert [game["true_quantity"] for game in shown["clone", False]["games"]] == [1, 1]
    assert shown["clone", False]["tau"] is None
    assert results["alarm"] is None


def test_a_training_whose_return_rises_alone_is_alarmed_while_it_goes(
    client: TestClient, workplace: Workplace
) -> None:
    run_id = workplace.make_run()
    returns = {number: 300.0 * place for place, number in enumerate(workplace.ranked)}
    with workplace.database.writing() as session:
        for name, points in HACKS["all the time"].curves().items():
            for step, value in points:
                metrics.add(session, run_id, "imitator", step, {name: value})
        runs.get(session, run_id).outcome = checked(returns, warning="Tiers 3 and 4.")
    results = client.get(f"/api/runs/{run_id}/results").json()
    assert results["run"]["status"] == "queued"
    assert "Watch the imitator" in results["alarm"]["message"]
    assert results["alarm"]["from_step"] < results["alarm"]["to_step"]
    assert results["check"]["warning"] == "Tiers 3 and 4."


def test_attention_maps_are_shown_with_their_frames_and_can_be_fetched(
    client: TestClient, workplace: Workplace
) -> None:
    run_id = fill_with_results(workplace)
    (shown,) = client.get(f"/api/runs/{run_id}/results").json()["attention"]
    assert (shown["state"], shown["step"]) == ("maximum", 9)
    picture = client.get(shown["map_url"])
    assert (picture.content, picture.headers["content-type"]) == (b"png", "image/png")
    assert client.get(f"/api/runs/{run_id}/results").json()["percentiles"] == PERCENTILES
    missing = client.get(shown["frame_url"])
    assert missing.status_code == 404
    assert len({shown["map_url"], shown["frame_url"], shown["red_blue_url"]}) == 3


def test_results_stay_readable_when_a_ranked_recording_is_deleted(
    client: TestClient, workplace: Workplace
) -> None:
    run_id = fill_with_results(workplace)
    before = client.get(f"/api/runs/{run_id}/results").json()
    client.delete(f"/api/recordings/{workplace.ranked[0]}")
    after = client.get(f"/api/runs/{run_id}/results").json()
    assert after["best_demonstration"]["deleted"]
    assert len(after["check"]["returns"]) == len(before["check"]["returns"])
    game = after["comparison"][0]["imitator"]["recording"]["id"]
    answer = client.delete(f"/api/recordings/{game}")
    assert answer.status_code == 409
    assert "training" in answer.json()["detail"]


def test_a_run_that_has_found_nothing_yet_has_empty_results(
    client: TestClient, workplace: Workplace
) -> None:
    results = client.get(f"/api/runs/{workplace.make_run()}/results").json()
    assert results["check"] is None
    assert results["comparison"] == results["games"] == results["attention"] == []
    assert results["percentiles"] == []
    assert results["verdict"] is None
    assert results["best_demonstration"]["id"] == workplace.ranked[0]


def test_rewards_say_what_to_do_while_the_inference_process_is_away(
    client: TestClient, workplace: Workplace
) -> None:
    run_id = workplace.make_run()
    answer = client.get(f"/api/runs/{run_id}/reward/{workplace.ranked[0]}")
    assert answer.status_code == 503
    assert "inference" in answer.json()["detail"]
