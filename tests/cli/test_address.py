"""What ``tril address`` prints."""

from __future__ import annotations

from pathlib import Path
from urllib.parse import parse_qs, urlsplit

import pytest
from typer.testing import CliRunner

from cli.main import app
from server.web.security import is_token
from tril.settings import Settings


def test_the_address_opens_the_server_of_this_data_folder(
    data_folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("TRIL_HOST", "0.0.0.0")
    monkeypatch.setenv("TRIL_PORT", "8123")
    result = CliRunner().invoke(app, ["address"])
    assert result.exit_code == 0
    address = urlsplit(result.stdout.strip())
    assert address.netloc == "127.0.0.1:8123"
    (token,) = parse_qs(address.query)["token"]
    assert is_token(Settings().token_file, token)
    assert data_folder.exists()
