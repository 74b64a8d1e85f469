"""The server processes behind one port."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, nullcontext

from cli.output import say
from cli.supervision.supervisor import Child, Supervisor, numbered, running, tril_command
from tril.settings import Settings


def server_children(n_processes: int) -> list[Child]:
    """Return the server processes to supervise; several listen on the same port."""
    if n_processes == 1:
        return [Child("server", tril_command("serve"))]
    command = tril_command("serve", "--share-port")
    return [Child(name, command) for name in numbered("server", n_processes)]


def server_environment(settings: Settings) -> dict[str, str]:
    """Return what the children have to agree about."""
    return {
        "TRIL_PORT": str(settings.port),
        "TRIL_DATA": str(settings.data),
        "TRIL_SERVER_PROCESSES": str(settings.server_processes),
    }


@contextmanager
def held_port(settings: Settings) -> Iterator[None]:
    """Keep the port for several server processes; a single one takes it itself.

    Raises:
        Unavailable: It is taken by something else.
    """
    from server.main import take_port

    several = settings.server_processes > 1
    with take_port(settings, shares_port=True) if several else nullcontext():
        yield


def supervise_servers(settings: Settings) -> None:
    """Run several server processes until a signal ends them."""
    children = server_children(settings.server_processes)
    supervisor = Supervisor(children, say, server_environment(settings))
    with held_port(settings), running(supervisor):
        supervisor.watch()
