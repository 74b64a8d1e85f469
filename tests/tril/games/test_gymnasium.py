"""Environments of Gymnasium as games: which are refused and why, names, buttons, states."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt
import pytest

from tril.errors import Invalid
from tril.games import game_named, game_titles
from tril.games.base import EndKind
from tril.games.gymnasium.console import GymnasiumConsole, PlayedState
from tril.games.gymnasium.controls import action_names, controls_of
from tril.games.gymnasium.listing import listed
from tril.games.seeds import SeedStart
from tril.play.episode import Episode
from tril.play.observation import AgentView

_SHARED = np.random.default_rng(0)
"""A generator that all environments of the process draw from, as bad ones do."""

Action = int | np.integer[Any]


class Dot(gymnasium.Env[Any, Any]):
    """A dot that walks to the right with action 1; the game is over at the right edge."""

    metadata = {"render_modes": ["rgb_array"], "render_fps": 15}  # noqa: RUF012 - as gymnasium does
    width = 24
    actions: gymnasium.Space[Any] = gymnasium.spaces.Discrete(2, start=5)

    def __init__(self, render_mode: str | None = None) -> None:
        self.observation_space = gymnasium.spaces.Discrete(self.width)
        self.action_space = self.actions
        self.render_mode = render_mode
        self.at = 0

    def reset(self, *, seed: int | None = None, options: Any = None) -> tuple[int, dict[str, Any]]:
        super().reset(seed=seed)
        self.at = int(self.np_random.integers(8))
        return self.at, {}

    def step(self, action: Action) -> tuple[int, float, bool, bool, dict[str, Any]]:
        assert action in self.action_space
        self.at += int(action) - 5
        return self.at, 1.5, self.at >= self.width - 1, False, {}

    def render(self) -> Any:
        picture = np.zeros((10, self.width, 3), np.uint8)
        picture[5, min(self.at, self.width - 1)] = (255, 0, 0)
        return picture


class Wide(Dot):
    width = 650


class Continuous(Dot):
    actions = gymnasium.spaces.Box(0, 1)


class ManyActions(Dot):
    actions = gymnasium.spaces.Discrete(25)


class Blind(Dot):
    metadata = {"render_modes": ["human"]}  # noqa: RUF012


class Gray(Dot):
    def render(self) -> Any:
        return np.zeros((10, 10), np.uint8)


class Growing(Dot):
    def render(self) -> Any:
        return np.zeros((10, 30 + self.at, 3), np.uint8)


class Still(Dot):
    def render(self) -> Any:
        return np.zeros((10, 10, 3), np.uint8)


class Random(Dot):
    def step(self, action: Action) -> tuple[int, float, bool, bool, dict[str, Any]]:
        self.at = int(_SHARED.integers(self.width - 2))
        return self.at, 0.0, False, False, {}


class SharedSeed(Random):
    """Deterministic alone, but two games at a time disturb each other."""

    def reset(self, *, seed: int | None = None, options: Any = None) -> tuple[int, dict[str, Any]]:
        global _SHARED
        _SHARED = np.random.default_rng(seed)
        return super().reset(seed=seed)


class Forgetful(Dot):
    """Begins again where the game before ended."""

    def __init__(self, render_mode: str | None = None) -> None:
        super().__init__(render_mode)
        self.games = 0

    def reset(self, *, seed: int | None = None, options: Any = None) -> tuple[int, dict[str, Any]]:
        super().reset(seed=seed)
        self.games += 1
        self.at = self.games
        return self.at, {}


class Trail(Dot):
    """Its picture depends on the pictures before, not on the game alone."""

    def __init__(self, render_mode: str | None = None) -> None:
        super().__init__(render_mode)
        self.shown: list[int] = []

    def reset(self, *, seed: int | None = None, options: Any = None) -> tuple[int, dict[str, Any]]:
        self.shown = []
        return super().reset(seed=seed)

    def render(self) -> Any:
        picture: npt.NDArray[np.uint8] = super().render()
        if self.shown[-1:] != [self.at]:
            self.shown.append(self.at)
        picture[0, self.shown[-4:]] = 255
        return picture


class Broken(Dot):
    def __init__(self, render_mode: str | None = None) -> None:
        raise RuntimeError("no licence")


class Failing(Dot):
    def step(self, action: Action) -> tuple[int, float, bool, bool, dict[str, Any]]:
        raise KeyError("level 2")


class Limited(Dot):
    """Counts its steps itself."""

    max_steps = 30

    def reset(self, *, seed: int | None = None, options: Any = None) -> tuple[int, dict[str, Any]]:
        self.n_steps = 0
        return super().reset(seed=seed)

    def step(self, action: Action) -> tuple[int, float, bool, bool, dict[str, Any]]:
        self.n_steps += 1
        at, reward, _, _, info = super().step(action)
        return at, reward, False, self.n_steps >= self.max_steps, info


_KINDS: tuple[Any, ...] = (
    Dot, Wide, Continuous, ManyActions, Blind, Gray, Growing, Still, Random, SharedSeed, Forgetful,
    Trail, Broken, Failing, Limited,
)  # fmt: skip


@pytest.fixture(autouse=True, scope="module")
def registered() -> Iterator[None]:
    for kind in _KINDS:
        gymnasium.register(f"test/{kind.__name__}-v0", kind, max_episode_steps=200)
    yield
    for kind in _KINDS:
        del gymnasium.registry[f"test/{kind.__name__}-v0"]


def name_of(kind: type) -> str:
    return f"gym:test/{kind.__name__}-v0"


@pytest.mark.parametrize(
    ("kind", "reason"),
    [
        (Continuous, "discrete actions"),
        (ManyActions, "25 actions; at most 24"),
        (Blind, "draws no pictures"),
        (Gray, r"expected pictures uint8 \(height, width, 3\), got uint8 \(10, 10\)"),
        (Growing, "its pictures change"),
        (Still, "did not change"),
        (Random, "not deterministic: .* differ at frame"),
        (SharedSeed, "not deterministic"),
        (Forgetful, "not deterministic"),
        (Broken, "RuntimeError: no licence"),
        (Failing, "fails when it is played: KeyError: 'level 2'"),
    ],
)
def test_what_cannot_be_played_is_refused_with_the_reason(kind: type, reason: str) -> None:
    with pytest.raises(Invalid, match=reason):
        game_named(name_of(kind))


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("gym:CartPol-v1", "Did you mean gym:CartPole-v1"),
        ("gym:", "no Gymnasium environment ''"),
        ("gym:ALE/Pong-v5", "Atari"),
        ("gym:os:CartPole-v1", "no package is installed"),
        ("gym:nothing_of_this_name:CartPole-v1", "no package is installed"),
        ("gym:minigrid.nothing:MiniGrid-Empty-5x5-v0", "cannot be imported"),
        ("gym:MountainCarContinuous-v0", "discrete actions"),
    ],
)
def test_unknown_names_are_refused_with_what_to_do(name: str, reason: str) -> None:
    with pytest.raises(Invalid, match=reason):
        game_named(name)


def test_a_game_is_over_where_the_environment_terminates() -> None:
    game = game_named(name_of(Dot))
    console = game.make_console()
    episode = Episode(console, SeedStart(3))
    while episode.end is None:
        episode.advance(1)
    assert episode.end == "over"
    assert game.end(episode.end).kind is EndKind.FAILED
    assert episode.score == 1.5 * episode.frame
    screen = console.screen()
    console.act(1)
    assert console.score == episode.score
    np.testing.assert_array_equal(console.screen(), screen)


def test_an_environment_that_truncates_ends_by_time() -> None:
    game = game_named(name_of(Limited))
    assert game.clock.max_steps == 30
    longer = Episode(game.make_console(), SeedStart(0), max_frames=100)
    while longer.end is None:
        longer.advance(0)
    assert (longer.end, longer.frame) == ("steps", 30)
    assert game.end("steps").kind is EndKind.TIME


def test_a_time_limit_is_the_clocks_and_not_the_environments() -> None:
    game = game_named(name_of(Dot))
    assert game.clock.max_steps == 200
    assert (game.clock.frame_rate_hz, game.clock.frames_per_step) == (15, 1)
    console = game.make_console()
    episode = Episode(console, SeedStart(0), max_frames=300)
    for _ in range(250):
        episode.advance(0)
    assert episode.end is None


def test_large_pictures_are_reduced_by_a_whole_number() -> None:
    game = game_named(name_of(Wide))
    assert (game.screen.height, game.screen.width) == (3, 216)
    console = game.make_console()
    console.start(SeedStart(0))
    assert console.screen().shape == game.screen.shape


def test_a_picture_that_depends_on_those_before_is_drawn_at_every_frame() -> None:
    game = game_named(name_of(Trail))

    def last_screen(looks: bool) -> bytes:
        console = game.make_console()
        console.start(SeedStart(1))
        for _ in range(6):
            console.act(1)
            if looks:
                console.screen()
        return console.screen().tobytes()

    assert last_screen(looks=False) == last_screen(looks=True)


def test_a_state_is_the_seed_and_the_actions() -> None:
    console = game_named("gym:CartPole-v1").make_console()
    console.start(SeedStart(9))
    for action in (0, 1, 1):
        console.act(action)
    state = console.save()
    assert state == PlayedState(9, b"\x00\x01\x01")
    assert console.state_from_bytes(state.to_bytes()) == state
    with pytest.raises(ValueError, match="actions"):
        console.state_from_bytes(PlayedState(9, b"\x07").to_bytes())


def test_a_state_ahead_of_the_game_is_reached_without_beginning_again() -> None:
    console = game_named("gym:CartPole-v1").make_console()
    assert isinstance(console, GymnasiumConsole)
    console.start(SeedStart(9))
    console.act(0)
    early = console.save()
    console.act(1)
    late, screen = console.save(), console.screen()
    console.restore(early)
    console.restore(late)
    np.testing.assert_array_equal(console.screen(), screen)
    assert console.save() == late


def test_a_console_that_is_closed_leaves_the_others_alone() -> None:
    game = game_named("gym:CartPole-v1")
    kept, closed = game.make_console(), game.make_console()
    for console in (kept, closed):
        console.start(SeedStart(0))
        console.screen()
    closed.close()
    kept.act(1)
    kept.screen()
    with pytest.raises(ValueError, match="closed"):
        closed.start(SeedStart(0))


def test_an_observation_shows_every_frame() -> None:
    game = game_named(name_of(Dot))
    console = game.make_console()
    console.start(SeedStart(0))
    view = AgentView(game)
    view.reset(console)
    places = [int(view.observation[-1].max(0).argmax())]
    for frame in range(1, 6):
        console.act(1)
        view.update(console, frame)
        places.append(int(view.observation[-1].max(0).argmax()))
    assert all(before < after for before, after in itertools.pairwise(places))
    assert [int(screen.max(0).argmax()) for screen in view.observation] == places[-4:]


@pytest.mark.parametrize(
    ("name", "actions", "waits"),
    [
        ("gym:CartPole-v1", ("left", "right"), True),
        ("gym:MountainCar-v0", ("left", "idle", "right"), False),
        (
            "gym:MiniGrid-DoorKey-5x5-v0",
            ("left", "right", "forward", "pickup", "drop", "toggle", "done"),
            True,
        ),
        ("gym:highway-fast-v0", ("lane left", "idle", "lane right", "faster", "slower"), False),
    ],
)
def test_actions_have_the_names_that_the_environment_tells(
    name: str, actions: tuple[str, ...], waits: bool
) -> None:
    controls = game_named(name).controls
    assert controls.actions == actions
    assert controls.waits is waits
    assert waits or controls.actions[controls.noop] == "idle"


def test_actions_without_names_are_numbered() -> None:
    class TellsTooFew(Dot):
        def get_action_meanings(self) -> list[str]:
            return ["NOOP"]

    class TellsTwice(Dot):
        action_names = ("go", "go")

    class Tells(Dot):
        def get_action_meanings(self) -> list[str]:
            return ["NOOP", "UP_LEFT"]

    assert action_names(Dot(), 2) == ("action 0", "action 1")
    assert action_names(TellsTooFew(), 2) == ("action 0", "action 1")
    assert action_names(TellsTwice(), 2) == ("action 0", "action 1")
    assert action_names(Tells(), 2) == ("noop", "up left")


def test_every_button_has_a_key_however_many_there_are() -> None:
    controls = controls_of([f"action {number}" for number in range(24)])
    assert set(controls.default_keys.values()) == set(controls.buttons)
    assert len(controls.default_keys) == 24
    mixed = controls_of(("noop", "up", "forward", "left", "jump"))
    assert mixed.default_keys["ArrowUp"] == "up"
    assert set(mixed.default_keys.values()) == set(mixed.buttons)


def test_the_list_has_what_was_seen_to_work_without_making_it() -> None:
    titles = game_titles()
    assert titles["gym:CartPole-v1"] == "CartPole"
    assert titles["gym:MiniGrid-DoorKey-5x5-v0"] == "MiniGrid DoorKey 5x5"
    assert not [name for name in titles if name.startswith("gym:ALE")]
    assert {f"gym:{env_id}" for env_id in listed()} >= {n for n in titles if n.startswith("gym:")}


def test_an_environment_is_named_with_its_module_as_gymnasium_does() -> None:
    game = game_named("gym:minigrid:MiniGrid-Empty-5x5-v0")
    assert game.name == "gym:minigrid:MiniGrid-Empty-5x5-v0"
    assert game.title == "MiniGrid Empty 5x5"
    assert game.version.startswith("minigrid ")
