"""People at work while faults happen: each client is a thread that notes what it was told."""

from __future__ import annotations

import hashlib
import itertools
import json
import threading
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from typing import Any

import httpx2
import numpy as np
from sqlalchemy.exc import SQLAlchemyError
from websockets.exceptions import ConnectionClosed, InvalidHandshake, InvalidStatus

from server.play.wire.protocol import Close, Ended, FrameMessage, Hello, Paused
from testsupport.faults.history import History, Kind, Request
from testsupport.faults.plan import Plan
from testsupport.live import GameClient, join
from testsupport.space_invaders import Keys
from testsupport.workplace import Workplace
from tril.exchange.formats.recording_file import dump_recording
from tril.games.atari.starts import AtariStart
from tril.games.space_invaders import SPACE_INVADERS
from tril.games.space_invaders.memory import Action
from tril.play.episode import Episode
from tril.recording import Recorder, Recording
from tril.settings import Settings
from tril.store.models import NOT_OVER, RunStatus

BEHAVIOUR = 2
"""What clients play, import and rank; runs are of another one, whose ranking stays as it is."""

GIVE_UP_AFTER_S = 60.0
THINK_S = (0.1, 0.6)
MOST_RANKED = 6

_BROKEN = (ConnectionClosed, InvalidHandshake, OSError, TimeoutError)


class Client(ABC):
    """Somebody who asks one thing at a time, again and again.

    Args:
        history: Where everything asked is noted.
        servers: Settings of the servers; one that does not answer is left for the next.
        cookie: Header of a browser that is signed in.
        rng: Draws what is asked.
    """

    def __init__(
        self,
        history: History,
        servers: Sequence[Settings],
        cookie: str,
        rng: np.random.Generator,
    ) -> None:
        self._history = history
        self._servers = itertools.cycle(servers)
        self._cookie = cookie
        self._rng = rng
        self._tokens = (f"{type(self).__name__} {number}" for number in itertools.count())
        self._http = self._connect()
        self._leaving = threading.Event()
        self._thread = threading.Thread(target=self._run, name=type(self).__name__, daemon=True)
        self.crashed: BaseException | None = None

    def start(self) -> None:
        """Begin."""
        self._thread.start()

    def leave(self, within_s: float) -> None:
        """Finish what was begun and end; raises TimeoutError if that takes longer."""
        self._leaving.set()
        self._thread.join(within_s)
        if self._thread.is_alive():
            raise TimeoutError(f"{type(self).__name__} did not finish within {within_s:.0f} s.")
        self._http.close()

    @abstractmethod
    def _act(self) -> None:
        """Do one thing."""

    @abstractmethod
    def _finish(self) -> None:
        """Finish what was begun."""

    def _run(self) -> None:
        try:
            while not self._leaving.wait(float(self._rng.uniform(*THINK_S))):
                self._act()
            self._finish()
        except BaseException as problem:  # noqa: BLE001 - the campaign's own thread raises it
            self.crashed = problem

    def _ask(
        self,
        kind: Kind,
        subject: str,
        method: str,
        path: str,
        value: Any = None,
        answer_of: Callable[[Any], Any] = lambda _body: None,
        **more: Any,
    ) -> Request:
        """Send a request and note what came of it."""
        began_s = time.monotonic()
        try:
            reply = self._http.request(method, path, **more)
        except httpx2.HTTPError as problem:
            self._http.close()
            self._http = self._connect()
            request = Request(kind, subject, value, began_s, time.monotonic(), None, repr(problem))
        else:
            ended_s = time.monotonic()
            is_json = reply.content and "json" in reply.headers.get("content-type", "")
            body = reply.json() if is_json else None
            answer = answer_of(body) if reply.status_code < 300 else body
            request = Request(kind, subject, value, began_s, ended_s, reply.status_code, answer)
        self._history.add(request)
        return request

    def _connect(self) -> httpx2.Client:
        """Connect with the next server."""
        self._settings = next(self._servers)
        return httpx2.Client(
            base_url=f"http://{self._settings.host}:{self._settings.port}",
            headers={"Cookie": self._cookie},
            timeout=GIVE_UP_AFTER_S,
        )


