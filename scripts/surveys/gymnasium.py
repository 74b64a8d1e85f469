"""Which environments of Gymnasium, MiniGrid and highway-env can be played; writes listing.json.

    python -m scripts.surveys.gymnasium            # takes some minutes
    python -m scripts.surveys.gymnasium MODULE     # prints what it finds of another package

Each is examined in two processes, whose strings have different hashes: sets must not matter.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Sequence
from importlib import import_module

import gymnasium
from gymnasium.envs.registration import find_highest_version, parse_env_id

from tril.errors import Invalid
from tril.games.gymnasium.environment import PREFIX, find
from tril.games.gymnasium.family import examine
from tril.games.gymnasium.listing import LISTING

MODULES = ("gymnasium", "minigrid", "highway_env")
NOT_LISTED = ("phys2d/", "tabular/", "GymV", "BabyAI-")
"""Need JAX, are no environments, or have tasks that their pictures do not show."""

_PROGRAM = (
    "import sys; from scripts.surveys.gymnasium import print_digest; print_digest(sys.argv[1])"
)
_FAILED = "failed: "


def ids_of(module: str) -> list[str]:
    """Return the newest versions of the environments that a module registers."""
    import_module(module)
    return [
        env_id
        for env_id, spec in gymnasium.registry.items()
        if str(spec.entry_point).partition(":")[0].partition(".")[0] == module
        and not env_id.startswith(NOT_LISTED)
        and _is_newest(env_id)
    ]


def _is_newest(env_id: str) -> bool:
    namespace, name, version = parse_env_id(env_id)
    return version == find_highest_version(namespace, name)


def requirements(module: str, env_id: str) -> list[str]:
    """Return further packages needed to draw an environment."""
    if module != "gymnasium":
        return []
    entry_point = str(gymnasium.registry[env_id].entry_point)
    return ["pygame", "Box2D"] if ".box2d" in entry_point else ["pygame"]


def print_digest(name: str) -> None:
    """Print the digest of an environment's pictures, or why it cannot be played."""
    try:
        digest = examine(find(name)).digest
    except Invalid as error:
        digest = f"{_FAILED}{error}"
    sys.stdout.write(digest + "\n")


def _digest(name: str, hash_seed: int) -> str:
    played = subprocess.run(
        [sys.executable, "-c", _PROGRAM, name],
        env=os.environ | {"PYTHONHASHSEED": str(hash_seed)},
        capture_output=True,
        check=False,
        text=True,
    )
    lines = played.stdout.splitlines()
    return lines[-1] if lines and played.returncode == 0 else f"{_FAILED}{played.stderr[-300:]}"


def refusal(name: str) -> str | None:
    """Return why an environment cannot be played, None if it can be."""
    digest = _digest(name, 1)
    if digest.startswith(_FAILED):
        return digest.removeprefix(_FAILED)
    return None if _digest(name, 2) == digest else "Its pictures differ from process to process."


def main(modules: Sequence[str]) -> None:
    """Write the listing, or print what is found of other modules."""
    listing = {}
    for module in modules or MODULES:
        for env_id in ids_of(module):
            reason = refusal(f"{PREFIX}{module}:{env_id}")
            if reason is None:
                listing[env_id] = {"module": module, "requires": requirements(module, env_id)}
            sys.stdout.write(f"{env_id}: {reason or 'works'}\n")
            sys.stdout.flush()
    if not modules:
        lines = [f"{json.dumps(env_id)}: {json.dumps(listing[env_id])}" for env_id in listing]
        LISTING.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
