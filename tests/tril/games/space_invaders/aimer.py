"""The player of tests/data/long-game.json: it reads the RAM and looks ahead on saved consoles."""

import json
from collections.abc import Sequence
from itertools import groupby

from tests.tril.conftest import LONG_GAME_FRAMES, LONG_START
from testsupport.space_invaders import ram
from tril.games.space_invaders import SPACE_INVADERS
from tril.games.space_invaders import memory as game
from tril.games.space_invaders.grid import missile_in_air, player_hit
from tril.games.space_invaders.memory import Action
from tril.games.space_invaders.readout import alien_grid
from tril.play.episode import Episode

FRAMES_PER_DECISION = 2
FLIGHT_FRAMES = 60
DANGER_FRAMES = 28


def clear_columns(episode: Episode, columns: Sequence[int]) -> None:
    """Play until these columns are empty, one after the other, or the episode ends."""
    for column in columns:
        while episode.end is None and alien_grid(episode.readout).alive[:, column].any():
            aim = _aim(episode, column)
            if not missile_in_air(ram(episode.console)) and _hits_in(episode, column):
                aim = Action.FIRE
            action = _safe(episode, aim)
            for _ in range(FRAMES_PER_DECISION):
                if episode.end is None:
                    episode.advance(action)


def _aim(episode: Episode, column: int) -> Action:
    memory = ram(episode.console)
    alien = int(memory[game.RAM_ALIEN_X]) + game.COLUMN_WIDTH * (
        column - alien_grid(episode.readout).shifts
    )
    # Sweep around the column: the aliens move and the shields are in the way.
    sweep = episode.frame // 8 % 25 - 12
    want = alien + game.ALIEN_CENTRE - game.MISSILE_OFFSET + sweep
    want = min(max(want, game.PLAYER_LEFT_WALL), game.PLAYER_RIGHT_WALL)
    player = int(memory[game.RAM_PLAYER_X])
    if abs(player - want) <= 1:
        return Action.NOOP
    return Action.RIGHT if player < want else Action.LEFT


def _hits_in(episode: Episode, column: int) -> bool:
    """Tell whether a shot now hits an alien of this column."""
    saved = episode.save()
    hits = len(episode.taken)
    for frame in range(FLIGHT_FRAMES):
        if episode.end is not None or len(episode.taken) > hits:
            break
        episode.advance(Action.FIRE if frame < FRAMES_PER_DECISION else Action.NOOP)
    result = len(episode.taken) > hits and episode.taken[-1].column == column
    episode.restore(saved)
    return result


def _safe(episode: Episode, wanted: Action) -> Action:
    """Return the wanted action, or one after which the player is not hit soon."""
    console = episode.console
    memory = ram(console)
    if not any(memory[y] for y, _ in game.RAM_BOMBS):
        return wanted
    saved = console.save()
    best, longest = wanted, -1
    for action in (wanted, Action.NOOP, Action.RIGHT, Action.LEFT):
        console.restore(saved)
        survived = 0
        while survived < DANGER_FRAMES and not player_hit(ram(console)):
            console.act(action)
            survived += 1
        if survived > longest:
            best, longest = action, survived
        if survived == DANGER_FRAMES:
            break
    console.restore(saved)
    return best


if __name__ == "__main__":
    played = Episode(SPACE_INVADERS.make_console(), LONG_START, max_frames=LONG_GAME_FRAMES)
    clear_columns(played, range(game.COLUMNS))
    print(json.dumps([[action, len(list(held))] for action, held in groupby(played.actions)]))
