"""Clients of an application in the test's own process, and what they should be shown."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TypeVar

from starlette.testclient import TestClient

from server.app import create_app
from server.play.rules import PlayRules
from testsupport.visitors import cookie_of
from testsupport.workplace import Workplace
from tril.games.base import Console
from tril.recording import Recording, replay
from tril.store import recordings
from tril.store.database import Database

T = TypeVar("T")

ONE_GAME = PlayRules(max_games=1)


@contextmanager
def signed_in(
    workplace: Workplace, frontend: Path, rules: PlayRules = ONE_GAME
) -> Iterator[TestClient]:
    """Run the application and give a client that is signed in."""
    settings = workplace.settings.model_copy(
        update={"max_games": 1000, "max_games_per_player": 1000}
    )
    app = create_app(settings, frontend, rules)
    with TestClient(app, base_url=f"http://127.0.0.1:{workplace.settings.port}") as client:
        client.cookies.set(*cookie_of(workplace.settings))
        yield client


def build_frontend(folder: Path) -> Path:
    """Make a small built frontend, and a file beside it that nobody may read."""
    build = folder / "dist"
    (build / "assets").mkdir(parents=True)
    (build / "index.html").write_text("<!doctype html><title>Tril</title>")
    (build / "assets" / "index-abc123.js").write_text("export {}")
    (build / "favicon.svg").write_text("<svg xmlns='http://www.w3.org/2000/svg'/>")
    (folder / "secret.txt").write_text("not yours")
    return build


def stored(database: Database, recording_id: int) -> Recording:
    """Read a recording from the database."""
    with database.reading() as session:
        return recordings.as_recording(recordings.get(session, recording_id))


def replayed(recording: Recording, read: Callable[[Console], T]) -> list[T]:
    """Replay a recording and read something off the console at the start and after every frame."""
    found: list[T] = []
    replay(recording, on_frame=lambda episode: found.append(read(episode.console)))
    return found
