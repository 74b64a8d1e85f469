"""Server processes that share a port."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, nullcontext

from cli.output import print_process_line
from cli.supervision.supervisor import Child, Supervisor, numbered, running, tril_command
from tril.settings import Settings


def server_children(n_processes: int) -> list[Child]:
    """Return the server processes to supervise."""
    if n_processes == 1:
        return [Child("server", tril_command("serve"))]
    command = tril_command("serve", "--share-port")
    return [Child(name, command) for name in numbered("server", n_processes)]


def server_environment(settings: Settings) -> dict[str, str]:
    """Return the environment variables shared by all child processes."""
    return {
        "TRIL_PORT": str(settings.port),
        "TRIL_DATA": str(settings.data),
        "TRIL_SERVER_PROCESSES": str(settings.server_processes),
    }


@contextmanager
def reserved_port(settings: Settings) -> Iterator[None]:
    """Reserve the port if several server processes share it.

    Raises:
        Unavailable: Another program uses the port.
    """
    from server.main import take_port

    several = settings.server_processes > 1
    with take_port(settings, shares_port=True) if several else nullcontext():
        yield


def supervise_servers(settings: Settings) -> None:
    """Run several server processes until a signal ends them."""
    children = server_children(settings.server_processes)
    supervisor = Supervisor(children, print_process_line, server_environment(settings))
    with reserved_port(settings), running(supervisor):
        supervisor.watch()
