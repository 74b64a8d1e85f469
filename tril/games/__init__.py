"""The games that can be taught, one module or package each; nothing else knows what is in a game.

Another package brings games of its own by entry points of the group "tril.games": each names a Game
or a GameFamily.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from importlib import import_module
from importlib.metadata import entry_points

from tril.errors import NotFound
from tril.games.base import Game, GameFamily
from tril.games.behaviours import Behaviour

DEFAULT_GAME = "space_invaders"
GROUP = "tril.games"

_GAMES: Mapping[str, str] = {
    DEFAULT_GAME: "tril.games.space_invaders:SPACE_INVADERS",
    "breakout": "tril.games.breakout:BREAKOUT",
}
"""Games with a module of their own, imported when they are asked for."""

_PUBLISHED = "tril.games.space_invaders.behaviours"

_FAMILIES: Sequence[str] = (
    "tril.games.atari.family:ATARI",
    "tril.games.gymnasium.family:GYMNASIUM",
)


class UnknownGame(NotFound):
    """There is no game of this name here."""


@cache
def game_named(name: str) -> Game:
    """Return a game.

    Raises:
        UnknownGame: There is none of this name, or what brings it is not installed.
        Invalid: It cannot be taught; says why.
    """
    if name in _GAMES:
        game = _load(_GAMES[name])
        if not isinstance(game, Game):
            raise TypeError(f"{_GAMES[name]} is not a Game.")
        return game
    for source in _sources():
        if isinstance(source, Game):
            if source.name == name:
                return source
        elif (game_of_family := source.game(name)) is not None:
            return game_of_family
    raise UnknownGame(f"There is no game {name!r} here. `tril games list` names those there are.")


def game_of(behaviour: Behaviour) -> Game:
    """Return the game of a behaviour as it sets it.

    Raises:
        UnknownGame: What brings the game is not installed.
    """
    return game_named(behaviour.game).with_settings(behaviour.settings)


def game_titles() -> dict[str, str]:
    """Return the titles of all games by name, in order of titles; makes none of them."""
    titles = {name: game_named(name).title for name in _GAMES}
    for source in _sources():
        source_titles = {source.name: source.title} if isinstance(source, Game) else source.titles()
        titles = {**source_titles, **titles}
    return dict(sorted(titles.items(), key=lambda item: item[1].casefold()))


def published() -> tuple[Behaviour, ...]:
    """Return the behaviours of the published work, which every data folder begins with."""
    behaviours: tuple[Behaviour, ...] = import_module(_PUBLISHED).BUILT_IN
    return behaviours


def ready_made(game: Game, slug: str) -> Behaviour:
    """Return a behaviour that comes with a game.

    Raises:
        NotFound: It has none of this short name; names those that it has.
    """
    for behaviour in game.behaviours:
        if behaviour.slug == slug:
            return behaviour
    slugs = ", ".join(behaviour.slug for behaviour in game.behaviours) or "none"
    raise NotFound(f"{game.title} has no ready-made behaviour {slug!r}; it has {slugs}.")


@cache
def _sources() -> tuple[Game | GameFamily, ...]:
    """Return the families, and what other packages bring."""
    families = [_load(reference) for reference in _FAMILIES]
    return (*families, *(entry.load() for entry in entry_points(group=GROUP)))


def _load(reference: str) -> Game | GameFamily:
    module, _, attribute = reference.partition(":")
    loaded: Game | GameFamily = getattr(import_module(module), attribute)
    return loaded
