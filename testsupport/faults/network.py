"""Hosts of their own on this machine: network namespaces at one switch; needs root."""

from __future__ import annotations

import os
import shutil
import subprocess
from dataclasses import dataclass

SUBNET = f"10.{200 + os.getpid() // 250 % 50}.{os.getpid() % 250 + 1}"
"""Of this process alone, since several may make networks at the same time."""

MAIN = "main"
"""The machine's own namespace, in which the server and the clients are."""


@dataclass(frozen=True)
class Network:
    """A switch and the hosts that are plugged in, in order of their addresses; MAIN is one.

    What is between them is in a namespace, so nothing of the machine's own network is changed but
    for one interface.
    """

    hosts: tuple[str, ...]

    @staticmethod
    def is_possible() -> bool:
        """Whether this process may make namespaces."""
        return os.geteuid() == 0 and shutil.which("ip") is not None

    def open(self) -> None:
        """Make the namespaces and plug in every host."""
        for name in ("switch", *self._others()):
            _ip("netns", "add", self.namespace(name))
        switch = self.namespace("switch")
        _ip("-n", switch, "link", "add", "bridge", "type", "bridge")
        _ip("-n", switch, "link", "set", "bridge", "up")
        for host in self.hosts:
            here, there = self._plugs(host)
            _ip("link", "add", here, "type", "veth", "peer", "name", there, "netns", switch)
            place: list[str] = []
            if host != MAIN:
                _ip("link", "set", here, "netns", self.namespace(host))
                place = ["-n", self.namespace(host)]
                _ip(*place, "link", "set", "lo", "up")
            _ip(*place, "address", "add", f"{self.address(host)}/24", "dev", here)
            _ip(*place, "link", "set", here, "up")
            _ip("-n", switch, "link", "set", there, "up")
            self.join(host)

    def close(self) -> None:
        """Remove everything."""
        # With the namespace it would go a little later.
        subprocess.run(["ip", "link", "del", self._plugs(MAIN)[0]], check=False)
        for name in ("switch", *self._others()):
            subprocess.run(["ip", "netns", "del", self.namespace(name)], check=False)

    def cut(self, host: str) -> None:
        """Let nothing through to or from a host; nobody is told."""
        _ip("-n", self.namespace("switch"), "link", "set", self._plugs(host)[1], "nomaster")

    def join(self, host: str) -> None:
        """Let everything through again."""
        switch = self.namespace("switch")
        _ip("-n", switch, "link", "set", self._plugs(host)[1], "master", "bridge")

    def address(self, host: str) -> str:
        """Return a host's address."""
        return f"{SUBNET}.{self.hosts.index(host) + 1}"

    def command(self, host: str) -> list[str]:
        """Return what a command line begins with that is to run on a host."""
        return [] if host == MAIN else ["ip", "netns", "exec", self.namespace(host)]

    def namespace(self, name: str) -> str:
        """Return the name of a host's namespace."""
        return f"tril-{os.getpid()}-{name}"

    def _others(self) -> list[str]:
        return [host for host in self.hosts if host != MAIN]

    def _plugs(self, host: str) -> tuple[str, str]:
        # At most 15 characters; two campaigns of one machine must not meet.
        name = f"{os.getpid()}h{self.hosts.index(host)}"
        return f"a{name}", f"b{name}"


def _ip(*arguments: str) -> None:
    subprocess.run(["ip", *arguments], check=True)
