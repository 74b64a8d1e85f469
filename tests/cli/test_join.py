"""Workers that join a server of another machine: another data folder, a real server and worker."""

from __future__ import annotations

import http.server
import threading
from collections.abc import Iterator
from pathlib import Path

import psutil
import pytest
from pydantic import SecretStr
from sqlalchemy import make_url
from typer.testing import CliRunner

import cli.join
from cli.join import join_server
from cli.main import app
from server.web.security import load_secrets
from testsupport import s3
from testsupport.live import LiveServer, live_server
from testsupport.postgres import find_or_install
from testsupport.processes import TrilProcess, server_process, tril_process
from testsupport.waiting import wait_until
from testsupport.workplace import TINY, Workplace, make_workplace
from tril.errors import Forbidden, Invalid, TrilError, Unavailable
from tril.jobs import Jobs
from tril.recipes import with_values
from tril.settings import Settings
from tril.store import audit, players
from tril.store.access import credentials
from tril.store.models import Role, RunStatus

PASSWORD = "never-shown-anywhere"
QUICKLY_STOPPED = with_values(
    TINY, {"reward.method": "paper", "reward.updates": 1, "reward.learning_rate": 1e-9}
)
"""Its reward model learns nothing; with the training seed 3 the check then stops the run."""


def make_key(workplace: Workplace, role: Role = Role.WORKER) -> str:
    with workplace.database.writing() as session:
        owner = players.owner(session).id
        _, secret = credentials.make_key(session, owner, f"a {role}", role)
    return load_secrets(workplace.settings.token_file).signed(secret)


@pytest.fixture
def elsewhere(tmp_path: Path) -> Settings:
    """Return the settings of another machine."""
    return Settings(data=tmp_path / "elsewhere", learning_threads=1, learning_niceness=0)


# With SQLite.


@pytest.fixture(scope="module")
def local(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Workplace, LiveServer]]:
    """Return a server that nobody else can share the data of."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("TESTS_DATABASE", "sqlite")
        workplace = make_workplace(tmp_path_factory.mktemp("local") / "data")
        with live_server(workplace.settings.data) as live:
            yield workplace, live
        workplace.database.close()


def refusal(settings: Settings, address: str, key: str) -> TrilError:
    with pytest.raises(TrilError) as refused:
        join_server(settings.model_copy(update={"worker_key": SecretStr(key)}), address)
    return refused.value


def test_a_server_that_keeps_its_data_to_itself_says_which_settings_to_change(
    local: tuple[Workplace, LiveServer], elsewhere: Settings
) -> None:
    workplace, live = local
    said = refusal(elsewhere, f"http://{live.authority}", make_key(workplace))
    assert isinstance(said, Unavailable)
    for word in ("SQLite", "TRIL_DATABASE_URL", "PostgreSQL", "TRIL_ARTIFACTS_URL", "docs/"):
        assert word in str(said)


def test_keys_that_are_wrong_or_of_another_role_are_refused(
    local: tuple[Workplace, LiveServer], elsewhere: Settings
) -> None:
    workplace, live = local
    address = f"http://{live.authority}"
    assert isinstance(refusal(elsewhere, address, "made.up"), Forbidden)
    for role in (Role.OWNER, Role.RESEARCHER):
        assert "tril people key NAME --worker" in str(
            refusal(elsewhere, address, make_key(workplace, role))
        )
    for key in ("", "two words", "line\nHost: x", "ä"):
        assert isinstance(refusal(elsewhere, address, key), Invalid)


def test_another_version_is_refused_before_anything_is_told(
    local: tuple[Workplace, LiveServer], elsewhere: Settings, monkeypatch: pytest.MonkeyPatch
) -> None:
    workplace, live = local
    monkeypatch.setattr(cli.join, "__version__", "0.0.1")
    said = str(refusal(elsewhere, f"http://{live.authority}", make_key(workplace)))
    assert "the worker is version 0.0.1" in said
    assert "Install the server's version" in said


@pytest.mark.parametrize(
    ("address", "word"),
    [
        ("http://192.0.2.7:8000", "TRIL_PLAIN_HTTP=1"),
        ("http://tril.example", "TRIL_PLAIN_HTTP=1"),
        ("https://tril.example/?token=secret", "visible to everybody"),
        ("https://owner:secret@tril.example", "visible to everybody"),
        ("tril.example", "such as https://"),
        ("ftp://tril.example", "such as https://"),
    ],
)
def test_an_address_that_would_give_the_key_away_is_not_asked(
    elsewhere: Settings, address: str, word: str
) -> None:
    said = refusal(elsewhere, address, "any.key")
    assert isinstance(said, Invalid)
    assert word in str(said)
    assert "secret" not in str(said)


def test_a_redirect_is_named_and_not_followed(elsewhere: Settings) -> None:
    asked: list[str] = []

    class Redirecting(http.server.BaseHTTPRequestHandler):
        def do_POST(self) -> None:
            asked.append(self.path)
            self.rfile.read(int(self.headers["Content-Length"]))
            self.send_response(307)
            self.send_header("Location", f"http://{self.headers['Host']}/else")
            self.end_headers()

        def log_message(self, *_: object) -> None:
            """Stay silent."""

    with http.server.HTTPServer(("127.0.0.1", 0), Redirecting) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        try:
            address = f"http://127.0.0.1:{server.server_port}"
            said = str(refusal(elsewhere, address, "any.key"))
        finally:
            server.shutdown()
            thread.join()
    assert asked == ["/api/workers"]
    assert f"{address}/else: join that address" in said


def test_nobody_there_and_no_key_are_explained(elsewhere: Settings, tmp_path: Path) -> None:
    assert "does not answer" in str(refusal(elsewhere, "http://127.0.0.1:9", "any.key"))
    missing = elsewhere.model_copy(update={"worker_key_file": tmp_path / "none"})
    assert "TRIL_WORKER_KEY_FILE" in str(refusal(missing, "http://127.0.0.1:9", ""))


def test_a_workers_key_is_made_in_the_terminal(data_folder: Path) -> None:
    done = CliRunner().invoke(app, ["people", "key", "Lab", "--worker"])
    assert done.exit_code == 0, done.output
    listed = CliRunner().invoke(app, ["people", "list"])
    assert "Lab" in listed.output
    assert CliRunner().invoke(app, ["people", "key", "Lab", "--worker", "--owner"]).exit_code == 2
    assert load_secrets(data_folder / "secrets.json").secret_in(done.output.strip()) is not None


# With PostgreSQL.


@pytest.fixture
def lab(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Workplace]:
    """Return a data folder whose database is PostgreSQL."""
    if find_or_install() is None:
        pytest.skip("needs PostgreSQL's initdb and postgres; none is installed or installable")
    monkeypatch.setenv("TESTS_DATABASE", "postgresql")
    workplace = make_workplace(tmp_path / "data")
    yield workplace
    workplace.database.close()


@pytest.fixture
def served(lab: Workplace, tmp_path: Path) -> Iterator[TrilProcess]:
    """Return its server, whose database's address has a password, with a shared folder."""
    url = make_url(lab.settings.application_url).set(password=PASSWORD)
    with server_process(
        lab.settings.data,
        database_url=url.render_as_string(hide_password=False),
        artifacts_url=str(tmp_path / "shared"),
    ) as server:
        yield server


