"""Which browser the browser tests run in, and where it comes from."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

from scripts import browser
from scripts.browser import NoBrowser, can_use_apt, find_browser
from tests.setup.programs import put_program

DEBIAN = 'PRETTY_NAME="Debian GNU/Linux 12"\nID=debian\n'
UBUNTU = "ID=ubuntu\nID_LIKE=debian\n"
STARTS = "echo Chromium 150.0"
FAILS = "echo 'libnss3.so is missing' >&2; exit 127"


@pytest.fixture
def programs(tmp_path: Path) -> Path:
    """Return a folder that is the whole PATH."""
    folder = tmp_path / "programs"
    folder.mkdir()
    return folder


@pytest.fixture(autouse=True)
def bare_machine(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Be an ordinary user of no known system, with no download of Playwright's."""
    monkeypatch.setattr(os, "geteuid", lambda: 1000)
    monkeypatch.setattr(browser, "OS_RELEASE", tmp_path / "os-release")
    monkeypatch.setattr(browser, "_playwright_path", lambda: None)
    monkeypatch.setattr(sys, "executable", str(tmp_path / "no-python"))


def find(programs: Path, **environ: str) -> Path:
    return find_browser({"PATH": str(programs), **environ})


def test_what_chromium_names_goes_first(programs: Path, tmp_path: Path) -> None:
    put_program(programs, "chromium", STARTS)
    mine = put_program(tmp_path / "mine", "my-chromium", STARTS)
    assert find(programs, CHROMIUM=str(mine)) == mine


@pytest.mark.parametrize("script", [None, FAILS], ids=["missing", "does not start"])
def test_a_wrong_chromium_is_an_error_and_not_replaced_in_silence(
    programs: Path, tmp_path: Path, script: str | None
) -> None:
    put_program(programs, "chromium", STARTS)
    if script is not None:
        put_program(tmp_path / "mine", "my-chromium", script)
    with pytest.raises(NoBrowser, match="CHROMIUM names"):
        find(programs, CHROMIUM=str(tmp_path / "mine/my-chromium"))


@pytest.mark.parametrize("name", browser.NAMES)
def test_each_known_name_on_the_path_is_found(programs: Path, name: str) -> None:
    program = put_program(programs, name, STARTS)
    assert find(programs) == program


def test_a_stub_that_does_not_start_is_passed_over(programs: Path) -> None:
    put_program(programs, "chromium", FAILS)
    chrome = put_program(programs, "google-chrome", STARTS)
    assert find(programs) == chrome


def test_root_on_debian_gets_debians_package(
    programs: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(os, "geteuid", lambda: 0)
    (tmp_path / "os-release").write_text(DEBIAN)
    put_program(tmp_path, "packaged", STARTS)
    log = tmp_path / "apt.log"
    put_program(
        programs,
        "apt-get",
        f'echo "$@" >> {log}\n'
        f'[ "$1" = update ] || /bin/cp {tmp_path / "packaged"} {programs / "chromium"}',
    )
    assert find(programs) == programs / "chromium"
    assert log.read_text().splitlines() == [
        "update",
        "install --yes --no-install-recommends chromium",
    ]


@pytest.mark.parametrize(
    ("user_id", "os_release", "reason"),
    [
        (0, DEBIAN, None),
        (1000, DEBIAN, "needs root"),
        (0, UBUNTU, "not Debian"),
        (0, "", "not Debian"),
    ],
)
def test_apt_is_asked_as_root_on_debian_only(
    programs: Path, user_id: int, os_release: str, reason: str | None
) -> None:
    put_program(programs, "apt-get", "exit 0")
    answer = can_use_apt(user_id, str(programs), os_release)
    assert answer is None if reason is None else reason in str(answer)


def test_playwrights_download_is_taken_where_nothing_else_is(
    programs: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    target = tmp_path / "playwright/chrome"
    put_program(tmp_path, "packaged", STARTS)
    python = put_program(
        tmp_path,
        "no-python",
        '[ "$*" = "-m playwright install chromium" ] || exit 1\n'
        f"/bin/mkdir -p {target.parent} && /bin/cp {tmp_path / 'packaged'} {target}",
    )
    monkeypatch.setattr(sys, "executable", str(python))
    monkeypatch.setattr(browser, "_playwright_path", lambda: target)
    assert find(programs) == target


def test_without_any_browser_the_message_says_what_was_tried_and_what_to_do(
    programs: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(NoBrowser) as caught:
        find(programs)
    message = str(caught.value)
    assert "no chromium, google-chrome" in message
    assert "not Debian" in message
    assert "Playwright could not download its own" in message
    assert "CHROMIUM=/path/to/chromium make test" in message
    assert "no-python" in capfd.readouterr().err


@pytest.mark.e2e
def test_the_browser_of_this_machine_starts(chromium: Path) -> None:
    assert browser.starts(str(chromium))
