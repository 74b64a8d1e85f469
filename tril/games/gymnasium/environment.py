"""Environments by name: where they are found, how they are made and what they draw."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cache
from importlib import import_module
from importlib.metadata import Distribution, distributions
from importlib.util import find_spec
from typing import Any

import cv2
import gymnasium
import numpy as np
from gymnasium.envs.registration import EnvSpec
from gymnasium.error import DependencyNotInstalled

from tril.errors import Invalid
from tril.games.base import Screen
from tril.games.gymnasium.listing import listed

PREFIX = "gym:"
LONGEST_SIDE = 320
"""Pixels. Larger pictures are reduced: a stream carries every frame, and learning sees 84 x 84."""

AnyEnv = gymnasium.Env[Any, Any]

_VERSION = re.compile(r"-v\d+$")
_REQUIREMENT = re.compile(r"gymnasium(?![\w.-])", re.IGNORECASE)
_INSTALL = 'Install what draws Gymnasium\'s environments: pip install "tril-imitation[gymnasium]".'

# Pictures are read from memory. Without these, pygame looks for a screen and a sound card. Not the
# video driver "dummy", at which highway-env draws nothing.
_NO_DEVICES = {
    "SDL_VIDEODRIVER": "offscreen",
    "SDL_AUDIODRIVER": "dummy",
    "PYGAME_HIDE_SUPPORT_PROMPT": "1",
}


class UnsuitableEnvironment(Invalid):
    """An environment that cannot be a game here."""


@dataclass(frozen=True)
class Environment:
    """A registered environment.

    Attributes:
        name: Name as a game, e.g. "gym:CartPole-v1".
        spec: Gymnasium's entry of it.
    """

    name: str
    spec: EnvSpec

    @property
    def title(self) -> str:
        """Its name for people."""
        return title_of(self.spec.id)

    def make(self) -> AnyEnv:
        """Make the environment, without a time limit: episodes have one of their own.

        Raises:
            UnsuitableEnvironment: It cannot be made, or draws no pictures.
        """
        for variable, value in _NO_DEVICES.items():
            os.environ.setdefault(variable, value)
        try:
            env = gymnasium.make(
                self.spec,
                max_episode_steps=-1,
                disable_env_checker=True,
                render_mode="rgb_array",
            )
        except ImportError as error:
            raise UnsuitableEnvironment(
                f"{self.name} cannot be made: {error}. {_INSTALL}"
            ) from error
        except DependencyNotInstalled as error:
            raise UnsuitableEnvironment(
                f"{self.name} cannot be made: {error}. {_INSTALL}"
            ) from error
        except Exception as error:  # an environment's own code may raise anything
            if "render_mode" in str(error):
                raise self.no_pictures() from error
            raise UnsuitableEnvironment(
                f"{self.name} cannot be made: {type(error).__name__}: {_sentence(error)}"
            ) from error
        if "rgb_array" not in (env.metadata.get("render_modes") or ()):
            raise self.no_pictures()
        return env

    def no_pictures(self) -> UnsuitableEnvironment:
        """Return the error for an environment without pictures."""
        return UnsuitableEnvironment(
            f'{self.name} draws no pictures: it has no render mode "rgb_array".'
        )

    def first_action(self, env: AnyEnv) -> int:
        """Return the number that the environment gives to its first action."""
        return int(self._actions(env).start)

    def n_actions(self, env: AnyEnv) -> int:
        """Return the number of actions.

        Raises:
            UnsuitableEnvironment: They are not discrete.
        """
        return int(self._actions(env).n)

    def _actions(self, env: AnyEnv) -> gymnasium.spaces.Discrete:
        space = env.action_space
        if not isinstance(space, gymnasium.spaces.Discrete):
            raise UnsuitableEnvironment(
                f"{self.name} has actions that no keys can be given to ({space}): only environments"
                " with discrete actions can be played."
            )
        return space

    @property
    def version(self) -> str:
        """What a replay depends on: the package and its version, at most 32 characters."""
        entry_point = self.spec.entry_point
        module = entry_point if isinstance(entry_point, str) else str(entry_point.__module__)
        top_level = module.partition(":")[0].partition(".")[0]
        for distribution in distributions():
            if top_level in _top_levels(distribution):
                return f"{distribution.name} {distribution.version}"[-32:]
        return f"gymnasium {gymnasium.__version__}"


@dataclass(frozen=True)
class Picture:
    """The pictures of an environment, all of one size.

    Attributes:
        name: The environment's name as a game.
        height: Of what it draws, in pixels.
        width: Likewise.
        factor: Whole number that both are divided by; a rest at the right and below is cut off.
        every_frame: Whether it has to be drawn at every frame, as it depends on those before.
    """

    name: str
    height: int
    width: int
    factor: int
    every_frame: bool = False

    @classmethod
    def first_of(cls, name: str, env: AnyEnv) -> Picture:
        """Return the size of the pictures of an environment that was reset.

        Raises:
            UnsuitableEnvironment: It cannot draw, or does not draw pictures of red, green and blue.
        """
        drawn = _drawn(name, env)
        if drawn.ndim != 3 or drawn.shape[2] != 3 or drawn.dtype != np.uint8 or not drawn.size:
            raise UnsuitableEnvironment(
                f"{name} cannot be shown: expected pictures uint8 (height, width, 3), got"
                f" {drawn.dtype} {drawn.shape}."
            )
        height, width, _ = drawn.shape
        return cls(name, height, width, -(-max(height, width) // LONGEST_SIDE))

    @property
    def shape(self) -> tuple[int, int, int]:
        """Shape of a screen."""
        return max(1, self.height // self.factor), max(1, self.width // self.factor), 3

    def of(self, env: AnyEnv) -> Screen:
        """Return the current screen, uint8 (height, width, 3) RGB, a fresh array.

        Raises:
            UnsuitableEnvironment: The picture has another size than the first one.
        """
        drawn = _drawn(self.name, env)
        if drawn.shape != (self.height, self.width, 3) or drawn.dtype != np.uint8:
            raise UnsuitableEnvironment(
                f"{self.name} cannot be shown: its pictures change from"
                f" {(self.height, self.width, 3)} to {drawn.shape}."
            )
        if self.factor == 1:
            return np.array(drawn, np.uint8, order="C")
        height, width, _ = self.shape
        cropped = np.ascontiguousarray(drawn[: height * self.factor, : width * self.factor])
        reduced = cv2.resize(cropped, (width, height), interpolation=cv2.INTER_AREA)
        return np.asarray(reduced, np.uint8)


def _drawn(name: str, env: AnyEnv) -> Any:
    try:
        drawn = env.render()
    except (ImportError, DependencyNotInstalled) as error:
        raise UnsuitableEnvironment(f"{name} cannot draw: {_sentence(error)} {_INSTALL}") from error
    if not isinstance(drawn, np.ndarray):
        raise UnsuitableEnvironment(
            f"{name} cannot be shown: expected pictures as arrays, got {type(drawn).__name__}."
        )
    return drawn


def _sentence(error: Exception) -> str:
    """Return an error's message with a full stop."""
    return f"{str(error).rstrip('.')}."