@pytest.mark.lengthy
def test_a_worker_joins_takes_runs_until_none_is_left_and_gives_no_secret_away(
    lab: Workplace, served: TrilProcess, elsewhere: Settings, tmp_path: Path
) -> None:
    run_id = lab.make_run(QUICKLY_STOPPED, training_seed=3, go_on_anyway=False)
    jobs = Jobs(lab.database, lab.settings)
    jobs.enqueue(run_id)
    jobs.close()
    key = make_key(lab)
    file = tmp_path / "key"
    file.write_text(f"{key}\n")
    settings = elsewhere.model_copy(update={"worker_key_file": file})
    arguments = ("worker", "--join", served.base_url, "--until-empty")
    shown: set[str] = set()

    def look() -> bool:
        try:
            program = psutil.Process(worker.process.pid)
            for process in (program, *program.children(recursive=True)):
                shown.update(process.cmdline())
        except psutil.NoSuchProcess:
            pass
        return worker.process.poll() is not None

    with tril_process(settings, *arguments) as worker:
        wait_until(look, what_was_said=lambda: "".join(worker.output))
        assert worker.process.returncode == 0, "".join(worker.output)
    row = lab.run(run_id)
    assert row.status == RunStatus.STOPPED
    assert row.worker.startswith("worker-0-")
    assert (elsewhere.data / "workers").is_dir()
    said = "".join([*worker.output, *served.output, *shown])
    assert "worker" in shown
    assert PASSWORD not in said
    assert key.partition(".")[0] not in said
    with lab.database.reading() as session:
        entry = next(one for one in audit.page(session) if one.action == audit.Action.WORKER_LET_IN)
    assert entry.subject.startswith("key ")


def test_what_has_the_same_address_here_and_is_something_else_is_refused(
    lab: Workplace, served: TrilProcess, elsewhere: Settings, tmp_path: Path
) -> None:
    key = make_key(lab)
    joined = join_server(
        elsewhere.model_copy(update={"worker_key": SecretStr(key)}), served.base_url
    )
    assert make_url(joined.queue_url).password == PASSWORD
    assert joined.artifact_root == str(tmp_path / "shared")

    (tmp_path / "empty").mkdir()
    other_folder = elsewhere.model_copy(update={"artifacts_url": str(tmp_path / "empty")})
    assert "Mount the shared folder" in str(refusal(other_folder, served.base_url, key))

    second = make_workplace(tmp_path / "second")
    second.database.close()
    other = elsewhere.model_copy(update={"database_url": second.settings.application_url})
    assert "another database" in str(refusal(other, served.base_url, key))

    unreachable = make_url(joined.application_url).set(host="127.0.0.1", port=9, query={})
    off = elsewhere.model_copy(
        update={"database_url": unreachable.render_as_string(hide_password=False)}
    )
    said = str(refusal(off, served.base_url, key))
    assert "TRIL_DATABASE_URL name a host that others reach" in said
    assert PASSWORD not in said


def test_a_worker_without_the_credentials_of_the_store_is_told_which_to_set(
    lab: Workplace, elsewhere: Settings, monkeypatch: pytest.MonkeyPatch
) -> None:
    url = f"{s3.use(monkeypatch).new_bucket()}/lab"
    key = make_key(lab)
    with server_process(lab.settings.data, artifacts_url=url) as server:
        joined = join_server(
            elsewhere.model_copy(update={"worker_key": SecretStr(key)}), server.base_url
        )
        assert joined.artifact_root == url
        for name in ("AWS_ACCESS_KEY_ID", "AWS_SECRET_ACCESS_KEY"):
            monkeypatch.delenv(name)
        said = str(refusal(elsewhere, server.base_url, key))
        assert f"The files of runs are in {url}" in said
        assert "Set AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY" in said
