"""Compare constraints.txt with what is installed: every package the project needs is pinned.

``python scripts/pins.py`` lists what is wrong; ``--write`` writes the installed versions.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator, Mapping
from importlib.metadata import Distribution, PackageNotFoundError, distribution
from pathlib import Path

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name
from packaging.version import Version

CONSTRAINTS = Path(__file__).resolve().parent.parent / "constraints.txt"
PROJECT = "tril"
BUILD = ("setuptools",)
"""What building the project needs; its metadata does not list that."""

UNPINNED = re.compile(r"nvidia-.*|cuda-.*|triton")
"""What only torch's CUDA builds bring in; torch itself pins these exactly."""


def read_pins(text: str) -> dict[str, str]:
    """Return the version of each package that a constraints file pins.

    Raises:
        ValueError: A line is neither a comment nor ``name==version``.
    """
    pins: dict[str, str] = {}
    for line in text.splitlines():
        if not line.strip() or line.startswith("#"):
            continue
        match = re.fullmatch(r"([a-z0-9-]+)==([0-9][0-9a-z.]*)", line)
        if match is None:
            raise ValueError(f"Expected 'name==version' in constraints.txt, got '{line}'.")
        pins[match[1]] = match[2]
    return pins


def installed_dependencies() -> dict[str, str | None]:
    """Return every package the project needs here, extras included, with its installed version.

    A package of an extra that is not installed has None.
    """
    versions: dict[str, str | None] = {}
    waiting = [Requirement(name) for name in BUILD] + list(_needs(distribution(PROJECT), None))
    seen: set[tuple[str, frozenset[str]]] = set()
    while waiting:
        requirement = waiting.pop()
        name = canonicalize_name(requirement.name)
        key = (name, frozenset(requirement.extras))
        if key in seen or UNPINNED.fullmatch(name):
            continue
        seen.add(key)
        try:
            found = distribution(name)
        except PackageNotFoundError:
            versions[name] = None
            continue
        versions[name] = Version(found.version).public
        waiting.extend(_needs(found, requirement.extras))
    return versions


def _needs(package: Distribution, extras: set[str] | None) -> Iterator[Requirement]:
    """Yield what a package needs on this machine; extras=None stands for all its extras."""
    if extras is None:
        extras = set(package.metadata.get_all("Provides-Extra") or ())
    for text in package.requires or ():
        requirement = Requirement(text)
        markers = [{"extra": extra} for extra in sorted(extras)] or [{"extra": ""}]
        if requirement.marker is None or any(map(requirement.marker.evaluate, markers)):
            yield requirement


def differences(pins: Mapping[str, str], installed: Mapping[str, str | None]) -> list[str]:
    """Return a sentence for every package whose pin is missing or different."""
    wrong = []
    for name, version in sorted(installed.items()):
        if name not in pins:
            wrong.append(f"{name} {version or '(not installed)'} is needed, but not pinned.")
        elif version is not None and pins[name] != version:
            wrong.append(f"{name} is pinned to {pins[name]}, but {version} is installed.")
    return wrong


def updated(pins: Mapping[str, str], installed: Mapping[str, str | None]) -> dict[str, str]:
    """Return the pins of what is installed, keeping those of extras that are not installed here.

    What such a package needs in turn is not known here; pins that start with its name are kept.
    """
    absent = tuple(name for name, version in installed.items() if version is None)
    kept = {name: version for name, version in pins.items() if name.startswith(absent)}
    return kept | {name: version for name, version in installed.items() if version is not None}


def main(arguments: list[str]) -> int:
    """Report, or with ``--write`` remove, every difference."""
    text = CONSTRAINTS.read_text()
    pins = read_pins(text)
    installed = installed_dependencies()
    if arguments == ["--write"]:
        comments = [line for line in text.splitlines() if line.startswith("#")]
        lines = [f"{name}=={version}" for name, version in sorted(updated(pins, installed).items())]
        CONSTRAINTS.write_text("\n".join([*comments, *lines]) + "\n")
        return 0
    wrong = differences(pins, installed)
    print("\n".join(wrong) if wrong else f"{len(pins)} pins, all as installed")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
