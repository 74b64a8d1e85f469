"""Every Gymnasium environment with discrete actions and pictures, as the game "gym:ID"."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import cv2
import numpy as np

from tril.games.base import Clock, Game, GameFamily, Screen, ScreenSpec, StartCache
from tril.games.gymnasium.console import GymnasiumConsole, screen_hash
from tril.games.gymnasium.controls import action_names, controls_of
from tril.games.gymnasium.environment import (
    PREFIX,
    AnyEnv,
    Environment,
    Picture,
    UnsuitableEnvironment,
    find,
    titles,
)
from tril.games.gymnasium.readout import ENDS, OVER, GymnasiumReadout
from tril.games.seeds import SeedStarts
from tril.games.settings import MIN_STEPS

LONGEST_STEPS = 1000
"""Steps of an episode, where the environment has no shorter limit; a behaviour can set more."""

MOST_ACTIONS = 24
"""Buttons of the play protocol."""

DEFAULT_RATE_HZ = 30
FASTEST_RATE_HZ = 60
SLOWEST_WAITING_HZ = 8
"""Of a game that waits for its player: how often a button that is held repeats."""

FRAMES_CHECKED = 60
CHECKED_EVERY = 5
"""Frames between the pictures compared of the second and third game of the check."""
LONGEST_CHECK_S = 1.0
"""Time after which the check of a slow environment is content with fewer frames."""


class GymnasiumFamily:
    """The environments, each by "gym:" and its id."""

    def titles(self) -> Mapping[str, str]:
        """Return the titles of those that were seen to work and are installed."""
        return titles()

    def game(self, name: str) -> Game | None:
        """Return the game of an environment, None if the name is none of this family.

        Raises:
            UnsuitableEnvironment: There is no such environment, or it cannot be played; says why.
        """
        return examine(find(name)).game if name.startswith(PREFIX) else None


@dataclass(frozen=True)
class Examined:
    """An environment that was played.

    Attributes:
        game: It as a game.
        digest: Digest of the pictures seen, equal in every process.
    """

    game: Game
    digest: str


def examine(environment: Environment) -> Examined:
    """Make an environment a game, if it can be one: play it to see.

    Raises:
        UnsuitableEnvironment: It cannot be; says why.
    """
    env = environment.make()
    n_actions = environment.n_actions(env)
    if n_actions > MOST_ACTIONS:
        raise UnsuitableEnvironment(
            f"{environment.name} has {n_actions} actions; at most {MOST_ACTIONS} can have a key."
        )
    try:
        env.reset(seed=0)
        picture = Picture.first_of(environment.name, env)
        first = picture.of(env)
        picture, digest = _check_determinism(environment, env, picture)
    except UnsuitableEnvironment:
        raise
    except Exception as error:  # an environment's own code may raise anything
        raise UnsuitableEnvironment(
            f"{environment.name} fails when it is played: {type(error).__name__}: {error}"
        ) from error
    return Examined(_game(environment, env, picture, first), digest)


def _game(environment: Environment, env: AnyEnv, picture: Picture, first: Screen) -> Game:
    def console(game: Game, start_cache: StartCache) -> GymnasiumConsole:
        return GymnasiumConsole(game, environment, picture)

    n_actions = environment.n_actions(env)
    controls = controls_of(action_names(env.unwrapped, n_actions))
    height, width, _ = picture.shape
    grays = cv2.cvtColor(first, cv2.COLOR_RGB2GRAY)
    return Game(
        name=environment.name,
        title=environment.title,
        version=environment.version,
        clock=Clock(
            frame_rate_hz=_frame_rate_hz(env.metadata.get("render_fps"), controls.waits),
            frames_per_step=1,
            max_steps=_max_steps(environment.spec.max_episode_steps, env.unwrapped),
        ),
        controls=controls,
        starts=SeedStarts(environment.title, n_actions),
        screen=ScreenSpec(
            height,
            width,
            palette=None,
            grayscale=None,
            background=int(np.bincount(grays.reshape(-1)).argmax()),
        ),
        ends=ENDS,
        end_rules=(OVER,),
        new_console=console,
        new_readout=GymnasiumReadout,
        saves_states=True,
        has_memory=False,
    )


def _frame_rate_hz(given_rate: Any, waits: bool) -> int:
    is_valid = isinstance(given_rate, int | float) and given_rate >= 1
    rate_hz = min(FASTEST_RATE_HZ, round(given_rate)) if is_valid else DEFAULT_RATE_HZ
    return max(rate_hz, SLOWEST_WAITING_HZ) if waits else rate_hz


def _max_steps(of_spec: int | None, environment: Any) -> int:
    # Some count their steps themselves and tell the limit.
    environment_limit = getattr(environment, "max_steps", None)
    limits = [
        limit for limit in (of_spec, environment_limit) if isinstance(limit, int) and limit > 0
    ]
    return max(MIN_STEPS, min([LONGEST_STEPS, *limits]))


def _check_determinism(
    environment: Environment, env: AnyEnv, picture: Picture
) -> tuple[Picture, str]:
    """Check that equal seeds and actions give equal pictures, however often they are drawn.

    Returns:
        The picture, told whether it has to be drawn at every frame, and a digest of what was seen.

    Raises:
        UnsuitableEnvironment: They differ, or all are the same.
    """
    hashes, differs_at = _compare_environments(environment, env, picture, CHECKED_EVERY)
    if differs_at is not None:
        picture = replace(picture, every_frame=True)
        hashes, differs_at = _compare_environments(environment, environment.make(), picture, 1)
    if differs_at is None:
        differs_at = _compare_replay(environment, env, picture, hashes)
    if differs_at is not None:
        raise UnsuitableEnvironment(
            f"{environment.name} is not deterministic: two games with the same seed and actions"
            f" differ at frame {differs_at}, so recordings could not be replayed."
        )
    if len(set(hashes)) == 1:
        raise UnsuitableEnvironment(
            f"{environment.name} cannot be shown: its picture did not change in {len(hashes) - 1}"
            " random actions."
        )
    return picture, hashes[min(CHECKED_EVERY, len(hashes) - 1)]


def _compare_environments(
    environment: Environment, env: AnyEnv, picture: Picture, interval: int
) -> tuple[list[str], int | None]:
    """Play the same actions in two environments in turn, which reveals a shared generator.

    Args:
        environment: The environment.
        env: The first instance.
        picture: Pictures of the environment.
        interval: Frames between pictures of the second instance.

    Returns:
        Hashes of the first instance's screens, and the frame at which the second differs, if any.
    """
    started_s = time.monotonic()
    first, second = _Player(environment, env), _Player(environment, environment.make())
    hashes = [screen_hash(picture.of(env))]
    if screen_hash(picture.of(second.env)) != hashes[0]:
        return hashes, 0
    for frame, action in enumerate(_actions(environment, env), start=1):
        first.act(action)
        second.act(action)
        hashes.append(screen_hash(picture.of(env)))
        if frame % interval == 0 and screen_hash(picture.of(second.env)) != hashes[frame]:
            return hashes, frame
        if frame % CHECKED_EVERY == 0 and time.monotonic() - started_s > LONGEST_CHECK_S:
            break
    return hashes, None


def _compare_replay(
    environment: Environment, env: AnyEnv, picture: Picture, hashes: Sequence[str]
) -> int | None:
    """Return the frame at which a replay after another game differs, None if it does not."""
    env.reset(seed=1)
    env.step(environment.first_action(env))
    player = _Player(environment, env)
    if screen_hash(picture.of(env)) != hashes[0]:
        return 0
    interval = 1 if picture.every_frame else CHECKED_EVERY
    actions = _actions(environment, env)[: len(hashes) // 2]
    for frame, action in enumerate(actions, start=1):
        player.act(action)
        if frame % interval == 0 and screen_hash(picture.of(env)) != hashes[frame]:
            return frame
    return None


def _actions(environment: Environment, env: AnyEnv) -> list[int]:
    n_actions = environment.n_actions(env)
    return [int(a) for a in np.random.default_rng(0).integers(n_actions, size=FRAMES_CHECKED)]


class _Player:
    """Plays game after game, of the seeds 0, 1 and so on."""

    def __init__(self, environment: Environment, env: AnyEnv) -> None:
        self.env = env
        self._first_action = environment.first_action(env)
        self._seed = 0
        env.reset(seed=0)

    def act(self, action: int) -> None:
        _, _, terminated, truncated, _ = self.env.step(self._first_action + action)
        if terminated or truncated:
            self._seed += 1
            self.env.reset(seed=self._seed)


GYMNASIUM: GameFamily = GymnasiumFamily()
