"""The processes of a campaign: a whole Tril, each server and worker on a machine of its own."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

from testsupport.databases import CHOICE
from testsupport.faults.clocks import Clock, build
from testsupport.faults.injection import Target, mount, unmount
from testsupport.faults.ledger import keep_ledger
from testsupport.faults.members import PostgresMember, StoreMember, tril_member
from testsupport.faults.network import MAIN, Network
from testsupport.faults.plan import Plan
from testsupport.ports import free_port
from testsupport.postgres import SERVER
from testsupport.workplace import Workplace, make_workplace
from tril.settings import Settings

DISK_BYTES = 2 * 2**30
DATABASE_HOST, STORE_HOST = "database", "store"


@contextmanager
def running_system(plan: Plan, folder: Path) -> Iterator[tuple[Workplace, Target, list[Settings]]]:
    """Provide a workplace, the processes of a Tril on it, not started yet, and its servers."""
    with ExitStack() as stack:
        disks, logs = folder / "disks", folder / "logs"
        logs.mkdir()
        target = Target([])
        fills_disk = plan.kinds is None or "fill disk" in plan.kinds
        if fills_disk and os.geteuid() == 0:
            mount(disks, DISK_BYTES)
            target.disk, target.disk_bytes = disks, DISK_BYTES
            stack.callback(unmount, disks)
        if plan.database == "postgresql":
            _start_network(plan, target, stack)
            _start_database(folder, target, stack)
        url = _start_store(folder, target, stack) if plan.store == "s3" else ""
        workplace = make_workplace(disks / "data")
        stack.callback(workplace.database.close)
        keep_ledger(workplace.database)
        workplace = replace(
            workplace, settings=workplace.settings.model_copy(update={"artifacts_url": url})
        )
        servers = _add_members(plan, folder, workplace.settings, target)
        for member in target.members:
            stack.callback(member.stop)
        yield workplace, target, servers


def _start_network(plan: Plan, target: Target, stack: ExitStack) -> None:
    if not Network.is_possible():
        return
    stores = [STORE_HOST] if plan.store == "s3" else []
    hosts = [_host_of(name) for name in _names(plan)]
    target.network = Network((MAIN, DATABASE_HOST, *stores, *hosts))
    stack.callback(target.network.close)
    target.network.open()


def _names(plan: Plan) -> list[str]:
    """Return the servers and the workers, each of which is a machine where there are several."""
    return [
        f"{kind} {number}"
        for kind, how_many in (("server", plan.n_servers), ("worker", plan.n_workers))
        for number in range(1, how_many + 1)
    ]


def _host_of(name: str) -> str:
    return name.replace(" ", "-")


def _start_database(folder: Path, target: Target, stack: ExitStack) -> None:
    folder.chmod(0o755)  # the server runs as another user
    place = folder / "postgresql"
    place.mkdir()
    command = target.network.command(DATABASE_HOST) if target.network else []
    address = target.network.address(DATABASE_HOST) if target.network else None
    target.database = PostgresMember(place, command, address)
    target.database.start()
    stack.callback(target.database.stop)
    _set_variables({SERVER: str(place), CHOICE: "postgresql"}, stack)


def _start_store(folder: Path, target: Target, stack: ExitStack) -> str:
    """Start the S3 server and let processes know it; returns the URL of the store."""
    network = target.network
    address = network.address(STORE_HOST) if network else "127.0.0.1"
    command = network.command(STORE_HOST) if network else []
    target.store = StoreMember(folder, address, free_port(), command)
    target.store.start()
    stack.callback(target.store.stop)
    _set_variables(target.store.server.environment(), stack)
    return target.store.server.new_bucket()


def _set_variables(variables: dict[str, str], stack: ExitStack) -> None:
    os.environ.update(variables)
    for name in variables:
        stack.callback(os.environ.pop, name)


def _url_in_network(settings: Settings, target: Target) -> str:
    """Return the database's URL as processes on other hosts know it."""
    if target.network is None or target.database is None:
        return settings.database_url
    at = target.network.address(DATABASE_HOST)
    return settings.database_url.partition("@")[0] + f"@{at}/" + _name_in(settings.database_url)


def _name_in(url: str) -> str:
    return url.partition("@/")[2].partition("?")[0]


def _add_members(plan: Plan, folder: Path, settings: Settings, target: Target) -> list[Settings]:
    """Add the processes; returns the settings of the servers.

    Where there is a network, every server and every worker is on a machine of its own. Servers
    have one data folder, as they have on one machine.
    """
    network, servers = target.network, list[Settings]()
    library = build(folder) if target.database is not None else None
    shared = settings.model_copy(
        update={
            "learning_threads": 1,
            "learning_niceness": 0,
            "database_url": _url_in_network(settings, target),
        }
    )
    target.members.append(tril_member("inference", shared, folder / "logs"))
    for name in _names(plan):
        kind, of_host = name.partition(" ")[0], dict[str, Any]()
        if kind == "server":
            of_host["port"] = free_port()
            if network is not None:
                of_host |= {"host": network.address(_host_of(name)), "plain_http": True}
                of_host["allowed_hosts"] = of_host["host"]
        elif network is not None:
            of_host["data"] = folder / "disks" / _host_of(name)
            of_host["artifacts_url"] = settings.artifact_root
        mine = shared.model_copy(update=of_host)
        if kind == "server":
            servers.append(mine)
        host = network.command(_host_of(name)) if network else []
        clock = Clock(library, folder / f"{_host_of(name)}.clock") if library else None
        target.members.append(tril_member(name, mine, folder / "logs", host, clock))
    return servers
