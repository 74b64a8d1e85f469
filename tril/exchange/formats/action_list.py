"""Plain action lists: a game that others recorded as one action per frame.

See docs/exchange-format.md. A list is rewritten as an object of the exchange format, so that
everything else reads one format.
"""

from __future__ import annotations

import base64
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from tril.errors import Invalid, NotFound
from tril.exchange.formats import recording_object
from tril.exchange.formats.recording_object import (
    MAX_GAME_NAME_LENGTH,
    normalise_json,
    truncated,
)
from tril.games import game_named
from tril.games.atari.joystick import ALL_ACTIONS, reduced_action
from tril.games.base import Controls, Game
from tril.recording import RecordingRefused

FORMAT = "tril-actions"
VERSION = 1
RESET = "reset"
"""The start right after the emulator's reset."""
MAX_REWARD = 1e9
MINIMAL, FULL = "minimal", "full"
"""What numbers of actions count: the game's own actions, or all of the emulator's."""

_SEPARATORS = re.compile(r"[\s,;]+")
_NUMBER = re.compile("[0-9]{1,4}")


@dataclass(frozen=True)
class ActionList:
    """An action list, rewritten.

    Attributes:
        content: The recording in the exchange format, not validated yet.
        rewards: Reward of every frame; None if the list has none.
        notices: Changes made while reading.
    """

    content: dict[str, Any]
    rewards: tuple[float, ...] | None
    notices: tuple[str, ...]


def is_action_list(content: object) -> bool:
    """Return whether parsed JSON calls itself an action list."""
    return isinstance(content, dict) and content.get("format") == FORMAT


def with_defaults(content: object, game: Game) -> object:
    """Give an action list the length and the end rule of a behaviour's game where it names none.

    Other content is returned as it is: what the exchange format leaves out is the game's own.
    """
    if not isinstance(content, dict) or not is_action_list(content):
        return content
    if content.get("game") != game.name:
        return content
    defaults = {"max_steps": game.settings.max_steps, "end_rule": game.settings.end_rule}
    missing = {name: value for name, value in defaults.items() if content.get(name) is None}
    return content | missing


def read_action_list(content: dict[str, Any]) -> ActionList:
    """Rewrite an action list in the exchange format.

    Raises:
        RecordingRefused: The game is not installed, or actions or rewards are not valid.
    """
    recording = dict(content)
    version = recording.pop("version", None)
    if isinstance(version, bool) or version != VERSION:
        raise RecordingRefused(
            f"Expected version {VERSION} of {FORMAT}, got {truncated(repr(version))}."
        )
    game = _game(recording.get("game"))
    numbers = recording.pop("numbers", None) or MINIMAL
    actions, notices = _actions(game, recording.pop("actions", None), numbers)
    rewards = _rewards(recording.pop("rewards", None), len(actions))
    start = recording.pop("start", None) or RESET
    recording |= {
        "format": recording_object.FORMAT,
        "version": recording_object.VERSION,
        "game_version": recording.get("game_version") or game.version,
        "start": _reset(game) if start == RESET else start,
        "actions": base64.b64encode(actions).decode("ascii"),
    }
    return ActionList(recording, rewards, tuple(notices))


def _game(name: object) -> Game:
    name = normalise_json(name)
    if not isinstance(name, str) or len(name) > MAX_GAME_NAME_LENGTH:
        raise RecordingRefused(
            f"game: expected the name of a game, as `tril games list` names it, got"
            f" {truncated(repr(name))}."
        )
    try:
        return game_named(name)
    except (Invalid, NotFound) as refusal:
        raise RecordingRefused(str(refusal)) from None


def _reset(game: Game) -> dict[str, int]:
    start = {"idle_frames": 0, "intro": 0}
    try:
        return game.starts.parse(start).to_json()
    except Invalid:
        example = game.starts.training[0].to_json()
        raise RecordingRefused(
            f"start: {game.title} has no start right after a reset; give one such as {example}."
        ) from None


