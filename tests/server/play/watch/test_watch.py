"""Policies that play before a page: a real server, a real inference process, untrained networks."""

from __future__ import annotations

import threading
import uuid
from base64 import b64decode
from collections.abc import Iterator
from contextlib import AbstractContextManager
from datetime import timedelta
from pathlib import Path

import numpy as np
import pytest
from sqlalchemy import func, select

from server.play.rules import PlayRules
from server.play.session import clock
from server.play.wire.protocol import MAX_UNACKNOWLEDGED, Close
from testsupport.live import QUICK, LiveServer, live_server
from testsupport.space_invaders import Keys
from testsupport.waiting import wait_until
from testsupport.watching import Watcher, finished_run, running_inference, watching
from testsupport.workplace import TINY, Workplace, make_workplace
from trainer.explain.gradient import gradient_map
from trainer.explain.subject import ActionOdds
from trainer.policy.evaluation import beginnings, play
from trainer.policy.networks import Policy, load_policy
from trainer.reward.model import RewardModel
from trainer.runtime.answers import Models
from tril.files.artifact_store import ArtifactStore
from tril.games.atari.starts import TRAINING_IDLE_FRAMES
from tril.games.base import Opening, evaluation_beginning
from tril.games.space_invaders import SPACE_INVADERS
from tril.games.space_invaders.ends import Ending
from tril.play.agent import AgentGame
from tril.play.episode import Episode
from tril.recipes import with_values
from tril.recording import replay, verify
from tril.store import games, recordings
from tril.store.models import GameRow, RecordingRow, RecordingState
from tril.store.training import artifacts
from tril.store.training.evaluations import ActionSelection

START = 5


class Scene:
    """A server with an inference process beside it, and a finished run."""

    def __init__(self, made: Workplace, live: LiveServer, run_id: str) -> None:
        self.made = made
        self.live = live
        self.run_id = run_id

    def policy(self, kind: str) -> Policy:
        with self._file(kind) as path:
            return load_policy(path)

    def reward_model(self) -> RewardModel:
        with self._file("reward_model") as path:
            return RewardModel.load(path)

    def _file(self, kind: str) -> AbstractContextManager[Path]:
        store = ArtifactStore(self.made.settings.artifact_root)
        return artifacts.local_file(self.made.database, store, self.run_id, kind)


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Scene]:
    made = make_workplace(tmp_path_factory.mktemp("watch") / "data")
    run_id = finished_run(made, with_values(TINY, {"evaluation.openings": True}))
    with live_server(made.settings.data) as live, running_inference(made):
        yield Scene(made, live, run_id)
    made.database.close()


def n_rows(made: Workplace) -> tuple[int, int]:
    with made.database.reading() as session:
        return tuple(  # type: ignore[return-value]
            session.scalar(select(func.count()).select_from(table))
            for table in (GameRow, RecordingRow)
        )


def files_of(made: Workplace) -> set[Path]:
    return {path for path in made.settings.data.rglob("*") if ".sqlite" not in path.name}


def watch_to_the_end(watcher: Watcher) -> None:
    watcher.until("hello")
    watcher.say("play")
    watcher.until("finished")


