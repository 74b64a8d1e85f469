"""Cookies and keys of people in tests."""

from __future__ import annotations

from server.web.security import cookie_name, load_secrets
from tril.settings import Settings
from tril.store import players
from tril.store.access import credentials
from tril.store.database import create_database


def cookie_of(settings: Settings, player_id: int | None = None) -> tuple[str, str]:
    """Sign a browser in, by default the owner's, and return its cookie's name and value."""
    database = create_database(settings.application_url)
    try:
        with database.writing() as session:
            person = players.owner(session).id if player_id is None else player_id
            secret = credentials.sign_in(session, person, "Test")
    finally:
        database.close()
    return cookie_name(settings), load_secrets(settings.token_file).signed(secret)
