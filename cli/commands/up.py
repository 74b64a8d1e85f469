"""``tril up``: all processes on one machine, supervised."""

from __future__ import annotations

import os
import socket
import threading
import time
import webbrowser
from collections.abc import Callable
from typing import Annotated

import typer
from rich.text import Text

from cli.commands.services import (
    ask_inference,
    ask_server,
    ask_worker,
    page_url,
    server_url,
)
from cli.output import console, errors, print_process_line, read_settings, readable_errors
from cli.supervision.lock import lock_data_folder
from cli.supervision.servers import reserved_port, server_children, server_environment
from cli.supervision.supervisor import Child, Supervisor, numbered, running, tril_command
from cli.workspace import create_data_folder, migrate_databases
from tril.errors import TrilError, Unavailable
from tril.exchange.run_transfer import remove_unfinished_imports
from tril.files.artifact_store import ArtifactStore
from tril.settings import Settings, unknown_settings

USUALLY_READY_AFTER_S = 60.0


def up(
    workers: Annotated[int, typer.Option(min=0, help="Number of training workers.")] = 1,
    servers: Annotated[
        int | None,
        typer.Option(min=1, max=64, help="Server processes. Default: TRIL_SERVER_PROCESSES."),
    ] = None,
    inference: Annotated[
        bool, typer.Option(help="Run the inference process here, not on another machine.")
    ] = True,
    port: Annotated[
        int | None, typer.Option(min=0, max=65535, help="Port; 0 takes a free one.")
    ] = None,
    browser: Annotated[bool, typer.Option(help="Open the page when it is ready.")] = True,
) -> None:
    """Start server, worker and inference; print the address; Ctrl-C stops everything."""
    from server.open_files import allow_open_files
    from server.web.exposure import check_exposure
    from server.web.pages import check_frontend
    from server.web.security import address_with_token
    from tril.inference import endpoint_of

    chosen = {"port": port, "server_processes": servers}
    with readable_errors():
        settings = read_settings().model_copy(
            update={name: value for name, value in chosen.items() if value is not None}
        )
        if settings.port == 0:
            settings = settings.model_copy(update={"port": _free_port(settings.host)})
        check_exposure(settings)
        allow_open_files(settings)
        endpoint_of(settings)
        _warn_of_unknown_settings()
        create_data_folder(settings)
        with lock_data_folder(settings.data, server_url(settings)):
            _check_port(settings)
            console.print(f"Data folder: {settings.data}")
            migrate_databases(settings)
            store = ArtifactStore(settings.artifact_root)
            if store.is_local:
                remove_unfinished_imports(store)
            url = address_with_token(settings, page_url(settings))
            check_frontend()
            _supervise(settings, workers, inference, url, browser)


def _supervise(settings: Settings, workers: int, inference: bool, url: str, browser: bool) -> None:
    children = [
        *server_children(settings.server_processes),
        *([Child("inference", tril_command("inference"))] if inference else []),
        *(Child(name, tril_command("worker")) for name in numbered("worker", workers)),
    ]
    checks: dict[str, Callable[[], None]] = {
        "the server": lambda: ask_server(settings, timeout_s=1.0)
    }
    if inference:
        checks["the inference process"] = lambda: ask_inference(settings)
    if workers:
        checks["a worker"] = lambda: ask_worker(settings)
    supervisor = Supervisor(children, print_process_line, server_environment(settings))
    with reserved_port(settings), running(supervisor):
        threading.Thread(
            target=_announce_when_ready,
            args=(supervisor, checks, url, browser),
            daemon=True,
        ).start()
        supervisor.watch()
        console.print("Stopping…")
    console.print("Stopped. Everything is saved.")


def _announce_when_ready(
    supervisor: Supervisor, checks: dict[str, Callable[[], None]], url: str, browser: bool
) -> None:
    deadline = time.monotonic() + USUALLY_READY_AFTER_S
    while checks and not supervisor.stop_requested:
        name, check = next(iter(checks.items()))
        try:
            check()
            del checks[name]
        except TrilError:
            if time.monotonic() > deadline:
                print_process_line(
                    "tril", f"Still waiting for {name} to start. A busy machine takes minutes."
                )
                deadline = float("inf")
            time.sleep(0.1)
    if supervisor.stop_requested:
        return
    if browser and _has_browser():
        webbrowser.open(url)
    console.print("\nTril is ready. Open this address (keep it secret, it contains the key):")
    console.print(Text.assemble("  ", (url, "bold"), "\n"))


def _has_browser() -> bool:
    try:
        controller = webbrowser.get()
    except webbrowser.Error:
        return False
    return not isinstance(controller, webbrowser.GenericBrowser) or controller.name not in {
        "www-browser", "links", "elinks", "lynx", "w3m",
    }  # fmt: skip


def _warn_of_unknown_settings() -> None:
    for name, nearest in unknown_settings(map(str.upper, os.environ)).items():
        suggestion = "" if nearest is None else f" Did you mean {nearest}?"
        errors.print(
            Text.assemble(("Warning:", "yellow"), f" {name} is no setting of Tril.{suggestion}")
        )


def _check_port(settings: Settings) -> None:
    family = socket.AF_INET6 if ":" in settings.host else socket.AF_INET
    with socket.socket(family) as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((settings.host, settings.port))
        except OSError as error:
            raise Unavailable(
                f"Port {settings.port} on {settings.host} can't be used ({error.strerror})."
                " Stop the program that uses it, or choose another port with TRIL_PORT."
            ) from error


def _free_port(host: str) -> int:
    with socket.socket() as probe:
        probe.bind((host, 0))
        port: int = probe.getsockname()[1]
        return port