@pytest.mark.parametrize("selection", ["greedy", "sampled", "sticky"])
def test_a_watched_game_is_the_one_of_the_evaluation(
    scene: Scene, selection: ActionSelection
) -> None:
    recipe = with_values(TINY, {"evaluation.openings": True}).evaluation
    begin = beginnings(SPACE_INVADERS, recipe, [START])
    (expected,) = play(
        SPACE_INVADERS,
        scene.policy("imitator"),
        begin,
        selection,
        model=scene.reward_model(),
        n_processes=1,
    )
    with watching(scene.live.settings, scene.run_id, f"imitator.{selection}", start=START) as page:
        watch_to_the_end(page)
    ended = page.of("ended")[0]
    assert ended["frame"] == expected.recording.n_frames
    assert ended["reason"] == str(expected.end)
    hits = [(hit["row"], hit["column"], hit["frame"]) for hit in ended["hits"]]
    assert hits == [(hit.row, hit.column, hit.frame) for hit in expected.taken]
    assert [hit["frame"] for hit in page.of("hit")] == [hit.frame for hit in expected.taken]
    opening = begin[0]
    assert isinstance(opening, Opening)
    first = 4 * len(opening.actions)
    assert page.said[0]["frame"] == first
    decided = {one["frame"]: one["action"] for one in page.of("decision")}
    executed = expected.recording.actions
    if selection != "sticky":
        assert decided == {at: executed[at] for at in range(first, len(executed), 4)}
    assert expected.rewards is not None
    assert len(page.of("reward")) > 2
    levels = scene.reward_model().level(expected.rewards)
    for one in page.of("reward"):
        own = levels[(one["frame"] - first) // 4]
        assert one["level"] == pytest.approx(own, rel=1e-3, abs=1e-4)
    assert all(
        sum(one["probabilities"]) == pytest.approx(1, abs=1e-3) for one in page.of("decision")
    )


def test_watched_games_are_paused_after_the_machine_slept(
    scene: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    with watching(scene.live.settings, scene.run_id, "imitator.greedy", start=START) as page:
        first = page.until("hello")["frame"]
        page.say("play")
        page.until_frame(first + 8)
        elapsed_s = clock._elapsed_s
        monkeypatch.setattr(clock, "_elapsed_s", lambda: elapsed_s() + 60)
        assert "stood still for 60 s" in page.until("paused")["why"]
        standing = page.frames[0][-1].frame
        page.say("play")
        page.until_frame(standing + 8)


def test_the_screens_are_those_of_the_evaluations_recording(scene: Scene) -> None:
    recipe = with_values(TINY, {"evaluation.openings": True}).evaluation
    (expected,) = play(
        SPACE_INVADERS,
        scene.policy("clone"),
        beginnings(SPACE_INVADERS, recipe, [3]),
        "greedy",
        n_processes=1,
    )
    with watching(scene.live.settings, scene.run_id, "clone.greedy", start=3) as page:
        watch_to_the_end(page)
    found: dict[int, np.ndarray[tuple[int, ...], np.dtype[np.uint8]]] = {}

    def look(episode: Episode) -> None:
        found[episode.frame] = episode.console.screen()

    replay(expected.recording, on_frame=look)
    last = expected.recording.n_frames
    compared = [frame for frame in page.screens[0] if frame < last]
    assert len(compared) > 0.9 * (last - page.said[0]["frame"])
    for frame in compared:
        np.testing.assert_array_equal(page.screens[0][frame], found[frame])


def test_games_side_by_side_begin_alike_and_keep_in_step(scene: Scene) -> None:
    players = ("imitator.greedy", "clone.greedy", "imitator.sampled", "imitator.sampled")
    with watching(scene.live.settings, scene.run_id, *players, draw=7) as page:
        hello = page.until("hello")
        assert hello["start_number"] is None
        assert hello["start"]["idle_frames"] in TRAINING_IDLE_FRAMES
        page.say("play")
        page.until_frame(hello["frame"] + 40)
        page.say("pause")
        page.until("paused")
        standing = {frames[-1].frame for frames in page.frames.values()}
    assert len(page.frames) == 4
    first = page.screens[0][hello["frame"]]
    assert all((screens[hello["frame"]] == first).all() for screens in page.screens.values())
    assert len(standing) == 1, "all lanes stand at the same frame"
    actions = [[one["action"] for one in page.of("decision", lane)] for lane in range(4)]
    assert actions[2] != actions[3], "equal players draw different actions"


def test_another_take_repeats_a_greedy_game_and_draws_a_sampled_one_anew(scene: Scene) -> None:
    played = []
    for take in (1, 2):
        players = ("imitator.greedy", "imitator.sampled")
        with watching(scene.live.settings, scene.run_id, *players, start=1, take=take) as page:
            hello = page.until("hello")
            page.say("play")
            page.until_frame(hello["frame"] + 60)
            played.append([[o["action"] for o in page.of("decision", n)][:12] for n in (0, 1)])
    assert played[0][0] == played[1][0]
    assert played[0][1] != played[1][1]


def test_pausing_and_single_steps_of_four_frames(scene: Scene) -> None:
    with watching(scene.live.settings, scene.run_id, "imitator.greedy", start=0) as page:
        first = page.until("hello")["frame"]
        page.say("step")
        assert page.until("paused")["why"] == ""
        assert page.frames[0][-1].frame == first + 4
        page.say("speed", percent=25)
        page.say("play")
        page.until_frame(first + 6)
        page.say("pause")
        page.until("paused")
        standing = page.frames[0][-1].frame
        page.say("step")
        page.until("paused")
        stepped = page.frames[0][-1].frame
        assert stepped % 4 == 0
        assert 0 < stepped - standing <= 4
        page.say("step")
        page.until("paused")
        assert page.frames[0][-1].frame == stepped + 4


def test_attention_is_that_of_the_state_on_the_screen(scene: Scene) -> None:
    with watching(
        scene.live.settings, scene.run_id, "imitator.greedy", "clone.greedy", start=0
    ) as page:
        first = page.until("hello")["frame"]
        page.say("attention", network="policy")
        found = [page.until("attention") for _ in range(2)]
        page.say("step")
        page.until("paused")
        page.say("attention", network="reward")
        # Maps of the policy for the step may come first.
        reward = page.until("attention", lambda message: message["action"] is None)
        page.say("attention", network=None)
    begun = AgentGame(SPACE_INVADERS.make_console(), Ending.HIT)
    begun.begin(evaluation_beginning(SPACE_INVADERS.starts, 0, True))
    for kind, message in zip(("imitator", "clone"), found, strict=True):
        policy = scene.policy(kind)
        subject = ActionOdds.of_choice(policy, begun.observation)
        expected = gradient_map(subject, begun.observation).sum(0)
        assert (message["frame"], message["action"]) == (first, subject.action)
        assert message["most"] == pytest.approx(float(expected.max()), rel=1e-4)
        shares = np.frombuffer(b64decode(message["shares"]), np.uint8).reshape(84, 84)
        assert np.abs(shares - 255 * expected / expected.max()).max() <= 1.0
    assert reward["frame"] == first + 4
    assert reward["most"] > 0


def test_attention_of_a_game_that_plays_keeps_up_and_can_be_switched_off(scene: Scene) -> None:
    with watching(scene.live.settings, scene.run_id, "imitator.greedy", start=0) as page:
        first = page.until("hello")["frame"]
        page.say("attention", network="reward")
        page.say("play")
        page.until_frame(first + 120)
        frames = [one["frame"] for one in page.of("attention")]
        assert frames == sorted(set(frames))
        assert len(frames) >= 5
        page.say("attention", network=None)
        page.say("pause")
        page.until("paused")
        n_before = len(page.of("attention"))
        page.say("step")
        page.until("paused")
        assert len(page.of("attention")) == n_before


def test_what_is_only_watched_leaves_nothing_behind(scene: Scene) -> None:
    rows, files = n_rows(scene.made), files_of(scene.made)
    with watching(scene.live.settings, scene.run_id, "imitator.greedy", "clone.sticky") as page:
        page.until("hello")
        page.say("play")
        page.until_frame(20)
    limits = scene.live.services.limits
    wait_until(lambda: limits.watched.n_open == 0)
    assert n_rows(scene.made) == rows
    assert files_of(scene.made) == files


def test_a_person_takes_over_and_the_recording_holds_all_from_the_start(scene: Scene) -> None:
    with watching(scene.live.settings, scene.run_id, "clone.greedy", "imitator.greedy") as page:
        first = page.until("hello")["frame"]
        page.say("play")
        page.until_frame(first + 50)
        page.say("take_over", lane=1)
        taken = page.until("taken")
        assert page.close_code() == Close.GAME_OVER
    standing = page.frames[1][-1].frame
    decided = [one["action"] for one in page.of("decision", 1)]
    assert (taken["lane"], taken["behaviour_id"]) == (1, 1)
    path = {"stream_path": f"/api/games/{taken['game_id']}/stream"}
    with scene.live.play(path) as player:
        player.hold(Keys.RIGHT | Keys.FIRE)
        hello = player.begin()
        assert (hello.frame, hello.resumed) == (standing, True)
        player.until_frame(standing + 30)
        ended = player.stop()
    assert ended.verification == "verified"
    row = scene.live.row(ended.recording_id)
    assert (row.source, row.run_id, row.parent_id) == ("person", None, None)
    assert list(row.actions[first:standing:4]) == decided[: len(row.actions[first:standing:4])]
    assert set(row.actions[standing + 2 : standing + 30]) == {4}, "right and fire"
    kept = scene.live.http.post(f"/api/recordings/{ended.recording_id}/keep").json()
    assert kept["begun_by"] == {
        "run_id": scene.run_id,
        "policy": "imitator",
        "action_selection": "greedy",
        "frames": standing,
    }


def test_a_game_taken_over_and_left_at_once_is_dropped(scene: Scene) -> None:
    with watching(scene.live.settings, scene.run_id, "clone.greedy") as page:
        first = page.until("hello")["frame"]
        page.say("play")
        page.until_frame(first + 8)
        page.say("take_over", lane=0)
        taken = page.until("taken")
    with scene.made.database.writing() as session:
        row = games.acquire(session, taken["game_id"], "nobody", "")
        games.end(session, row.id, row.epoch, RecordingState.UNFINISHED, None)
        recording_id = row.recording_id
    assert scene.live.recording(recording_id)["deleted"]


def test_without_an_inference_process_the_page_is_told_and_may_try_again(
    workplace: Workplace,
) -> None:
    run_id = finished_run(workplace)
    with (
        live_server(workplace.settings.data) as live,
        watching(live.settings, run_id, "imitator.greedy") as page,
    ):
        page.until("hello")
        page.say("play")
        assert "inference process is not running" in page.until("paused")["why"]
        with running_inference(workplace):
            page.say("play")
            page.until_frame(10)


def test_a_policy_whose_file_is_gone_is_told(workplace: Workplace) -> None:
    run_id = finished_run(workplace)
    store = ArtifactStore(workplace.settings.artifact_root)
    store.remove_folder(artifacts.folder_of(run_id))
    with (
        running_inference(workplace),
        live_server(workplace.settings.data) as live,
        watching(live.settings, run_id, "imitator.greedy") as page,
    ):
        page.until("hello")
        page.say("play")
        assert "not in the artifact store" in page.until("paused")["why"]


@pytest.mark.parametrize(
    ("players", "query", "why", "code"),
    [
        ((), {}, "Expected 1 to 4 players", Close.BAD_MESSAGE),
        (("imitator.greedy",) * 5, {}, "Expected 1 to 4 players", Close.BAD_MESSAGE),
        (("king.greedy",), {}, "no player 'king.greedy'", Close.BAD_MESSAGE),
        (("clone.greedy",), {"start": 32}, "Expected a start from 0 to 31", Close.BAD_MESSAGE),
        (("clone.greedy",), {"draw": "-1"}, "Expected a draw", Close.BAD_MESSAGE),
        (("clone.greedy",), {"take": "x"}, "Expected a take", Close.BAD_MESSAGE),
    ],
)
def test_a_bad_request_is_refused_with_a_sentence(
    scene: Scene, players: tuple[str, ...], query: dict[str, int | str], why: str, code: Close
) -> None:
    with watching(scene.live.settings, scene.run_id, *players, **query) as page:
        assert why in page.until("refused")["why"]
        assert page.close_code() == code


def test_runs_without_a_policy_are_refused_with_a_sentence(workplace: Workplace) -> None:
    queued, half = workplace.make_run(), finished_run(workplace, policies=("clone",))
    with live_server(workplace.settings.data) as live:
        for run_id, why in (
            (queued, "has no imitator yet"),
            (half, "ended before its imitator was trained"),
            (str(uuid.uuid4()), "no such"),
        ):
            with watching(live.settings, run_id, "imitator.greedy") as page:
                assert why in page.until("refused")["why"]
                assert page.close_code() == Close.NO_SUCH_GAME
        assert live.services.limits.watched.n_open == 0


def test_watched_games_count_against_the_limits(workplace: Workplace) -> None:
    run_id = finished_run(workplace)
    with live_server(workplace.settings.data, max_games=3) as live:
        with watching(live.settings, run_id, "imitator.greedy", "clone.greedy") as page:
            page.until("hello")
            live.new_game()
            refused = live.http.post("/api/games", json={"behaviour_id": 1})
            assert refused.status_code == 503
            assert "All 3 places are taken" in refused.json()["detail"]
            with watching(live.settings, run_id, "clone.greedy") as another:
                assert "All 3 places" in another.until("refused")["why"]
                assert another.close_code() == Close.TRY_AGAIN_LATER
        wait_until(lambda: live.services.limits.watched.n_open == 0)
        live.new_game()


def test_a_process_that_plays_all_it_can_refuses_to_show_more(scene: Scene) -> None:
    four = ("imitator.greedy",) * QUICK.max_games
    with watching(scene.live.settings, scene.run_id, *four) as page:
        page.until("hello")
        with watching(scene.live.settings, scene.run_id, "clone.greedy") as another:
            assert "as many games as it can" in another.until("refused")["why"]
        with scene.live.play(scene.live.new_game()) as player:
            assert player.close_code() == Close.TRY_AGAIN_LATER


def test_a_page_that_goes_on_to_other_games_waits_for_the_places_of_the_old(scene: Scene) -> None:
    four = ("imitator.greedy",) * QUICK.max_games
    with watching(scene.live.settings, scene.run_id, *four) as page:
        page.until("hello")
        with watching(scene.live.settings, scene.run_id, *four) as another:
            with pytest.raises(TimeoutError):
                # It waits, and is not refused.
                another.next(timeout_s=0.5)
            page.socket.close()
            another.until("hello")


def test_an_unknown_run_is_looked_up_before_places_are_taken(scene: Scene) -> None:
    four = ("imitator.greedy",) * QUICK.max_games
    with watching(scene.live.settings, scene.run_id, *four) as page:
        page.until("hello")
        with watching(scene.live.settings, str(uuid.uuid4()), "clone.greedy") as another:
            assert "no such" in another.until("refused")["why"]
            assert another.close_code() == Close.NO_SUCH_GAME


def test_a_game_that_stays_paused_is_closed(workplace: Workplace) -> None:
    run_id = finished_run(workplace)
    rules = PlayRules(sweep_every_s=0.05, idle_after=timedelta(seconds=0.3), max_games=2)
    with (
        live_server(workplace.settings.data, rules) as live,
        watching(live.settings, run_id, "imitator.greedy") as page,
    ):
        page.until("hello")
        assert page.close_code() == Close.GAME_OVER
        wait_until(lambda: live.services.limits.watched.n_open == 0)


class LateModels(Models):
    """Networks that answer once they are let."""

    let = threading.Event()

    def policy(self, run_id: str, kind: str) -> Policy:
        policy = super().policy(run_id, kind)

        class Late(Policy):
            def probabilities(
                self, observations: np.ndarray[tuple[int, ...], np.dtype[np.uint8]]
            ) -> np.ndarray[tuple[int, ...], np.dtype[np.float32]]:
                LateModels.let.wait(20)
                return policy.probabilities(observations)

        return Late(policy._network)


def test_games_wait_for_a_late_answer_and_may_be_paused_meanwhile(workplace: Workplace) -> None:
    run_id = finished_run(workplace)
    (expected,) = play(
        SPACE_INVADERS,
        Scene(workplace, None, run_id).policy("imitator"),  # type: ignore[arg-type]
        beginnings(SPACE_INVADERS, TINY.evaluation, [START]),
        "greedy",
        n_processes=1,
    )
    LateModels.let.set()
    with (
        running_inference(workplace, LateModels),
        live_server(workplace.settings.data) as live,
        watching(live.settings, run_id, "imitator.greedy", start=START) as page,
    ):
        page.until("hello")
        page.say("play")
        page.until_frame(20)
        LateModels.let.clear()
        page.until("waiting")
        standing = page.frames[0][-1].frame
        assert standing % 4 == 0
        assert live.http.get("/api/health").json() == {"status": "ok"}, "the loop is not blocked"
        page.say("pause")
        page.until("paused")
        page.say("step")
        page.until("waiting")
        LateModels.let.set()
        page.until("paused")
        assert page.frames[0][-1].frame == standing + 4
        page.say("play")
        page.until_frame(standing + 20)
        page.say("take_over", lane=0)
        taken = page.until("taken")
        with live.database.reading() as session:
            row = session.get_one(GameRow, taken["game_id"])
            actions = session.get_one(RecordingRow, row.recording_id).actions
    assert actions == expected.recording.actions[: len(actions)], "no observation was stale"


def test_a_page_that_draws_nothing_pauses_its_games(scene: Scene) -> None:
    with watching(scene.live.settings, scene.run_id, "imitator.greedy") as page:
        page.until("hello")
        page.acknowledges = False
        page.say("play")
        assert "stopped drawing" in page.until("paused")["why"]
        assert len(page.frames[0]) <= MAX_UNACKNOWLEDGED + 1


@pytest.mark.parametrize(
    "message",
    ["{}", '{"type": "take_over", "lane": 1}', b"", b"\x01" + b"\x02" + bytes(7), b"\x00" * 9],
)
def test_a_message_that_is_not_of_the_protocol_closes_the_stream(
    scene: Scene, message: str | bytes
) -> None:
    with watching(scene.live.settings, scene.run_id, "imitator.greedy") as page:
        page.until("hello")
        page.socket.send(message)
        assert page.close_code() == Close.BAD_MESSAGE


def test_the_part_that_a_policy_played_is_verified(scene: Scene) -> None:
    with watching(scene.live.settings, scene.run_id, "imitator.sampled", start=2) as page:
        first = page.until("hello")["frame"]
        page.say("play")
        page.until_frame(first + 70)
        page.say("take_over", lane=0)
        taken = page.until("taken")
    with scene.made.database.reading() as session:
        row = games.get(session, taken["game_id"]).recording
        recording = recordings.as_recording(row)
    assert len(recording.hashes) == recording.n_frames // 60
    assert verify(recording).n_cut == 0
