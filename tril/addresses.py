"""Internet addresses, as settings name them and connections have them."""

from __future__ import annotations

from dataclasses import dataclass
from ipaddress import (
    IPv4Address,
    IPv4Network,
    IPv6Address,
    IPv6Network,
    ip_address,
    ip_network,
)
from urllib.parse import urlsplit

Address = IPv4Address | IPv6Address
Network = IPv4Network | IPv6Network


def parse_address(text: str) -> Address | None:
    """Return an address, None if it is none; an IPv4 address written as IPv6 becomes IPv4."""
    try:
        address = ip_address(text)
    except ValueError:
        return None
    mapped = address.ipv4_mapped if isinstance(address, IPv6Address) else None
    return mapped or address


def parse_networks(text: str) -> tuple[Network, ...]:
    """Parse addresses and networks, comma-separated.

    Raises:
        ValueError: One of them is neither; says which.
    """
    return tuple(ip_network(part.strip(), strict=False) for part in text.split(",") if part.strip())


def is_loopback(host: str) -> bool:
    """Whether a host, by name or address, is reached from its own machine alone."""
    address = parse_address(host)
    return host == "localhost" if address is None else address.is_loopback


@dataclass(frozen=True)
class TcpAddress:
    """Where a process answers.

    Attributes:
        host: Name or address, an IPv6 one without brackets.
        port: The port.
        is_encrypted: Whether the endpoint speaks TLS.
    """

    host: str
    port: int
    is_encrypted: bool

    def __str__(self) -> str:
        scheme = "tls" if self.is_encrypted else "tcp"
        return f"{scheme}://{f'[{self.host}]' if ':' in self.host else self.host}:{self.port}"

    @property
    def is_local(self) -> bool:
        """Whether only its own machine reaches it."""
        return is_loopback(self.host)

    @property
    def destination(self) -> tuple[str, int]:
        """Host and port to connect to: where it listens on all addresses, this machine."""
        address = parse_address(self.host)
        if address is None or not address.is_unspecified:
            return self.host, self.port
        return ("127.0.0.1" if address.version == 4 else "::1"), self.port


def parse_tcp_address(text: str) -> TcpAddress:
    """Parse ``tcp://HOST:PORT``, ``tls://HOST:PORT`` or ``HOST:PORT``, which means tcp.

    Raises:
        ValueError: It is none of these.
    """
    parts = urlsplit(text if "://" in text else f"tcp://{text}")
    try:
        port = parts.port
    except ValueError:
        port = None
    is_plain = not (parts.path or parts.query or parts.fragment or "@" in parts.netloc)
    if parts.scheme not in {"tcp", "tls"} or not parts.hostname or not port or not is_plain:
        raise ValueError(
            f"expected an address such as tls://gpu.example:7000, or with tcp://, got {text!r}"
        )
    return TcpAddress(parts.hostname, port, parts.scheme == "tls")
