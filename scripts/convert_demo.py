"""Convert demonstrations of openai/atari-reset into action lists that Tril imports.

    python -m scripts.convert_demo Pong.demo --game pong > pong.json
    tril recordings import pong.json -b BEHAVIOUR

Such a file is a pickle with the action and the reward of every frame, played right after a reset
without a frame skip. Nothing but plain values and NumPy's numbers is unpickled: a pickle could
otherwise run any code.
"""

from __future__ import annotations

import argparse
import json
import pickle
import sys
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

_NUMPY = {
    ("numpy", "dtype"): np.dtype,
    ("numpy", "ndarray"): np.ndarray,
    # Where they are since NumPy 2, by what protocol 2 of a scalar and of an array names.
    **{
        (f"numpy.{core}.multiarray", function): constructor
        for core in ("core", "_core")
        for function, constructor in (
            ("scalar", np.float64(0).__reduce__()[0]),
            ("_reconstruct", np.empty(0).__reduce__()[0]),
        )
    },
}


class RestrictedUnpickler(pickle.Unpickler):
    """Reads pickles of plain values and of NumPy's scalars and arrays."""

    def find_class(self, module: str, name: str) -> Any:
        """Return one of the few constructors that are allowed; raises UnpicklingError."""
        try:
            return _NUMPY[module, name]
        except KeyError:
            raise pickle.UnpicklingError(f"{module}.{name} is not allowed here.") from None


def convert(file: BinaryIO, game: str) -> dict[str, Any]:
    """Return a demonstration as an action list.

    Raises:
        UnpicklingError: It holds something else than numbers, texts and lists of them.
        ValueError: It has no actions, or not one reward for each.
    """
    demonstration = RestrictedUnpickler(file).load()
    if not isinstance(demonstration, dict) or "actions" not in demonstration:
        raise ValueError("Expected a demonstration with its actions.")
    actions = [int(action) for action in demonstration["actions"]]
    rewards = [float(reward) for reward in demonstration.get("rewards", ())]
    if len(rewards) == len(actions) + 1:
        del rewards[0]  # that of the reset
    if rewards and len(rewards) != len(actions):
        raise ValueError(f"Expected {len(actions)} rewards, got {len(rewards)}.")
    return {
        "format": "tril-actions",
        "version": 1,
        "game": game,
        "start": "reset",
        "actions": actions,
        "rewards": [int(r) if r.is_integer() else r for r in rewards] or None,
        "source": "person",
    }


def main() -> None:
    """Convert a file and print the list."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("file", type=Path, help="a .demo file")
    parser.add_argument("--game", required=True, help="as `tril games list` names it")
    given = parser.parse_args()
    with given.file.open("rb") as file:
        json.dump(convert(file, given.game), sys.stdout, separators=(",", ":"))


if __name__ == "__main__":
    main()
