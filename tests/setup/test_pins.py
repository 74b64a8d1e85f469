"""Every package that an install brings in is pinned, and nothing else is said about it."""

from __future__ import annotations

import re
import subprocess
import tomllib
from itertools import chain
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from scripts.pins import differences, installed_dependencies, read_pins, updated

ROOT = Path(__file__).resolve().parents[2]
PINS = read_pins((ROOT / "constraints.txt").read_text())


def test_every_installed_dependency_is_pinned_to_what_is_installed() -> None:
    assert differences(PINS, installed_dependencies()) == []


def test_every_declared_requirement_is_pinned_within_its_range() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    groups = [project["dependencies"], *project["optional-dependencies"].values()]
    for requirement in map(Requirement, chain.from_iterable(groups)):
        pin = PINS[canonicalize_name(requirement.name)]
        assert requirement.specifier.contains(pin), f"{requirement} excludes the pin {pin}"


def test_torch_is_pinned_for_any_build_and_no_cuda_package_is_asked_for() -> None:
    assert PINS["torch"] == "2.13.0"
    assert not [name for name in PINS if name.startswith(("nvidia", "cuda", "triton"))]


@pytest.mark.parametrize("line", ["torch==2.13.0+cpu", "torch>=2", "--find-links x", "-e ."])
def test_only_exact_public_versions_are_accepted(line: str) -> None:
    with pytest.raises(ValueError, match="name==version"):
        read_pins(line)


def test_missing_and_different_pins_are_named() -> None:
    wrong = differences({"a": "1", "b": "2"}, {"a": "1", "b": "3", "c": "4", "d": None})
    assert wrong == [
        "b is pinned to 2, but 3 is installed.",
        "c 4 is needed, but not pinned.",
        "d (not installed) is needed, but not pinned.",
    ]


def test_writing_keeps_the_pins_of_extras_that_are_not_installed_here() -> None:
    pins = {"a": "1", "gone": "5", "node": "24", "node-binaries": "24"}
    assert updated(pins, {"a": "2", "node": None}) == {
        "a": "2",
        "node": "24",
        "node-binaries": "24",
    }


def committed_files() -> list[Path]:
    listed = subprocess.run(
        ["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=True
    )
    return [ROOT / name for name in listed.stdout.split("\0") if name]


def test_no_committed_file_names_a_package_registry() -> None:
    # Written in two parts, so that this file names none either.
    hosts = ["pypi" + ".org", "pythonhosted" + ".org", "npmjs" + ".org", "deb.debian" + ".org"]
    hosts += ["download.pytorch" + ".org", "npmmirror" + ".com", "yarnpkg" + ".com"]
    found = {
        f"{path.relative_to(ROOT)}: {host}"
        for path in committed_files()
        if path.is_file()
        for host in hosts
        if host.encode() in path.read_bytes()
    }
    assert found == set()


def test_no_committed_file_names_a_persons_folder() -> None:
    personal = re.compile(rb"(?<![\w.}*])/(root|work|home|Users)/\w")
    assert personal.search(b"cd /" + b"home/ada") is not None
    found = {
        str(path.relative_to(ROOT))
        for path in committed_files()
        if path.is_file() and personal.search(path.read_bytes())
    }
    assert found == set()
