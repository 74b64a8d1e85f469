"""Writes tests/data/games.json: games as the API shows them, for the tests of the page.

``python -m tests.server.api.games_data`` writes it anew; a test holds it against the code.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from server.api.catalogue import game_view

PATH = Path(__file__).parents[2] / "data" / "games.json"
GAMES = ("space_invaders", "pong", "ms_pacman", "gym:CartPole-v1", "gym:Blackjack-v1")


def games() -> dict[str, dict[str, Any]]:
    """Return the games by name, whatever version of Tril shows them."""
    return {
        name: game_view(name).model_dump(mode="json")
        | {"picture_url": f"/api/catalogue/pictures/{name}?v=1"}
        for name in GAMES
    }


if __name__ == "__main__":
    PATH.write_text(json.dumps(games(), separators=(",", ":")) + "\n")
