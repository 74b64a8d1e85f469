"""Joins a server of another machine: asks it where the data is, and checks that it is reached."""

from __future__ import annotations

import getpass
import json
import secrets
import sys
import urllib.error
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from http import HTTPStatus
from http.client import HTTPException
from typing import Any
from urllib.parse import urlsplit

from sqlalchemy import make_url
from sqlalchemy.exc import NoSuchModuleError, OperationalError

from cli.workspace import create_data_folder
from tril import __version__
from tril.addresses import is_loopback
from tril.errors import Forbidden, Invalid, TrilError, Unavailable
from tril.files.artifact_store import ArtifactStore
from tril.settings import Settings, checked_key
from tril.store.access import credentials
from tril.store.database import Database, create_database
from tril.store.schema import check_schema, schema_revision

TIMEOUT_S = 30.0
MAX_ANSWER_BYTES = 65_536


def join_server(settings: Settings, address: str) -> Settings:
    """Return the settings of a worker that shares the data of a server of another machine.

    What the process's own settings say of databases and artifact store comes before what the
    server says, for machines that reach them under other names; either way they have to be the
    server's.

    Args:
        settings: The process's own settings, which name the folder for checkpoints.
        address: The server's address, as a browser opens it.

    Raises:
        Invalid: The address or the key can't be used.
        Forbidden: The server does not take the key.
        Unavailable: The server refuses, or something of what it names can't be reached.
    """
    url = _checked_address(address, settings)
    key = _read_key(settings)
    answer = _ask(url, key)
    joined = settings.model_copy(
        update={
            name: getattr(settings, name) or answer[name]
            for name in ("database_url", "jobs_database_url", "artifacts_url")
        }
    )
    create_data_folder(joined)
    _check_database(joined, key)
    _check_artifacts(joined, answer["probe_path"], answer["probe"])
    return joined


def _checked_address(address: str, settings: Settings) -> str:
    """Return the address that is asked; raises Invalid if the key would be readable on the way."""
    parts = urlsplit(address)
    if parts.scheme not in {"http", "https"} or not parts.hostname:
        raise Invalid("Expected the server's address, such as https://tril.example.")
    if parts.username or parts.password or parts.query or parts.fragment:
        raise Invalid(
            "Give the server's address alone, such as https://tril.example: arguments of a command"
            " are visible to everybody on this machine. The key comes from TRIL_WORKER_KEY or a"
            " file that TRIL_WORKER_KEY_FILE names."
        )
    if parts.scheme == "http" and not is_loopback(parts.hostname) and not settings.plain_http:
        raise Invalid(
            f"Without encryption whoever is on the way to {parts.hostname} can read the key and the"
            " database's password. Use an address that begins with https://. Where nobody else can"
            " listen, TRIL_PLAIN_HTTP=1 allows it."
        )
    return f"{parts.scheme}://{parts.netloc}/api/workers"


def _read_key(settings: Settings) -> str:
    key = settings.secret("worker_key")
    if not key and sys.stdin is not None and sys.stdin.isatty():
        key = checked_key(getpass.getpass("Key of the worker: "))
    if not key:
        raise Invalid(
            "Which key? Make one on the page People, or by `tril people key NAME --worker` on the"
            " server's machine, and give it in TRIL_WORKER_KEY or in a file that"
            " TRIL_WORKER_KEY_FILE names."
        )
    return key


class _NoRedirects(urllib.request.HTTPRedirectHandler):
    """Lets nobody pass the key on to another address."""

    def redirect_request(self, *_: Any) -> None:
        return None


def _opener(url: str) -> urllib.request.OpenerDirector:
    """Return an opener for a server, by the environment's proxy only if that is another machine."""
    is_here = is_loopback(urlsplit(url).hostname or "")
    proxies = urllib.request.ProxyHandler({} if is_here else None)
    return urllib.request.build_opener(proxies, _NoRedirects)