def find(name: str) -> Environment:
    """Return the environment of a game's name, "gym:ID" or "gym:MODULE:ID".

    Raises:
        UnsuitableEnvironment: There is none, or its module may not be imported.
    """
    module, colon, env_id = name.removeprefix(PREFIX).rpartition(":")
    if colon:
        _import(module, name)
    elif env_id in listed():
        _import(listed()[env_id].module, name)
    spec = gymnasium.registry.get(env_id)
    if spec is None:
        raise UnsuitableEnvironment(_unknown(env_id))
    if str(spec.entry_point).startswith("ale_py"):
        raise UnsuitableEnvironment(
            f"{env_id} is a game of the Atari 2600: Tril has it under a name of its own."
        )
    return Environment(name, spec)


def _unknown(env_id: str) -> str:
    ids = {*gymnasium.registry, *listed()}
    close_ids = get_close_matches(env_id, ids, n=3, cutoff=0.6)
    close_ids = close_ids or [
        name for name in ids if _VERSION.sub("", name) == _VERSION.sub("", env_id)
    ]
    suggestion = (
        f" Did you mean {' or '.join(f'{PREFIX}{name}' for name in close_ids)}?"
        if close_ids
        else ""
    )
    return (
        f"There is no Gymnasium environment {env_id!r} here.{suggestion} One of a package that"
        f" has to be imported first is named {PREFIX}MODULE:ID."
    )


def _import(module: str, name: str) -> None:
    """Import a module that registers environments, of a package that requires Gymnasium.

    Names come in from pages and files, so not every module may be imported by them.

    Raises:
        UnsuitableEnvironment: It is of no such package, or cannot be imported.
    """
    top_level = module.partition(".")[0]
    if top_level != "gymnasium" and top_level not in _environment_packages():
        raise UnsuitableEnvironment(
            f"{name} is not here: no package is installed that has a module {top_level!r} and"
            " requires gymnasium. Install it in the environment of Tril's processes."
        )
    try:
        import_module(module)
    except ImportError as error:
        raise UnsuitableEnvironment(f"{name} cannot be imported: {_sentence(error)}") from error


@cache
def _environment_packages() -> frozenset[str]:
    return frozenset(
        top_level
        for distribution in distributions()
        if any(_REQUIREMENT.match(required) for required in distribution.requires or ())
        for top_level in _top_levels(distribution)
    )


def _top_levels(distribution: Distribution) -> set[str]:
    """Return the names of a distribution's modules, as far as it tells."""
    modules = (distribution.read_text("top_level.txt") or "").split()
    # One that is installed as a link to its source lists no modules.
    return {*modules, distribution.name.replace("-", "_").lower()}


def title_of(env_id: str) -> str:
    """Return the name of an environment for people: "MiniGrid DoorKey 5x5"."""
    return _VERSION.sub("", env_id).replace("-", " ").replace("/", " ").replace("_", " ")


def titles() -> Mapping[str, str]:
    """Return the titles of the surveyed environments whose packages are installed, by name."""
    return {
        f"{PREFIX}{env_id}": title_of(env_id)
        for env_id, entry in listed().items()
        if all(find_spec(package) is not None for package in (entry.module, *entry.requires))
    }
