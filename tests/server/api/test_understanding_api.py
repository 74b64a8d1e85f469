"""What Tril understands of an order, over HTTP: learned, watched, said, answered."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from sqlalchemy import select
from starlette.testclient import TestClient

from server.vocabularies import VocabularyMaker
from server.vocabularies.maker import Making
from tests.server.clients import build_frontend, signed_in
from testsupport.finished_runs import make_finished_run
from testsupport.vocabularies import make_small_vocabulary
from testsupport.waiting import wait_until
from testsupport.workplace import Workplace, make_workplace
from tril.analysis.outcome import ToldStatement
from tril.demonstrators import play_randomly
from tril.games.base import Game
from tril.games.space_invaders import SPACE_INVADERS
from tril.store import recordings
from tril.store.models import AuditRow, RecordingRow, RecordingState, Source, ThingNameRow
from tril.store.training import runs

RANKING = "/api/behaviours/1/ranking"
N_GAMES = 6


@dataclass(frozen=True)
class Learned:
    """A server that has learned to see the game.

    Attributes:
        client: A client that is signed in.
        workplace: Its data folder.
        games: Recorded games, the longest first.
    """

    client: TestClient
    workplace: Workplace
    games: list[int]


@pytest.fixture(scope="module")
def learned(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Learned]:
    """Return a server that a module's tests share: they take back what they answer."""
    folder = tmp_path_factory.mktemp("learned")
    made = make_workplace(folder / "data")
    rng = np.random.default_rng(1)
    console = SPACE_INVADERS.make_console()
    played = [play_randomly(rng, console) for _ in range(N_GAMES)]
    console.close()
    played.sort(key=lambda one: one.replay.n_frames, reverse=True)
    with made.database.writing() as session:
        games = [
            recordings.add(session, 1, one.recording, one.replay, Source.VARIED).id
            for one in played
        ]
    with pytest.MonkeyPatch.context() as patch:
        make_small_vocabulary(made.settings.data, SPACE_INVADERS, patch)
        with signed_in(made, build_frontend(folder)) as client:
            yield Learned(client, made, games)
    made.database.close()


def ask(client: TestClient, tiers: list[list[int]]) -> dict[str, Any]:
    response = client.post(f"{RANKING}/understanding", json={"tiers": tiers})
    assert response.status_code == 200, response.text
    told: dict[str, Any] = response.json()
    return told


def understood(client: TestClient, games: list[int]) -> dict[str, Any]:
    """Return what is understood of games from best to worst, once they were watched."""
    tiers = [[key] for key in games]
    wait_until(lambda: ask(client, tiers)["state"] == "ready")
    return ask(client, tiers)


def answer(client: TestClient, statement: dict[str, Any], meant: bool | None) -> list[Any]:
    body = {"subjects": statement["subjects"], "sentence": statement["sentence"], "meant": meant}
    response = client.put(f"{RANKING}/answers", json=body)
    assert response.status_code == 200, response.text
    answers: list[Any] = response.json()
    return answers


def test_an_order_is_understood_saved_or_not_once_its_games_were_watched(
    learned: Learned,
) -> None:
    client, games = learned.client, learned.games
    first = ask(client, [[key] for key in games])
    assert first["state"] == "watching"
    assert 0 <= first["progress"] < 1
    told = understood(client, games)
    assert 3 <= len(told["statements"]) <= 5
    shares = [one["probability"] for one in told["statements"]]
    assert shares == sorted(shares, reverse=True)
    assert 0 < sum(shares) <= 1.001
    assert isinstance(told["is_sense"], bool)
    assert set(told["values"]) >= {str(key) for key in games}
    turned = understood(client, games[::-1])
    assert turned["statements"] != told["statements"]
    # Watched already: another order of the same games is understood at once.
    assert ask(client, [games[:3], games[3:]])["state"] == "ready"


def test_things_have_pictures(learned: Learned) -> None:
    client, games = learned.client, learned.games
    told = understood(client, games)
    urls = [url for one in told["statements"] for url in one["pictures"]]
    kind = f"{RANKING}/things/0.png"
    for url in [*urls, kind]:
        picture = client.get(url)
        assert picture.status_code == 200
        assert picture.content.startswith(b"\x89PNG")
        assert ("immutable" in picture.headers["Cache-Control"]) is (url != kind)
    assert client.get(f"{RANKING}/things/250.png").status_code == 404


def test_a_runs_statements_have_the_pictures_of_the_rank_page(learned: Learned) -> None:
    client, workplace = learned.client, learned.workplace
    told = understood(client, learned.games)["statements"]
    assert any(one["pictures"] for one in told)
    run_id = make_finished_run(workplace)
    with workplace.database.writing() as session:
        run = runs.get(session, run_id)
        assert run.outcome.check is not None
        statements = [ToldStatement.model_validate(one) for one in told]
        # A run of an earlier version, which does not say what its statements are about.
        statements.append(ToldStatement(sentence="FIRE held less", probability=0.1))
        check = run.outcome.check.model_copy(update={"statements": statements})
        run.outcome = run.outcome.model_copy(update={"check": check})
    shown = client.get(f"/api/runs/{run_id}/results").json()["check"]["statements"]
    assert [one["pictures"] for one in shown] == [*(one["pictures"] for one in told), []]