def _ask(url: str, key: str) -> dict[str, str]:
    """Ask the server for the addresses of the data."""
    body = json.dumps({"version": __version__, "revision": schema_revision()}).encode()
    headers = {"Authorization": f"Bearer {key}", "Content-Type": "application/json"}
    request = urllib.request.Request(url, body, headers, method="POST")
    try:
        with _opener(url).open(request, timeout=TIMEOUT_S) as reply:
            content = reply.read(MAX_ANSWER_BYTES)
    except urllib.error.HTTPError as error:
        raise _refusal(url, error) from error
    except (OSError, HTTPException) as error:
        reason = getattr(error, "reason", error)
        raise Unavailable(
            f"The server does not answer at {url}: {reason}. Is this the address under which this"
            " machine reaches it?"
        ) from error
    try:
        answer = json.loads(content)
        names = ("database_url", "jobs_database_url", "artifacts_url", "probe_path", "probe")
        return {name: str(answer[name]) for name in names}
    except (ValueError, KeyError, TypeError) as error:
        # Without the answer, which may have a password.
        raise Unavailable(f"What answers at {url} is not Tril's server.") from error


def _refusal(url: str, error: urllib.error.HTTPError) -> Exception:
    try:
        detail = str(json.loads(error.read(MAX_ANSWER_BYTES))["detail"])
    except (ValueError, KeyError, TypeError, OSError):
        detail = ""
    if error.code == HTTPStatus.UNAUTHORIZED:
        return Forbidden(
            "The server does not know this key; it may have been revoked. Make another one on the"
            " page People, or by `tril people key NAME --worker` on the server's machine."
        )
    if error.code in {HTTPStatus.NOT_FOUND, HTTPStatus.METHOD_NOT_ALLOWED} or error.code < 400:
        where = error.headers.get("Location")
        hint = f" It sends to {where}: join that address." if where else ""
        return Unavailable(
            f"What answers at {url} is no server of this version ({__version__}) of Tril.{hint}"
        )
    if detail:
        return Unavailable(f"The server refuses: {detail}")
    return Unavailable(f"The server at {url} answers with status {error.code}; its log says more.")


def _check_database(settings: Settings, key: str) -> None:
    """Raise Unavailable unless the database and the queue are reached, and are the server's."""
    with _opened(settings.application_url, "TRIL_DATABASE_URL") as database:
        check_schema(database)
        with database.reading() as session:
            secret = key.partition(".")[0]
            if credentials.find(session, credentials.hash_of(secret)) is None:
                raise Unavailable(
                    f"What answers at {_without_password(settings.application_url)} is another"
                    " database: it does not know the key. That address may mean another machine"
                    " here than it does on the server; set TRIL_DATABASE_URL."
                )
    with _opened(settings.queue_url, "TRIL_JOBS_DATABASE_URL"):
        pass


@contextmanager
def _opened(url: str, setting: str) -> Iterator[Database]:
    """Connect with a database; raises Unavailable if that fails."""
    try:
        database = create_database(url)
    except (ModuleNotFoundError, NoSuchModuleError) as error:
        raise Unavailable(
            f"PostgreSQL's driver is missing ({error}): pip install 'tril-imitation[postgres]'"
        ) from error
    try:
        try:
            database.engine.connect().close()
        except OperationalError as error:
            raise Unavailable(
                f"The server keeps its data in {_without_password(url)}, which this machine does"
                f" not reach: {str(error.orig).strip()}. Let the server's {setting} name a host"
                " that others reach, and the password; or set it here, where this machine reaches"
                " it by another name or password."
            ) from error
        yield database
    finally:
        database.close()


def _without_password(url: str) -> str:
    return make_url(url).render_as_string(hide_password=True)


def _check_artifacts(settings: Settings, probe_path: str, probe: str) -> None:
    """Raise Unavailable unless the artifact store is the server's and can be written to."""
    own_probe = f"{probe_path}-{secrets.token_hex(4)}"
    try:
        store = ArtifactStore(settings.artifacts_url)
        if store.get(probe_path).decode() == probe:
            store.put(own_probe, b"")
            store.remove(own_probe)
            return
        problem = "what is there is not the server's"
    except (TrilError, UnicodeDecodeError) as error:
        problem = str(error).rstrip(".")
    raise Unavailable(
        f"The files of runs are in {settings.artifacts_url}, which this machine does not reach:"
        f" {problem}. Mount the shared folder, or give this machine the store's credentials; if it"
        " has another name here, set TRIL_ARTIFACTS_URL."
    )
