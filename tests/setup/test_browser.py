"""Which browser the browser tests run in, and where it comes from."""

from __future__ import annotations

import os
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from tests.setup.programs import put_program
from testsupport import browser
from testsupport.browser import find_chromium, install_chromium

STARTS = "echo Chromium 150.0"
FAILS = "echo 'libnss3.so is missing' >&2; exit 127"


@pytest.fixture(autouse=True)
def programs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a folder that is the whole PATH of an ordinary user of no known system."""
    folder = tmp_path / "programs"
    folder.mkdir()
    monkeypatch.setenv("PATH", str(folder))
    monkeypatch.delenv("CHROMIUM", raising=False)
    monkeypatch.setattr(os, "geteuid", lambda: 1000)
    monkeypatch.setattr(browser, "OS_RELEASE", tmp_path / "os-release")
    monkeypatch.setattr(sys, "executable", str(put_program(folder, "python", "exit 1")))
    return folder


@pytest.fixture
def apt_log(tmp_path: Path, programs: Path) -> Path:
    """Return what apt-get was asked for; it installs a chromium that starts."""
    (tmp_path / "os-release").write_text('PRETTY_NAME="Debian GNU/Linux 12"\nID=debian\n')
    packaged = put_program(tmp_path, "packaged", STARTS)
    log = tmp_path / "apt.log"
    # It takes a moment, so that others ask for it in the meantime.
    copy = f'[ "$1" = update ] || {{ /bin/sleep 0.2; /bin/cp {packaged} {programs / "chromium"}; }}'
    put_program(programs, "apt-get", f'echo "$@" >> {log}\n{copy}')
    return log


def test_what_chromium_names_goes_first(
    programs: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    put_program(programs, "chromium", STARTS)
    mine = str(put_program(tmp_path / "mine", "my-chromium", STARTS))
    monkeypatch.setenv("CHROMIUM", mine)
    assert find_chromium() == mine


@pytest.mark.parametrize("script", [None, FAILS], ids=["missing", "does not start"])
def test_a_wrong_chromium_is_an_error_and_not_replaced_in_silence(
    programs: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, script: str | None
) -> None:
    put_program(programs, "chromium", STARTS)
    if script is not None:
        put_program(tmp_path / "mine", "my-chromium", script)
    monkeypatch.setenv("CHROMIUM", str(tmp_path / "mine/my-chromium"))
    with pytest.raises(RuntimeError, match="CHROMIUM names"):
        find_chromium()


def test_a_stub_that_does_not_start_is_passed_over(programs: Path) -> None:
    put_program(programs, "chromium", FAILS)
    chrome = put_program(programs, "google-chrome", STARTS)
    assert find_chromium() == str(chrome)


def test_nothing_is_installed_where_there_is_a_browser(programs: Path, apt_log: Path) -> None:
    put_program(programs, "chromium", STARTS)
    install_chromium()
    assert not apt_log.exists()


def test_root_on_debian_gets_debians_package(
    programs: Path, apt_log: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(os, "geteuid", lambda: 0)
    install_chromium()
    assert find_chromium() == str(programs / "chromium")
    assert apt_log.read_text(encoding="utf-8").splitlines() == [
        "update",
        "install --yes --no-install-recommends chromium",
    ]


def test_processes_that_ask_at_once_wait_for_one_to_install(
    programs: Path, apt_log: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(os, "geteuid", lambda: 0)
    # Each opens the lock anew, as processes of their own would.
    with ThreadPoolExecutor(3) as pool:
        asked = [pool.submit(install_chromium) for _ in range(3)]
    assert [one.exception() for one in asked] == [None] * 3
    assert find_chromium() == str(programs / "chromium")
    assert len(apt_log.read_text(encoding="utf-8").splitlines()) == 2


def test_everybody_else_gets_playwrights_download(programs: Path, apt_log: Path) -> None:
    put_program(programs, "python", f'echo "$@" >> {programs / "log"}')
    install_chromium()
    assert (programs / "log").read_text() == "-m playwright install chromium\n"
    assert not apt_log.exists()


def test_without_any_browser_the_message_says_what_to_do() -> None:
    with pytest.raises(RuntimeError, match="CHROMIUM=/path/to/chromium make test"):
        install_chromium()