class Librarian(Client):
    """Imports recordings, writes notes on them, deletes and restores them, ranks them."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self._console = SPACE_INVADERS.make_console()
        self._sent = 0
        self._pending: tuple[str, str, dict[str, Any]] | None = None
        self._ranked: list[int] = []
        self._others: list[int] = []

    def _act(self) -> None:
        does = [self._import]
        if self._others:
            does += [self._note, self._note, self._delete]
        if len(self._ranked) > 2:
            does += [self._rank, self._rank, self._undo]
        does[int(self._rng.integers(len(does)))]()

    def _finish(self) -> None:
        while self._pending is not None:
            self._import()

    def _import(self) -> None:
        """Import a new recording, or once more the one that nobody said was imported."""
        if self._pending is None:
            recording = self._play()
            self._sent += 1
            self._pending = f"game {self._sent}", digest(recording), dump_recording(recording)
        subject, value, content = self._pending
        request = self._ask(
            Kind.IMPORT,
            subject,
            "POST",
            f"/api/behaviours/{BEHAVIOUR}/recordings/import",
            value,
            lambda body: (body["imported"] + body["already_there"])[0],
            content=json.dumps(content),
            headers={"Content-Type": "application/json"},
        )
        if request.is_acknowledged:
            self._pending = None
            wants = self._others if len(self._ranked) >= MOST_RANKED else self._ranked
            wants.append(request.answer)

    def _play(self) -> Recording:
        recorder = Recorder(Episode(self._console, AtariStart(int(self._rng.integers(64)))))
        for _ in range(12):
            action = int(self._rng.choice(list(Action)))
            for _ in range(10):
                if recorder.episode.end is None:
                    recorder.advance(action)
        return recorder.recording()

    def _note(self) -> None:
        recording_id = int(self._rng.choice(self._others))
        path, subject = f"/api/recordings/{recording_id}", notes_of(recording_id)
        token = next(self._tokens)
        self._ask(Kind.WRITE, subject, "PATCH", path, token, json={"notes": token})
        self._ask(Kind.READ, subject, "GET", path, answer_of=lambda body: body["notes"])

    def _delete(self) -> None:
        recording_id = int(self._rng.choice(self._others))
        path, subject = f"/api/recordings/{recording_id}", deletion_of("recording", recording_id)
        if self._rng.random() < 0.5:
            self._ask(Kind.WRITE, subject, "DELETE", path, True)
        else:
            self._ask(Kind.WRITE, subject, "POST", f"{path}/restore", False)
        self._ask(Kind.READ, subject, "GET", path, answer_of=lambda body: body["deleted"])

    def _rank(self) -> None:
        path = f"/api/behaviours/{BEHAVIOUR}/ranking"
        now = self._ask(Kind.READ, "ranking", "GET", path, answer_of=lambda body: body)
        if not now.is_acknowledged:
            return
        tiers = [[int(one)] for one in self._rng.permutation(self._ranked)]
        if tiers == now.answer["tiers"]:
            return
        body = {"base_revision": now.answer["revision"], "tiers": tiers}
        self._ask(Kind.RANK, "ranking", "PUT", path, tiers, _ranking, json=body)

    def _undo(self) -> None:
        path = f"/api/behaviours/{BEHAVIOUR}/ranking"
        now = self._ask(Kind.READ, "ranking", "GET", path, answer_of=lambda body: body)
        if now.is_acknowledged and now.answer["can_undo"]:
            body = {"base_revision": now.answer["revision"]}
            self._ask(Kind.UNDO, "ranking", "POST", f"{path}/undo", None, _ranking, json=body)


class Player(Client):
    """Plays short games; goes on with those whose connection broke."""

    def _act(self) -> None:
        begun = self._ask(
            Kind.READ,
            "new game",
            "POST",
            "/api/games",
            answer_of=lambda body: body,
            json={"behaviour_id": BEHAVIOUR},
        )
        if begun.is_acknowledged:
            self._play(begun.answer)

    def _finish(self) -> None:
        """Nothing: each game is played to its end."""

    def _play(self, game: dict[str, Any]) -> None:
        seen, subject, last = 0, f"game {game['id']}", int(self._rng.integers(30, 240))
        kind = Kind.PLAY
        while True:
            began_s = time.monotonic()
            status: int | None = None
            problem: Exception | None = None
            try:
                with join(self._settings, game, cookie_header=self._cookie) as player:
                    at = player.until(Hello).frame
                    if kind is Kind.REJOIN:
                        self._note(Kind.REJOIN, subject, seen, began_s, 200, at)
                        kind, began_s = Kind.PLAY, time.monotonic()
                    seen, ended = self._play_to_end(player, max(last, at + 20), at)
                    if ended is not None:
                        self._note(Kind.PLAY, subject, seen, began_s, 200, ended)
                        return
            except InvalidStatus as refusal:
                problem, status = refusal, refusal.response.status_code
            except ConnectionClosed as closed:
                problem = closed
                if closed.rcvd is not None and closed.rcvd.code == Close.GAME_OVER:
                    return  # It had ended when the connection broke.
            except _BROKEN as broken:
                problem = broken
            self._note(kind, subject, seen, began_s, status, repr(problem))
            kind = Kind.REJOIN
            self._http.close()
            self._http = self._connect()
            time.sleep(0.5)

    def _play_to_end(
        self, player: GameClient, last: int, seen: int
    ) -> tuple[int, dict[str, Any] | None]:
        """Play until the game has ended, and tell how; None where the connection broke."""
        player.say("ready")
        asked = False
        try:
            while not isinstance(message := player.next(GIVE_UP_AFTER_S), Ended):
                player.screens.clear()
                player.frames.clear()
                if isinstance(message, FrameMessage):
                    seen = message.frame
                    if seen % 15 == 0:
                        player.hold(Keys(int(self._rng.integers(3))) | Keys.FIRE)
                    if seen >= last and not asked:
                        asked = True
                        player.say("stop")
                elif isinstance(message, Paused):
                    player.say("go_on")
        except _BROKEN:
            return seen, None
        return seen, {"recording_id": message.recording_id, "frame": message.frame}

    def _note(
        self, kind: Kind, subject: str, value: Any, began_s: float, status: int | None, answer: Any
    ) -> None:
        ended_s = time.monotonic()
        self._history.add(Request(kind, subject, value, began_s, ended_s, status, answer))


class Trainer(Client):
    """Starts small runs, cancels, resumes, names, deletes and restores them, and looks at them.

    A run is made as a command in the terminal would make it, by the database, since the API has
    no recipe that is this small.

    Args:
        workplace: Where the runs' behaviour is.
        plan: How many runs there are, and of how many PPO steps.
        *arguments: As for Client.
    """

    def __init__(self, workplace: Workplace, plan: Plan, *arguments: Any) -> None:
        super().__init__(*arguments)
        self._workplace = workplace
        self._plan = plan
        self.run_ids: list[str] = []

    def _act(self) -> None:
        known = self._ask(
            Kind.READ,
            "runs",
            "GET",
            "/api/runs",
            answer_of=lambda body: {run["id"]: run["status"] for run in body},
        )
        if not known.is_acknowledged:
            return
        runs: dict[str, str] = known.answer
        active = [run_id for run_id, status in runs.items() if status in NOT_OVER]
        over = [run_id for run_id in runs if run_id not in active]
        if len(active) < self._plan.runs_at_once and len(self.run_ids) < self._plan.n_runs:
            self._create()
        for run_id in over:
            if runs[run_id] in {RunStatus.CANCELLED, RunStatus.FAILED}:
                self._ask(Kind.RESUME, run_id, "POST", f"/api/runs/{run_id}/resume")
        what = self._rng.random()
        if what < 0.01 and active:
            run_id = str(self._rng.choice(active))
            self._ask(Kind.CANCEL, run_id, "POST", f"/api/runs/{run_id}/cancel")
        elif what < 0.3 and self.run_ids:
            self._name(str(self._rng.choice(self.run_ids)))
        elif what < 0.4 and over:
            self._delete(str(self._rng.choice(over)))
        else:
            self._look_at_reward([one for one in over if runs[one] == RunStatus.DONE])

    def _finish(self) -> None:
        """Let every run go on until it is done."""
        while not self._ended():
            time.sleep(0.5)

    def _ended(self) -> bool:
        for run_id in self.run_ids:
            asked = self._ask(
                Kind.READ,
                run_id,
                "GET",
                f"/api/runs/{run_id}",
                answer_of=lambda body: body["status"],
            )
            if asked.answer in {RunStatus.CANCELLED, RunStatus.FAILED}:
                self._ask(Kind.RESUME, run_id, "POST", f"/api/runs/{run_id}/resume")
            if asked.answer != RunStatus.DONE:
                return False
        return True

    def _create(self) -> None:
        began_s, steps = time.monotonic(), int(self._rng.choice(self._plan.steps))
        try:
            run_id = self._workplace.make_run(steps=steps)
        except SQLAlchemyError as problem:
            status, answer = None, repr(problem)
        else:
            self.run_ids.append(run_id)
            status, answer = 201, run_id
        ended_s = time.monotonic()
        self._history.add(Request(Kind.CREATE, "runs", steps, began_s, ended_s, status, answer))

    def _name(self, run_id: str) -> None:
        path, subject, token = f"/api/runs/{run_id}", name_of(run_id), next(self._tokens)
        self._ask(Kind.WRITE, subject, "PATCH", path, token, json={"name": token})
        self._ask(Kind.READ, subject, "GET", path, answer_of=lambda body: body["name"])

    def _delete(self, run_id: str) -> None:
        path, subject = f"/api/runs/{run_id}", deletion_of("run", run_id)
        deleted = self._ask(Kind.WRITE, subject, "DELETE", path, True)
        while deleted.status != 409:
            if self._ask(Kind.WRITE, subject, "POST", f"{path}/restore", False).is_acknowledged:
                return
            time.sleep(0.5)

    def _look_at_reward(self, over: list[str]) -> None:
        """Ask what the inference process answers."""
        if over:
            path = f"/api/runs/{over[0]}/reward/{self._workplace.ranked[0]}"
            self._ask(Kind.READ, "reward", "GET", path)


def digest(recording: Recording) -> str:
    """Return what tells a recording from every other one."""
    told = f"{recording.game.name} {recording.start.key} ".encode() + recording.actions
    return hashlib.blake2b(told, digest_size=12).hexdigest()


def notes_of(recording_id: int) -> str:
    """Return the subject of a recording's notes."""
    return f"notes of recording {recording_id}"


def name_of(run_id: str) -> str:
    """Return the subject of a run's name."""
    return f"name of run {run_id}"


def deletion_of(kind: str, key: int | str) -> str:
    """Return the subject of whether a thing is deleted."""
    return f"deletion of {kind} {key}"


def _ranking(body: dict[str, Any]) -> dict[str, Any]:
    return {"revision": body["revision"], "tiers": body["tiers"]}
