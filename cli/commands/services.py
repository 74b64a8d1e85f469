"""Single processes of ``tril up``, migrations, and health checks."""

from __future__ import annotations

import ssl
import urllib.error
import urllib.request
from dataclasses import asdict
from typing import Annotated, Literal

import typer

from cli.join import join_server
from cli.output import JsonOption, console, print_json, read_settings, readable_errors
from cli.supervision.servers import supervise_servers
from cli.workspace import migrate_databases, open_workspace
from tril.errors import Unavailable
from tril.settings import Settings
from tril.store import processes
from tril.store.access import credentials

Service = Literal["server", "worker", "inference"]
"""A process whose health can be checked."""


def serve(
    servers: Annotated[
        int | None,
        typer.Option(min=1, max=64, help="Server processes. Default: TRIL_SERVER_PROCESSES."),
    ] = None,
    share_port: Annotated[
        bool, typer.Option(help="Share the port with other processes started with this option.")
    ] = False,
) -> None:
    """Run only the web server (``tril up`` runs everything)."""
    from server.main import run_server
    from server.web.exposure import check_exposure
    from tril.inference import endpoint_of

    with readable_errors():
        settings = read_settings()
        check_exposure(settings)
        endpoint_of(settings)
        if servers is not None:
            settings = settings.model_copy(update={"server_processes": servers})
        if share_port or settings.server_processes == 1:
            run_server(settings, share_port)
        else:
            supervise_servers(settings)


JoinOption = Annotated[
    str | None,
    typer.Option(
        "--join",
        metavar="ADDRESS",
        help="Work for the server of another machine; the key is TRIL_WORKER_KEY, or in a file"
        " named by TRIL_WORKER_KEY_FILE.",
    ),
]


def worker(
    join: JoinOption = None,
    until_empty: Annotated[
        bool, typer.Option(help="End once no run that this worker could do waits or runs.")
    ] = False,
) -> None:
    """Run a training worker. Several may run at the same time, on any number of machines."""
    from trainer.runtime.worker import run_worker

    with readable_errors():
        settings = read_settings()
        if join is not None:
            settings = join_server(settings, join)
        run_worker(settings, until_empty=until_empty)


def inference(join: JoinOption = None) -> None:
    """Run the inference process, which evaluates trained networks for the server."""
    from trainer.runtime.inference import run_inference

    with readable_errors():
        settings = read_settings()
        if join is not None:
            settings = join_server(settings, join)
        run_inference(settings)


def migrate(
    without_copy: Annotated[
        bool,
        typer.Option("--without-copy", help="Don't copy a database of an earlier version first."),
    ] = False,
) -> None:
    """Migrate the databases to this version.

    What they were before the last two upgrades is in the data folder, under before-upgrades.
    """
    with readable_errors():
        migrate_databases(read_settings(), keep_copy=not without_copy)
    console.print("The database is up to date.")


def status(as_json: JsonOption = False) -> None:
    """List the processes of Tril on all machines, with what workers learn on and are at."""
    with open_workspace() as workspace, workspace.database.reading() as session:
        statuses = processes.statuses(session)
    for process in statuses:
        if as_json:
            print_json(asdict(process))
        else:
            details = [
                str(process.details[key]) for key in ("host", "gpu") if process.details.get(key)
            ]
            if cores := process.details.get("cores"):
                details.append(f"{cores} cores")
            details += [f"run {run_id}" for run_id in process.details.get("runs", ())]
            state = "busy" if process.busy else "running" if process.alive else "not responding"
            console.print(f"{process.name}: {', '.join([state, *details])}")


def health(service: Service) -> None:
    """Check a process of this data folder; exit with status 0 if it is healthy, else 1."""
    with readable_errors():
        settings = read_settings()
        if service == "server":
            ask_server(settings)
        elif service == "inference":
            ask_inference(settings)
        else:
            ask_worker(settings)
    typer.echo("ok")


def address(
    new: Annotated[
        bool,
        typer.Option(
            "--new", help="Make a new key: old addresses stop working, everybody is signed out."
        ),
    ] = False,
) -> None:
    """Print the page's address with its key, e.g. for a server in a container."""
    from server.web.security import address_with_token, renew_token

    if new:
        with open_workspace() as workspace:
            renew_token(workspace.settings.token_file)
            with workspace.database.writing() as session:
                credentials.sign_out_all_browsers(session)
    with readable_errors():
        settings = read_settings()
        typer.echo(address_with_token(settings, page_url(settings)))


def server_url(settings: Settings) -> str:
    """Return the server's URL on this machine."""
    host = "127.0.0.1" if settings.host in {"0.0.0.0", "::"} else settings.host
    scheme = "https" if settings.uses_tls else "http"
    return f"{scheme}://{f'[{host}]' if ':' in host else host}:{settings.port}"


def page_url(settings: Settings) -> str:
    """Return the URL under which the page is opened.

    It has the first of the allowed host names with TLS, with a proxy, which is taken to serve it on
    HTTPS's own port, and where the server is open to other machines; else this machine's.
    """
    names = settings.further_host_names
    if names and settings.proxies and not settings.uses_tls:
        return f"https://{names[0]}"
    if names and (settings.uses_tls or not settings.is_local):
        scheme = "https" if settings.uses_tls else "http"
        return f"{scheme}://{names[0]}:{settings.port}"
    return server_url(settings)


def ask_server(settings: Settings, timeout_s: float = 3.0) -> None:
    """Raise Unavailable unless the server answers its health check."""
    url = f"{server_url(settings)}/api/health"
    try:
        with _opener().open(url, timeout=timeout_s) as answer:
            if answer.status == 200:
                return
    except (urllib.error.URLError, OSError) as error:
        raise Unavailable(f"The server does not answer at {server_url(settings)}: {error}") from (
            error
        )
    raise Unavailable(f"The server at {server_url(settings)} is not healthy.")


def _opener() -> urllib.request.OpenerDirector:
    """Return an opener for a server of this machine, without proxy or certificate check."""
    context = ssl.create_default_context()
    context.check_hostname = False
    context.verify_mode = ssl.CERT_NONE
    return urllib.request.build_opener(
        urllib.request.ProxyHandler({}), urllib.request.HTTPSHandler(context=context)
    )


def ask_inference(settings: Settings) -> None:
    """Raise Unavailable unless the inference process answers."""
    from tril.inference import InferenceClient, endpoint_of

    InferenceClient(endpoint_of(settings)).ping()


def ask_worker(settings: Settings) -> None:
    """Raise Unavailable unless a worker is alive."""
    from tril.store.database import create_database

    database = create_database(settings.application_url)
    try:
        with database.reading() as session:
            if not processes.is_kind_alive(session, "worker"):
                raise Unavailable("No worker is running. Start one with `tril worker`.")
    finally:
        database.close()
