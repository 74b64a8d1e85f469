"""Limits on open games, and the end of games that stand still."""

from __future__ import annotations

import time
import uuid
from contextlib import ExitStack
from datetime import timedelta
from pathlib import Path

import httpx2
import pytest

from server.play.limits import GameLimits
from server.play.rules import DEFAULT_RULES, PlayRules
from server.play.wire.protocol import Close, Hello, Paused
from server.web.access import MAX_OPEN
from testsupport.live import LiveServer, live_server
from testsupport.waiting import wait_until
from testsupport.workplace import Workplace
from tril.settings import Settings
from tril.store import games, players, processes
from tril.store.models import GameRow

TRY_AGAIN_LATER = 1013

IDLE_AFTER_S = 1.4
RESTLESS = PlayRules(
    countdown=1,
    countdown_second_s=0.02,
    sweep_every_s=0.1,
    idle_after=timedelta(seconds=IDLE_AFTER_S),
    max_games=2,
)


def ask_for_a_game(live: LiveServer) -> httpx2.Response:
    return live.http.post("/api/games", json={"behaviour_id": 1})


def forget_lease(workplace: Workplace, game_id: str) -> None:
    """Make a game one that nobody has had for a while."""
    with workplace.database.writing() as session:
        row = games.get(session, game_id)
        row.lease_expires_at = row.created_at - games.OPEN_FOR


def test_no_more_games_are_begun_than_places_and_the_answer_says_what_to_do(
    workplace: Workplace,
) -> None:
    with live_server(workplace.settings.data, max_games=2) as live:
        first, _ = live.new_game(), live.new_game()
        refused = ask_for_a_game(live)
        assert refused.status_code == 503
        assert "All 2 places are taken" in refused.json()["detail"]
        assert "try again in a minute" in refused.json()["detail"]
        parent = live.http.get("/api/behaviours/1/recordings").json()[0]["id"]
        refused = live.http.post(f"/api/games/from/{parent}", json={"frame": 0})
        assert refused.status_code == 503
        with live.play(first) as player:
            player.begin()
            player.until_frame(3)
            player.stop()
        assert ask_for_a_game(live).status_code == 201


def test_a_player_has_only_so_many_games_open(workplace: Workplace) -> None:
    with live_server(workplace.settings.data, max_games_per_player=1) as live:
        live.new_game()
        refused = ask_for_a_game(live)
        assert refused.status_code == 503
        assert "1 of your games are open" in refused.json()["detail"]
        with workplace.database.writing() as session:
            for row in session.query(GameRow).all():
                games.get(session, row.id).recording.player_id = None
        assert ask_for_a_game(live).status_code == 201, "it is another player's now"


def test_games_watched_in_another_process_count(workplace: Workplace) -> None:
    with live_server(workplace.settings.data, max_games_per_player=3) as live:
        with workplace.database.writing() as session:
            person = players.owner(session).id
            processes.beat(session, "server-2", "server", {"watched": {str(person): 2}})
            processes.beat(session, "server-3", "server", {"watched": {str(person + 1): 9}})
        assert ask_for_a_game(live).status_code == 201
        refused = ask_for_a_game(live)
        assert refused.status_code == 503
        assert "3 of your games are open" in refused.json()["detail"]


def test_one_person_has_fewer_places_than_there_are() -> None:
    defaults = Settings(data=Path())
    limits = GameLimits.from_settings(defaults, DEFAULT_RULES.max_games)
    assert limits.per_player < limits.total
    assert defaults.max_queued_runs_per_player < defaults.max_queued_runs
    assert MAX_OPEN < defaults.max_connections_per_address < defaults.max_connections


def test_a_rewind_keeps_no_more_recordings_than_a_player_may_have(workplace: Workplace) -> None:
    with (
        live_server(workplace.settings.data, max_recordings_per_player=1) as live,
        live.playing(20) as player,
    ):
        player.say("rewind")
        player.until_frame(18)
        player.say("release")
        refused = player.until(Paused)
        assert "1 recordings of yours are stored" in refused.why


