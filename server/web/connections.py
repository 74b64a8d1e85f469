"""How many connections a server process serves, from whom, and in which turns."""

from __future__ import annotations

import asyncio
from collections import Counter, OrderedDict, deque
from collections.abc import Callable
from ipaddress import IPv6Address, ip_network

from tril.addresses import parse_address

N_SPARE = 32
"""Connections beside those that are served, on which only the health check is answered."""

TURN_EVERY_S = 0.002
"""A request takes the event loop about a millisecond, so that games have at least half of it."""

MOST_EVERY_S = 0.01
"""The same while the event loop is behind."""

_IPV6_NETWORK = 64
"""A household or a host has so many bits of an IPv6 address for itself."""


class ConnectionSlot:
    """A slot that a connection holds until it has closed.

    Attributes:
        address: Where the connection comes from.
        is_spare: Whether only the health check is answered.
    """

    def __init__(self, address: str, is_spare: bool, release: Callable[[], None]) -> None:
        self.address = address
        self.is_spare = is_spare
        self._release: Callable[[], None] | None = release

    def release(self) -> None:
        """Free the slot for another connection."""
        release, self._release = self._release, None
        if release is not None:
            release()


class Connections:
    """The connections of a server process, WebSockets included.

    Args:
        at_once: Most connections that are served.
        per_address: Most of them from one address.
        is_proxy: Whether an address is that of a proxy, behind which there are many clients.
        may_connect: Whether an address may connect at all.
    """

    def __init__(
        self,
        at_once: int,
        per_address: int,
        is_proxy: Callable[[str], bool] = lambda _address: False,
        may_connect: Callable[[str], bool] = lambda _address: True,
    ) -> None:
        self._at_once = at_once
        self._per_address = per_address
        self._is_proxy = is_proxy
        self._may_connect = may_connect
        self._n_served: Counter[str] = Counter()
        self._n_spare = 0
        self.turns = Turns()

    @property
    def n_served(self) -> int:
        """Number of connections that are served."""
        return self._n_served.total()

    def acquire(self, address: str) -> ConnectionSlot | None:
        """Return a slot for a new connection; None if it is to be closed at once."""
        if not self._may_connect(address):
            return None
        source = _source(address)
        is_bounded = not self._is_proxy(address)
        if self.n_served < self._at_once and not (
            is_bounded and self._n_served[source] >= self._per_address
        ):
            self._n_served[source] += 1
            return ConnectionSlot(source, False, lambda: self._release(source))
        if self._n_spare < N_SPARE:
            self._n_spare += 1
            return ConnectionSlot(source, True, self._release_spare)
        return None

    def _release(self, source: str) -> None:
        self._n_served[source] -= 1
        if not self._n_served[source]:
            del self._n_served[source]

    def _release_spare(self) -> None:
        self._n_spare -= 1


class Turns:
    """Takes in what connections receive one after the other, so that games go on between them.

    Otherwise sixty requests that arrive together are parsed and begun in one go, which takes the
    event loop the time of four frames. Addresses take turns, and so do the connections of each.
    There are fewer turns while the loop is late.

    Args:
        every_s: Least time from one turn to the next.
    """

    def __init__(self, every_s: float = TURN_EVERY_S) -> None:
        self._every_s = every_s
        self._waiting: OrderedDict[str, deque[Callable[[], None]]] = OrderedDict()
        self._next_s = 0.0
        self._timer: asyncio.TimerHandle | None = None

    def take(self, address: str, work: Callable[[], None]) -> None:
        """Do work in its turn, which is now if nobody waits and the last turn is long ago."""
        loop = asyncio.get_running_loop()
        if self._timer is None and loop.time() >= self._next_s:
            self._run(work, loop)
            return
        self._waiting.setdefault(address, deque()).append(work)
        if self._timer is None:
            self._timer = loop.call_at(self._next_s, self._run_next)

    def _run_next(self) -> None:
        loop = asyncio.get_running_loop()
        late_s = loop.time() - self._next_s
        address, queue = self._waiting.popitem(last=False)
        work = queue.popleft()
        if queue:
            self._waiting[address] = queue
        self._timer = None
        try:
            self._run(work, loop, late_s)
        finally:
            if self._waiting and self._timer is None:
                self._timer = loop.call_at(self._next_s, self._run_next)

    def _run(
        self, work: Callable[[], None], loop: asyncio.AbstractEventLoop, late_s: float = 0.0
    ) -> None:
        self._next_s = loop.time() + min(self._every_s + late_s, MOST_EVERY_S)
        work()


def _source(address: str) -> str:
    """Return the source of a connection: an IPv4 address, or an IPv6 network."""
    parsed = parse_address(address)
    if isinstance(parsed, IPv6Address):
        return str(ip_network((parsed, _IPV6_NETWORK), strict=False))
    return address if parsed is None else str(parsed)