def _actions(game: Game, content: object, numbers: object) -> tuple[bytes, list[str]]:
    """Return the actions, one byte per frame, and what is to be said of them."""
    if isinstance(content, str):
        words = [word for word in _SEPARATORS.split(content) if word]
        content = [int(word) if _NUMBER.fullmatch(word) else word for word in words]
    if not isinstance(content, list) or not content:
        raise RecordingRefused(
            "actions: expected a list with one action per frame, or a text with them, got"
            f" {truncated(repr(content))}."
        )
    if numbers not in (MINIMAL, FULL):
        raise RecordingRefused(
            f"numbers: expected {MINIMAL!r} or {FULL!r}, got {truncated(repr(numbers))}."
        )
    names = list(game.controls.actions)
    if numbers == FULL:
        if not set(names) <= set(ALL_ACTIONS):
            raise RecordingRefused(f"numbers: {game.title} is not played with a joystick.")
        names = list(ALL_ACTIONS)
    index = _Index(game.controls, names)
    try:
        actions = bytes(map(index.find, content))
    except KeyError:
        # Found a second time, as errors are rare and frames are many.
        frame = next(n for n, action in enumerate(content, start=1) if not index.has(action))
        raise RecordingRefused(
            f"Frame {frame}: expected an action from 0 to {len(names) - 1} or one of"
            f" {', '.join(names)}; got {truncated(repr(content[frame - 1]))}."
        ) from None
    return actions, index.notices(game, content)


class _Index:
    """Finds actions by number and by name.

    Args:
        controls: The game's.
        names: Names of the actions by number.
    """

    def __init__(self, controls: Controls, names: Sequence[str]) -> None:
        numbers = {name.upper(): number for number, name in enumerate(controls.actions)}
        self._found: dict[int | str, int] = {}
        self._reduced: dict[int | str, str] = {}
        joystick = set(controls.actions) <= set(ALL_ACTIONS)
        for name in {*names, *(ALL_ACTIONS if joystick else ())}:
            keys: list[int | str] = [name.upper()]
            keys += [names.index(name)] if name in names else []
            number = numbers.get(name.upper())
            if number is None:
                number = reduced_action(controls, name)
                self._reduced |= dict.fromkeys(keys, name)
            self._found |= dict.fromkeys(keys, number)

    def find(self, action: object) -> int:
        """Return the game's own number of an action; raises KeyError if there is none."""
        return self._found[_key(action)]

    def has(self, action: object) -> bool:
        """Return whether there is such an action."""
        try:
            return _key(action) in self._found
        except KeyError:
            return False

    def notices(self, game: Game, actions: Sequence[object]) -> list[str]:
        """Describe how actions that the game lacks were read."""
        if not self._reduced:
            return []
        counts = Counter(self._reduced.get(_key(action)) for action in actions)
        del counts[None]
        if not counts:
            return []
        controls = game.controls
        parts = [
            f"{name} ({count:,} frames) was read as"
            f" {controls.actions[reduced_action(controls, name)]}"
            for name, count in counts.most_common()
            if name is not None
        ]
        return [f"{game.title} has fewer actions: {truncated('; '.join(parts), 300)}."]


def _key(action: object) -> int | str:
    """Return the key of an action in the index; raises KeyError for other values."""
    if isinstance(action, str):
        return action.upper()
    if isinstance(action, float) and action.is_integer():
        return int(action)
    if isinstance(action, int) and not isinstance(action, bool):
        return action
    raise KeyError(action)


def _rewards(rewards: object, n_actions: int) -> tuple[float, ...] | None:
    if rewards is None:
        return None
    if not isinstance(rewards, list):
        raise RecordingRefused(
            f"rewards: expected a list with one number per frame, got {truncated(repr(rewards))}."
        )
    for frame, reward in enumerate(rewards, start=1):
        is_number = isinstance(reward, int | float) and not isinstance(reward, bool)
        if not is_number or not abs(reward) <= MAX_REWARD:
            raise RecordingRefused(
                f"rewards: expected a number for frame {frame}, got {truncated(repr(reward))}."
            )
    if len(rewards) != n_actions:
        raise RecordingRefused(
            f"rewards: expected one for each of the {n_actions:,} actions, got {len(rewards):,}."
        )
    return tuple(map(float, rewards))
