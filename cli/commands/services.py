"""The long-running processes one by one: server, worker, inference; migrations; health."""

from __future__ import annotations

import urllib.error
import urllib.request
from enum import StrEnum
from typing import Annotated

import typer

from cli.output import console, plain_errors
from cli.supervision.servers import supervise_servers
from cli.supervision.supervisor import end_with_supervisor
from cli.workspace import bring_up_to_date
from tril.errors import Unavailable
from tril.settings import Settings


class Service(StrEnum):
    """A process that can be asked whether it is well."""

    SERVER = "server"
    WORKER = "worker"
    INFERENCE = "inference"


def serve(
    servers: Annotated[
        int | None,
        typer.Option(min=1, max=64, help="Processes behind the port; TRIL_SERVER_PROCESSES."),
    ] = None,
    share_port: Annotated[
        bool, typer.Option(help="Run one process, beside others that were started with this.")
    ] = False,
) -> None:
    """Run the web server alone (``tril up`` runs everything)."""
    from server.main import run_server

    settings = Settings()
    if servers is not None:
        settings = settings.model_copy(update={"server_processes": servers})
    end_with_supervisor()
    with plain_errors():
        if share_port or settings.server_processes == 1:
            run_server(settings, share_port)
        else:
            supervise_servers(settings)


def worker() -> None:
    """Run a training worker alone; any number may run beside each other."""
    from trainer.runtime.worker import run_worker

    end_with_supervisor()
    with plain_errors():
        run_worker(Settings())


def inference() -> None:
    """Run the process that answers for trained networks."""
    from trainer.runtime.inference import run_inference

    end_with_supervisor()
    with plain_errors():
        run_inference(Settings())


def migrate() -> None:
    """Bring the databases up to this version; nothing is lost."""
    with plain_errors():
        bring_up_to_date(Settings())
    console.print("The database is up to date.")


def health(service: Service) -> None:
    """Exit with status 0 if a process of this data folder is well, else 1 and the reason."""
    settings = Settings()
    with plain_errors():
        if service is Service.SERVER:
            ask_server(settings)
        elif service is Service.INFERENCE:
            ask_inference(settings)
        else:
            ask_worker(settings)
    typer.echo("ok")


def address() -> None:
    """Print the page's address with its key, as ``tril up`` does (for a server in a container)."""
    from server.web.security import address_with_token

    settings = Settings()
    with plain_errors():
        typer.echo(address_with_token(settings, server_url(settings)))


def server_url(settings: Settings) -> str:
    """Address under which this machine reaches the server."""
    host = "127.0.0.1" if settings.host in {"0.0.0.0", "::"} else settings.host
    return f"http://{f'[{host}]' if ':' in host else host}:{settings.port}"


def ask_server(settings: Settings, timeout_s: float = 3.0) -> None:
    """Raise Unavailable unless the server answers its health check."""
    url = f"{server_url(settings)}/api/health"
    try:
        with urllib.request.urlopen(url, timeout=timeout_s) as answer:
            if answer.status == 200:
                return
    except (urllib.error.URLError, OSError) as error:
        raise Unavailable(f"The server does not answer at {server_url(settings)}: {error}") from (
            error
        )
    raise Unavailable(f"The server at {server_url(settings)} is not well.")


def ask_inference(settings: Settings) -> None:
    """Raise Unavailable unless the inference process answers."""
    from tril.inference import InferenceClient

    InferenceClient(settings.inference_socket).ping()


def ask_worker(settings: Settings) -> None:
    """Raise Unavailable unless a worker was heard of lately."""
    from tril.store import processes
    from tril.store.database import create_database

    database = create_database(settings.application_url)
    try:
        with database.reading() as session:
            if not processes.is_kind_alive(session, "worker"):
                raise Unavailable("No worker has been heard of; start one with `tril worker`.")
    finally:
        database.close()
