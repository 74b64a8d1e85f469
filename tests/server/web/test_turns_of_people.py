"""Whose turn a request takes."""

from __future__ import annotations

from typing import Any

from starlette.requests import HTTPConnection

from server.dependencies import client_of
from tril.store.access.credentials import Identity
from tril.store.models import CredentialKind, Role


def request_of(**more: Any) -> HTTPConnection:
    return HTTPConnection({"type": "http", "client": ("192.0.2.1", 5000), **more})


def identity(credential_id: int, kind: CredentialKind, player_id: int) -> Identity:
    return Identity(credential_id, kind, player_id, Role.RESEARCHER, frozenset(), "")


def test_a_person_has_one_turn_for_all_browsers_and_keys() -> None:
    shown = [
        identity(1, CredentialKind.BROWSER, 7),
        identity(2, CredentialKind.BROWSER, 7),
        identity(3, CredentialKind.KEY, 7),
    ]
    assert len({client_of(request_of(identity=one)) for one in shown}) == 1


def test_two_people_behind_one_address_have_a_turn_each() -> None:
    shown = [identity(number, CredentialKind.BROWSER, number) for number in (1, 2)]
    assert len({client_of(request_of(identity=one)) for one in shown}) == 2


def test_an_address_is_no_person() -> None:
    stranger = client_of(request_of())
    assert stranger == client_of(request_of())
    assert stranger != client_of(request_of(identity=identity(1, CredentialKind.BROWSER, 1)))