def test_a_runs_statements_have_no_pictures_before_there_are_any(
    workplace: Workplace, client: TestClient
) -> None:
    run_id = make_finished_run(workplace)
    told = ToldStatement(sentence="x", probability=0.9, subjects=["thing 12:7-8x10-10 x"])
    with workplace.database.writing() as session:
        run = runs.get(session, run_id)
        assert run.outcome.check is not None
        check = run.outcome.check.model_copy(update={"statements": [told]})
        run.outcome = run.outcome.model_copy(update={"check": check})
    (shown,) = client.get(f"/api/runs/{run_id}/results").json()["check"]["statements"]
    assert shown["pictures"] == []
    assert not (workplace.settings.data / "vocabularies").exists(), "none is made for a look"


def test_a_statement_about_pieces_can_be_answered(learned: Learned) -> None:
    statement = {"subjects": ["pieces gone x"], "sentence": "more shields cleared on the left"}
    assert len(answer(learned.client, statement, meant=True)) == 1
    assert answer(learned.client, statement, meant=None) == []


def test_a_statement_has_moments_of_a_better_and_a_worse_game(learned: Learned) -> None:
    client, games = learned.client, learned.games
    told = understood(client, games)
    differing = [one for one in told["statements"] if one["shown"]]
    assert differing
    for one in differing:
        assert one["contrast"] is not None
        for moment in (one["shown"], one["contrast"]):
            recording = client.get(f"/api/recordings/{moment['recording_id']}").json()
            assert moment["recording_id"] in games
            assert 0 < moment["n_frames"] <= 300
            assert moment["first_frame"] + moment["n_frames"] <= recording["n_frames"]


def test_things_are_named_with_what_may_be_meant_of_them(learned: Learned) -> None:
    named = learned.client.get(f"{RANKING}/things").json()
    first, *rest = named["things"]
    # As the game's measures name it.
    assert first["name"] == "the cannon"
    assert rest
    for thing in named["things"]:
        assert thing["meanings"]
        if thing["picture"]:
            assert learned.client.get(thing["picture"]).content.startswith(b"\x89PNG")
    sentences = [one["sentence"] for one in named["others"]]
    assert "the game lasting longer or shorter" in sentences
    # What is meant by pointing counts as "this is it" does.
    meant = first["meanings"][0]
    answer(learned.client, meant, True)
    told = understood(learned.client, learned.games)
    assert all(set(meant["subjects"]) <= set(one["subjects"]) for one in told["statements"])
    assert answer(learned.client, meant, None) == []


def test_a_thing_is_named_for_all_behaviours_of_its_game(learned: Learned) -> None:
    client, workplace = learned.client, learned.workplace
    things = client.get(f"{RANKING}/things").json()["things"]
    cannon, other = things[0]["key"], things[1]["key"]
    assert things[0]["given"] is None

    def rename(key: str, name: str) -> Any:
        return client.put(f"{RANKING}/things/names", json={"key": key, "name": name})

    named = rename(cannon, " tank ").json()["things"][0]
    assert (named["name"], named["given"]) == ("the tank", "tank")
    assert all("cannon" not in one["sentence"] for one in named["meanings"])
    elsewhere = client.get(RANKING.replace("1", "2") + "/things").json()["things"][0]
    assert elsewhere["name"] == "the tank"
    place = next(one for one in named["meanings"] if "left or right" in one["sentence"])
    answer(client, place, True)
    told = understood(client, learned.games)["statements"]
    assert all("the tank" in one["sentence"] for one in told)
    assert answer(client, place, None) == []
    for name in ("the tank", "Tank", "my  TANK"):
        assert rename(other, name).status_code == 409
    assert "is called “the tank”" in rename(other, "the tank").json()["detail"]
    assert rename("250:1-2x1-2", "nothing").status_code == 404
    # A name can always be removed.
    assert rename(other, "rock").status_code == 200
    assert rename(other, "").status_code == 200
    assert rename(cannon, "x" * 41).status_code == 422
    # Names like these would make a sentence unreadable.
    assert rename(cannon, "a\u202eb").status_code == 422
    assert rename(cannon, "").json()["things"][0]["name"] == "the cannon"
    with workplace.database.reading() as session:
        kept = session.scalars(select(ThingNameRow).order_by(ThingNameRow.id)).all()
    assert [row.name for row in kept] == ["tank", "rock", "", ""]


def test_things_in_sight_have_boxes_on_the_screen(learned: Learned) -> None:
    client, game = learned.client, learned.games[0]
    url = f"{RANKING}/things/in-sight"
    things = client.get(url, params={"recording_id": game, "step": 20}).json()
    kinds = {one["kind"] for one in client.get(f"{RANKING}/things").json()["things"]}
    assert things
    assert {one["kind"] for one in things} <= kinds
    areas = [one["width"] * one["height"] for one in things]
    assert areas == sorted(areas, reverse=True)
    for one in things:
        assert 0 <= one["left"] <= one["left"] + one["width"] <= 160
        assert 0 <= one["top"] <= one["top"] + one["height"] <= 210
    assert client.get(url, params={"recording_id": game, "step": 9_999}).status_code == 422
    assert client.get(url, params={"recording_id": 9_999, "step": 1}).status_code == 404


