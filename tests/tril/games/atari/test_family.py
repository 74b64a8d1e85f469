"""Every game of the emulator, without a module of its own."""

from __future__ import annotations

import pickle

import ale_py
import numpy as np
import pytest
from ale_py.roms import get_all_rom_ids

from scripts.surveys.atari import entry_of
from tril.errors import Invalid
from tril.games import game_named, game_titles
from tril.games.atari.catalogue import entries, rom_path
from tril.games.base import Game, spread_starts
from tril.games.settings import GameSettings, Rectangle
from tril.play.episode import Episode
from tril.play.observation import AgentView
from tril.recording import Recording, trajectory, verify
from tril.sample import sample


def test_the_catalogue_has_every_game_that_the_emulator_takes() -> None:
    ale_py.ALEInterface.setLoggerMode(ale_py.LoggerMode.Error)
    emulator = ale_py.ALEInterface()
    for rom in set(get_all_rom_ids()) - set(entries()):
        assert not emulator.isSupportedROM(rom_path(rom)), rom


@pytest.mark.parametrize("name", ["pong", "breakout", "ms_pacman", "air_raid", "backgammon"])
def test_any_game_is_played_recorded_and_seen_again(name: str) -> None:
    game = game_named(name)
    verified = verify(sample(game))
    assert verified.replay.n_frames > game.clock.frame_rate_hz
    assert verified.replay.hashes
    seen = trajectory(verified.recording)
    assert len(seen.actions) == verified.recording.n_steps
    assert seen.observations.std(axis=0).max() > 0


@pytest.mark.parametrize("name", ["seaquest", "demon_attack", "freeway"])
def test_a_start_does_not_depend_on_those_before_it(name: str) -> None:
    """Memory and timer of these games are random when they are reset."""
    game = game_named(name)
    starts = sorted(game.starts.training, key=lambda start: start.key, reverse=True)[:6]
    used = game.make_console()
    for start in starts:
        used.start(start)
        fresh = game.make_console()
        fresh.start(start)
        assert used.ram_bytes() == fresh.ram_bytes(), start


@pytest.mark.parametrize("name", ["qbert", "pong"])
def test_a_state_goes_on_alike_in_a_console_that_has_not_played(name: str) -> None:
    game = game_named(name)
    used = game.make_console()
    used.start(game.starts.training[0])
    state = used.save()
    fresh = game.make_console()
    fresh.restore(state)
    for step in range(60):
        action = step // 10 % game.controls.n_actions
        used.act(action)
        fresh.act(action)
        assert used.ram_bytes() == fresh.ram_bytes(), step


@pytest.mark.parametrize("name", ["pong", "breakout", "freeway", "enduro"])
def test_starts_differ(name: str) -> None:
    game = game_named(name)
    console = game.make_console()
    ends = set()
    for start in spread_starts(game.starts.training, 4):
        episode = Episode(console, start)
        for frame in range(60):
            episode.advance(frame // 8 % game.controls.n_actions)
        ends.add(console.state_hash())
    assert len(ends) == 4


def test_what_is_hidden_is_black_and_nothing_else() -> None:
    game = game_named("pong")
    plain = game.with_settings(GameSettings(hidden=()))
    recording = sample(game)
    seen, everything = (
        trajectory(Recording(one, recording.start, recording.actions)).observations[:, -1]
        for one in (game, plain)
    )
    (score,) = game.screen.hidden
    rows = slice(score.top * 84 // 210, -(-score.bottom * 84 // 210))
    assert everything[:, rows].max() > 0
    assert seen[:, rows].max() == 0
    assert np.array_equal(seen[:, rows.stop :], everything[:, rows.stop :])


@pytest.mark.parametrize("name", ["pong", "air_raid"])
def test_colours_are_the_emulators_own(name: str) -> None:
    game = game_named(name)
    emulator = ale_py.ALEInterface()
    emulator.loadROM(rom_path(name))
    for _ in range(100):
        emulator.act(ale_py.Action.NOOP)
    palette = game.screen.palette
    assert palette is not None
    assert np.array_equal(palette[emulator.getScreen()], emulator.getScreenRGB())


def test_a_score_is_found_by_what_changes_when_the_game_pays() -> None:
    entry = entry_of("pong")
    assert entry["intro"] == {"frames": 0, "button": 0, "hold": 0}
    assert tuple(map(tuple, entry["score"])) == entries()["pong"].hidden


def test_the_intro_of_space_invaders_is_the_known_one() -> None:
    assert entries()["space_invaders"].intro == {"frames": 128, "button": 0, "hold": 0}


def test_a_behaviour_sets_its_game() -> None:
    settings = GameSettings(
        hidden=(Rectangle(0, 0, 160, 40),),
        max_steps=600,
        end_rule="over",
        options=(("difficulty", 1), ("mode", 4)),
    )
    game = game_named("breakout").with_settings(settings)
    assert game.clock.max_frames == 2400
    assert game.end_rule == "over"
    assert game.starts.training[0].key[1:] == (4, 1)
    assert game.screen.hidden == settings.hidden
    assert pickle.loads(pickle.dumps(game)) is game
    assert GameSettings.from_json(settings.to_json()) == settings
    assert game.with_settings(GameSettings()) is game_named("breakout")


@pytest.mark.parametrize(
    ("settings", "reason"),
    [
        ({"max_steps": 10}, "25 to 6000 steps, got 10"),
        ({"end_rule": "hit"}, "no end rule 'hit'; it has life, over"),
        ({"options": {"mode": 3}}, "Expected mode 0, 4"),
        ({"options": {"speed": 3}}, "has no 'speed' to choose"),
        ({"hidden": [[0, 0, 161, 10]]}, "within the screen of 160 x 210"),
        ({"hidden": [[10, 0, 10, 10]]}, "left < right"),
        ({"hidden": [[0, 0, 10, 10]] * 17}, "At most 16 areas"),
        ({"hidden": 3}, "The settings of a game are"),
        ({"max_steps": "long"}, "The settings of a game are"),
    ],
)
def test_settings_that_a_game_does_not_have_are_refused(
    settings: dict[str, object], reason: str
) -> None:
    with pytest.raises(Invalid, match=reason):
        game_named("breakout").with_settings(GameSettings.from_json(settings))


def test_a_life_lost_ends_a_game_unless_its_rule_says_otherwise() -> None:
    game = game_named("breakout")
    frames = {}
    for rule in ("life", "over"):
        episode = Episode(game.make_console(), game.starts.training[0], rule, 60 * 60)
        while episode.end is None:
            episode.advance(episode.frame % 2)
        frames[rule] = (episode.end, episode.frame)
    assert frames["life"][0] == "life"
    assert frames["over"][0] == "over"
    assert frames["life"][1] < frames["over"][1]


def test_titles_are_for_people_and_in_their_order() -> None:
    titles = game_titles()
    assert titles["ms_pacman"] == "Ms. Pac-Man"
    assert list(titles.values()) == sorted(titles.values(), key=str.casefold)
    assert len(titles) >= 100


def test_the_view_of_a_screen_of_another_size_is_resized_whole() -> None:
    game: Game = game_named("air_raid")
    assert game.screen.shape == (250, 160)
    console = game.make_console()
    console.start(game.starts.training[0])
    view = AgentView(game)
    view.reset(console)
    seen = np.empty((4, 84, 84), np.uint8)
    view.observe(seen)
    assert seen[-1].max() > 0