def test_a_game_that_was_left_needs_a_place_to_go_on(workplace: Workplace) -> None:
    with live_server(workplace.settings.data, max_games=1) as live:
        left = live.new_game()
        forget_lease(workplace, left["id"])
        present = live.new_game()
        with live.play(left) as player:
            assert player.close_code() == TRY_AGAIN_LATER
        with live.play(present) as player:
            player.begin()
            player.until_frame(3)
            player.stop()
        with live.play(left) as player:
            assert not player.begin().resumed
            player.until_frame(3)
            player.stop()


def test_a_full_process_lets_go_of_a_game_without_a_page(live: LiveServer) -> None:
    """The shared server plays at most four games."""
    left = live.new_game()
    with live.play(left) as player:
        player.begin()
        player.until_frame(20)
    with ExitStack() as pages:
        for _ in range(4):
            pages.enter_context(live.play(live.new_game())).until(Hello)
        with live.play(left) as one_too_many:
            assert one_too_many.close_code() == TRY_AGAIN_LATER
    with live.play(left) as player:
        hello = player.until(Hello)
        assert hello.resumed
        assert hello.frame >= 20
        player.stop()


def test_a_join_of_an_unknown_or_ended_game_takes_no_place(live: LiveServer) -> None:
    ended = live.new_game()
    with live.play(ended) as player:
        player.begin()
        player.stop()
    unknown = {"stream_path": f"/api/games/{uuid.uuid4()}/stream"}
    with ExitStack() as pages:
        for _ in range(4):
            pages.enter_context(live.play(live.new_game())).until(Hello)
        for game, code in ((unknown, Close.NO_SUCH_GAME), (ended, Close.GAME_OVER)):
            with live.play(game) as refused:
                assert refused.close_code() == code


def test_a_game_that_is_never_begun_ends(tmp_path: Path, workplace: Workplace) -> None:
    with live_server(workplace.settings.data, RESTLESS) as live:
        game = live.new_game()
        with live.play(game) as player:
            player.until(Hello)
            assert player.close_code() == Close.GAME_OVER
        wait_until(lambda: bool(live.recording(game["recording_id"])["deleted"]))
        with live.play(game) as player:
            assert player.close_code() == Close.GAME_OVER


def test_a_game_that_stays_paused_ends_as_an_unfinished_recording(workplace: Workplace) -> None:
    with live_server(workplace.settings.data, RESTLESS) as live:
        game = live.new_game()
        with live.play(game) as player:
            began = time.monotonic()
            player.begin()
            player.until_frame(90)
            player.say("pause")
            player.until(Paused)
            standing = player.frames[-1].frame
            assert time.monotonic() - began > IDLE_AFTER_S, "it was played for longer than that"
            assert player.close_code() == Close.GAME_OVER
        wait_until(lambda: live.recording(game["recording_id"])["state"] == "unfinished")
        recording = live.recording(game["recording_id"])
        assert (recording["n_frames"], recording["verification"]) == (standing, "verified")
        assert not recording["deleted"]


def test_a_game_that_is_joined_in_the_nick_of_time_is_not_ended(workplace: Workplace) -> None:
    with live_server(workplace.settings.data) as live:
        game = live.new_game()
        with live.play(game) as player:
            player.until(Hello)
            with workplace.database.writing() as session:
                late = games.acquire_abandoned(session, game["id"], "another process", timedelta(0))
                assert late is None
            player.say("ready")
            player.until_frame(3)
            assert player.stop().verification == "verified"


@pytest.mark.parametrize(("asked", "total"), [(0, 64), (5, 5)])
def test_there_are_as_many_places_as_processes_can_play(asked: int, total: int) -> None:
    settings = Settings(max_games=asked, server_processes=2)
    assert GameLimits.from_settings(settings, per_process=32).total == total