def test_things_of_a_game_that_was_not_learned_yet_are_none(client: TestClient) -> None:
    assert client.get(f"{RANKING}/things").status_code == 404


def test_the_game_that_would_tell_is_an_unranked_one(learned: Learned) -> None:
    client, games = learned.client, learned.games
    unranked, *ranked = games
    tiers = [[key] for key in ranked]
    understood(client, ranked)
    assert ask(client, tiers)["next_game"] is None, "nobody asked for it"

    def ask_next() -> dict[str, Any]:
        response = client.post(f"{RANKING}/understanding", json={"tiers": tiers, "with_next": True})
        told: dict[str, Any] = response.json()
        return told

    wait_until(lambda: ask_next()["state"] == "ready")
    told = ask_next()
    # The inference is of the ranked games alone.
    assert told["statements"] == ask(client, tiers)["statements"]
    assert str(unranked) not in told["values"]
    if (following := told["next_game"]) is not None:
        assert following["recording_id"] not in ranked
        assert 0 < following["other"] < len(told["statements"])
        shares = following["better_than"], following["better_than_by_other"]
        assert abs(shares[0] - shares[1]) >= 0.3


def test_few_games_wait_for_more_and_those_of_others_are_left_out(
    learned: Learned,
) -> None:
    client, games = learned.client, learned.games
    understood(client, games)
    assert ask(client, [[games[0]], [games[1]], [games[2]]])["state"] == "waiting"
    assert ask(client, [games])["state"] == "waiting", "one tier is no order"
    assert ask(client, [[9_999], [games[0]]])["state"] == "waiting"


def test_an_answer_counts_is_logged_and_can_be_taken_back(learned: Learned) -> None:
    client, games = learned.client, learned.games
    before = understood(client, games)
    second = before["statements"][1]
    assert answer(client, second, True) == [
        {"subjects": second["subjects"], "sentence": second["sentence"], "meant": True}
    ]
    assert client.get(f"{RANKING}/answers").json() == [
        {"subjects": second["subjects"], "sentence": second["sentence"], "meant": True}
    ]
    meant = ask(client, [[key] for key in games])
    assert [one["meant"] for one in meant["answers"]] == [True]
    assert all(set(second["subjects"]) <= set(one["subjects"]) for one in meant["statements"])
    answer(client, second, False)
    rejected = ask(client, [[key] for key in games])
    assert second["subjects"] not in [one["subjects"] for one in rejected["statements"]]
    assert answer(client, second, None) == []
    assert ask(client, [[key] for key in games])["statements"] == before["statements"]
    with learned.workplace.database.reading() as session:
        said = [row for row in session.query(AuditRow) if row.action == "answered a statement"]
    assert [row.details["meant"] for row in said][-3:] == [True, False, None]
    assert {row.player_name for row in said} != {None}


@pytest.mark.parametrize(
    "change",
    [{"subjects": []}, {"subjects": ["nonsense 1 x"]}, {"meant": 1}, {"sentence": "x" * 500}],
)
def test_answers_about_nothing_are_refused(client: TestClient, change: dict[str, Any]) -> None:
    body = {"subjects": ["memory 28 value"], "sentence": "memory 28 larger", "meant": True}
    assert client.put(f"{RANKING}/answers", json=body | change).status_code == 422


def test_it_says_how_far_it_is_with_learning_to_see_the_game(
    client: TestClient, monkeypatch: pytest.MonkeyPatch
) -> None:
    states = iter([Making(progress=0.4), Making(failed=True)])
    monkeypatch.setattr(VocabularyMaker, "vocabulary", lambda *_: next(states))
    told = ask(client, [[1], [2]])
    assert (told["state"], told["progress"]) == ("learning", 0.4)
    assert ask(client, [[1], [2]])["state"] == "failed"


def test_it_learns_to_see_a_game_while_games_are_kept(
    client: TestClient, workplace: Workplace, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked_for: list[str] = []

    def note(_: VocabularyMaker, game: Game) -> Making:
        asked_for.append(game.name)
        return Making()

    monkeypatch.setattr(VocabularyMaker, "vocabulary", note)

    def keep_game(behaviour: int) -> None:
        game = client.post("/api/games", json={"behaviour_id": behaviour}).json()["recording_id"]
        with workplace.database.writing() as session:
            session.get_one(RecordingRow, game).state = RecordingState.FINISHED
        kept = client.post(f"/api/recordings/{game}/keep")
        assert kept.json().get("state") == "kept", kept.text

    keep_game(1)
    assert asked_for == [], "its targets say what to look at"
    behaviour = client.post("/api/behaviours", json={"name": "Stay up", "game": "pong"}).json()
    keep_game(behaviour["id"])
    assert asked_for == ["pong"]
