"""Addresses as settings name them."""

from __future__ import annotations

import pytest

from tril.addresses import TcpAddress, parse_tcp_address
from tril.settings import Settings


@pytest.mark.parametrize(
    ("text", "address"),
    [
        ("127.0.0.1:7000", TcpAddress("127.0.0.1", 7000, False)),
        ("tcp://gpu.example:7000", TcpAddress("gpu.example", 7000, False)),
        ("tls://[2001:db8::1]:7000", TcpAddress("2001:db8::1", 7000, True)),
    ],
)
def test_addresses_are_read_and_written(text: str, address: TcpAddress) -> None:
    assert parse_tcp_address(text) == address
    assert parse_tcp_address(str(address)) == address


@pytest.mark.parametrize(
    "text", ["gpu", "gpu:x", "gpu:0", "http://gpu:1", "tcp://:1", "tcp://u@gpu:1", "tcp://gpu:1/x"]
)
def test_what_is_no_address_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match=r"tls://gpu\.example:7000"):
        Settings(inference_address=text)


@pytest.mark.parametrize(
    ("host", "reached"), [("0.0.0.0", "127.0.0.1"), ("::", "::1"), ("gpu", "gpu")]
)
def test_a_process_that_listens_on_all_addresses_is_reached_on_this_machine(
    host: str, reached: str
) -> None:
    assert TcpAddress(host, 7, False).destination == (reached, 7)
