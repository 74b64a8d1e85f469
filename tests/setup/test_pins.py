"""Every package that an install brings in is pinned to what was tested."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator
from importlib.metadata import PackageNotFoundError, distribution, version
from itertools import chain
from pathlib import Path

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name
from packaging.version import Version

ROOT = Path(__file__).resolve().parents[2]
LINES = (ROOT / "constraints.txt").read_text().splitlines()
PINS = dict(line.split("==") for line in LINES if not line.startswith("#"))

CUDA = re.compile(r"nvidia-.*|cuda-.*|triton")
"""What only torch's CUDA builds bring in; torch itself pins these exactly."""


def declared() -> list[Requirement]:
    """Return what pyproject.toml asks for, for every purpose."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    groups = [project["dependencies"], *project["optional-dependencies"].values()]
    return [Requirement(text) for text in chain.from_iterable(groups)]


def installed() -> Iterator[str]:
    """Yield the pinned packages that are installed here; optional ones may not be."""
    for name in PINS:
        try:
            distribution(name)
        except PackageNotFoundError:
            continue
        yield name


def test_a_pin_is_an_exact_version_of_any_build() -> None:
    for name, pin in PINS.items():
        assert canonicalize_name(name) == name
        assert Version(pin).public == pin
        assert not CUDA.fullmatch(name)


def test_every_declared_requirement_is_pinned_within_its_range() -> None:
    for requirement in declared():
        pin = PINS[canonicalize_name(requirement.name)]
        assert requirement.specifier.contains(pin), f"{requirement} excludes the pin {pin}"


def test_what_is_installed_is_what_is_pinned() -> None:
    found = {name: Version(version(name)).public for name in installed()}
    assert found == {name: PINS[name] for name in found}, "run make constraints"


def test_what_a_pinned_package_needs_is_pinned() -> None:
    missing = {
        requirement.name
        for name in installed()
        for requirement in map(Requirement, distribution(name).requires or ())
        if requirement.marker is None or requirement.marker.evaluate({"extra": ""})
        if canonicalize_name(requirement.name) not in PINS
        if not CUDA.fullmatch(canonicalize_name(requirement.name))
    }
    assert missing == set(), "run make constraints"
