"""Internet addresses, as settings name them and connections have them."""

from __future__ import annotations

from ipaddress import (
    IPv4Address,
    IPv4Network,
    IPv6Address,
    IPv6Network,
    ip_address,
    ip_network,
)

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
