"""Recordings of others, as one action per frame from the reset on, against the emulator itself."""

from __future__ import annotations

import json
import pickle
import re
from collections.abc import Callable
from functools import cache
from io import BytesIO
from pathlib import Path
from typing import Any

import ale_py
import numpy as np
import pytest

from scripts.convert_demo import convert
from testsupport.workplace import Workplace
from tril.exchange.formats.action_list import with_defaults
from tril.exchange.formats.jsonl import read_lines
from tril.exchange.formats.recording_file import load_recording
from tril.exchange.recording_transfer import RecordingImportResult, import_recordings
from tril.games import game_named
from tril.games.atari.catalogue import rom_path
from tril.games.atari.joystick import ALL_ACTIONS
from tril.games.settings import GameSettings
from tril.play.consoles import Consoles
from tril.recording import RecordingRefused
from tril.store import behaviours, recordings

PAGE = Path(__file__).parents[3] / "docs" / "exchange-format.md"
FRAMES = 900
GAMES = ("pong", "boxing", "space_invaders")
"""Without an intro, with all 18 actions, and with an intro of 128 frames."""

CONSOLES = Consoles()


def emulator(rom: str) -> ale_py.ALEInterface:
    ale_py.ALEInterface.setLoggerMode(ale_py.LoggerMode.Error)
    ale = ale_py.ALEInterface()
    ale.setFloat("repeat_action_probability", 0.0)
    ale.loadROM(rom_path(rom))
    ale.reset_game()
    return ale


def rewards_of(rom: str, actions: list[int]) -> list[int]:
    """Play actions of the minimal set on the emulator itself, right after its reset."""
    ale = emulator(rom)
    minimal = ale.getMinimalActionSet()
    return [int(ale.act(minimal[action])) for action in actions]


@cache
def _played(rom: str) -> tuple[tuple[int, ...], tuple[int, ...]]:
    n_actions = game_named(rom).controls.n_actions
    drawn = np.random.default_rng(5).integers(n_actions, size=FRAMES // 6)
    actions = np.repeat(drawn, 6).tolist()
    return tuple(actions), tuple(rewards_of(rom, actions))


def played(rom: str, **members: Any) -> dict[str, Any]:
    """Return a game that pays, as an action list."""
    actions, rewards = _played(rom)
    assert any(rewards)
    return {
        "format": "tril-actions",
        "version": 1,
        "game": rom,
        "actions": list(actions),
        "rewards": list(rewards),
        "max_steps": FRAMES // 4,
        "end_rule": "over" if rom != "space_invaders" else None,
        **members,
    }


def refusal(content: object) -> str:
    try:
        load_recording(content, CONSOLES)
    except RecordingRefused as refused:
        return str(refused)
    pytest.fail("It was accepted.")


@pytest.mark.parametrize("rom", GAMES)
def test_a_game_from_the_reset_on_pays_what_was_recorded(rom: str) -> None:
    content = played(rom)
    loaded = load_recording(content, CONSOLES)
    n_frames = loaded.replay.n_frames
    assert n_frames > FRAMES // 2
    assert loaded.replay.score == sum(content["rewards"][:n_frames])
    assert loaded.recording.actions == bytes(content["actions"][:n_frames])
    start = loaded.recording.start.to_json()
    assert start == {"idle_frames": 0, "mode": 0, "difficulty": 0} | (
        {"intro": 0} if rom == "space_invaders" else {}
    )


@pytest.mark.parametrize("rom", GAMES)
def test_an_altered_action_is_refused_at_the_frame_where_the_game_pays_otherwise(rom: str) -> None:
    content = played(rom)
    altered = list(content["actions"])
    shown = load_recording(content, CONSOLES).replay.n_frames
    n_actions = game_named(rom).controls.n_actions
    for frame in range(0, shown, 6):
        altered[frame] = (altered[frame] + 1) % n_actions
        paid = rewards_of(rom, altered)[:shown]
        if differing := [n for n in range(shown) if paid[n] != content["rewards"][n]]:
            break
    first = differing[0]
    assert (
        f"leaves the recorded rewards at frame {first + 1:,}: the game pays {paid[first]:g},"
        f" the recording says {content['rewards'][first]:g}."
    ) in refusal(content | {"actions": altered})


@pytest.mark.parametrize(
    "written",
    [
        lambda names: {"actions": names},
        lambda names: {"actions": [name.lower() for name in names]},
        lambda names: {"actions": "\n".join(names)},
        lambda names: {"numbers": "full", "actions": list(map(ALL_ACTIONS.index, names))},
        lambda names: {"numbers": "full", "actions": [*names[:9], *map(_full, names[9:])]},
        lambda names: {"numbers": "full", "actions": ", ".join(str(_full(n)) for n in names)},
    ],
    ids=["names", "lower case", "text", "full numbers", "mixed", "text of numbers"],
)
def test_actions_are_names_or_numbers_of_either_set(
    written: Callable[[list[str]], dict[str, Any]],
) -> None:
    content = played("boxing")
    names = [game_named("boxing").controls.actions[action] for action in content["actions"]]
    given = load_recording(content | written(names), CONSOLES)
    assert given.recording.actions == bytes(content["actions"])
    assert given.notices == ()


def _full(name: str) -> int:
    return ALL_ACTIONS.index(name)


def test_all_actions_are_numbered_as_the_emulator_does() -> None:
    assert [ale_py.Action(number).name for number in range(18)] == list(ALL_ACTIONS)


def test_what_a_game_has_no_action_for_is_read_as_what_is_left_of_it() -> None:
    """The emulator itself plays Pong alike with all actions and with those that are left."""
    drawn = np.repeat(np.random.default_rng(7).integers(18, size=150), 6).tolist()
    ale = emulator("pong")
    rewards = [int(ale.act(ale_py.Action(action))) for action in drawn]
    ram = ale.getRAM().tobytes()
    content = played("pong", numbers="full", actions=drawn, rewards=rewards)
    loaded = load_recording(content, CONSOLES)
    console = CONSOLES.of(loaded.recording.game)
    assert console.ram_bytes() == ram
    (notice,) = loaded.notices
    assert notice.startswith("Pong has fewer actions: ")
    assert f"UPRIGHT ({drawn.count(6):,} frames) was read as RIGHT" in notice


@pytest.mark.parametrize(
    ("members", "message"),
    [
        ({"version": 2}, "Expected version 1 of tril-actions, got 2"),
        ({"version": True}, "Expected version 1 of tril-actions, got True"),
        ({"game": None}, "game: expected the name of a game"),
        ({"game": "x" * 200}, "game: expected the name of a game"),
        ({"game": "pang"}, "There is no game 'pang' here. `tril games list`"),
        ({"game_version": "0" * 32}, "was played on another version of Pong"),
        ({"actions": None}, "actions: expected a list with one action per frame"),
        ({"actions": []}, "actions: expected a list with one action per frame"),
        ({"actions": [0, 6]}, "Frame 2: expected an action from 0 to 5 or one of NOOP, FIRE"),
        ({"actions": [0, 1.5]}, "Frame 2: expected an action from 0 to 5"),
        ({"actions": [0, True]}, "Frame 2: expected an action from 0 to 5"),
        ({"actions": [0, ["NOOP", 3]]}, "Frame 2: expected an action from 0 to 5"),
        ({"actions": "NOOP FIRE JUMP"}, "Frame 3: expected an action from 0 to 5"),
        ({"actions": "0 -1"}, "Frame 2: expected an action from 0 to 5"),
        ({"actions": "0 " + "9" * 5000}, "Frame 2: expected an action from 0 to 5"),
        ({"actions": [18], "numbers": "full"}, "Frame 1: expected an action from 0 to 17"),
        ({"numbers": "all"}, "numbers: expected 'minimal' or 'full', got 'all'"),
        ({"rewards": [0]}, "rewards: expected one for each of the 900 actions, got 1"),
        ({"rewards": [0, "1"]}, "rewards: expected a number for frame 2, got '1'"),
        ({"rewards": [0, 10**308 * 5]}, "rewards: expected a number for frame 2"),
        ({"rewards": 3}, "rewards: expected a list with one number per frame"),
        ({"start": {"idle_frames": 200}}, "Expected 0 to 127 idle frames, got 200"),
        ({"start": "title"}, "start: expected a valid dictionary, got 'title'"),
        ({"max_steps": 9000}, "Expected games of 25 to 6000 steps, got 9000"),
        ({"end_rule": "hit"}, "no end rule 'hit'"),
        ({"tier": -1}, "tier: expected"),
    ],
)
def test_a_list_that_is_wrong_is_refused_with_a_sentence(
    members: dict[str, Any], message: str
) -> None:
    assert message in refusal(played("pong") | members)


def test_a_game_that_is_not_of_the_emulator_has_its_own_start() -> None:
    content = {
        "format": "tril-actions",
        "version": 1,
        "game": "gym:CartPole-v1",
        "actions": "left right left",
    }
    start = game_named("gym:CartPole-v1").starts.training[0].to_json()
    assert "has no start right after a reset; give one such as" in refusal(content)
    assert "is not played with a joystick" in refusal(content | {"numbers": "full"})
    loaded = load_recording(content | {"start": start, "rewards": [1, 1, 1]})
    assert loaded.replay.n_frames == 3


def imported(workplace: Workplace, content: object, **options: Any) -> RecordingImportResult:
    """Import into a new behaviour of Pong, whose games have 6 s and end when it is over."""
    with workplace.database.writing() as session:
        name = behaviours.free_name(session, "Keep level")
        settings = GameSettings(max_steps=90, end_rule="over")
        row = behaviours.create(session, name, game="pong", settings=settings)
    return import_recordings(workplace.database, row.id, json.dumps(content), **options)


def test_a_longer_game_is_cut_at_the_length_of_the_behaviours_games(workplace: Workplace) -> None:
    content = played("pong", max_steps=None, end_rule=None, tier=1)
    result = imported(workplace, content, rank=True)
    (cut, advice) = (notice.reason for notice in result.notices)
    assert cut.startswith("Cut at frame 360, where the time was over; 540 more actions were")
    assert advice.startswith("Its first 360 frames were imported, the longest game of the")
    with workplace.database.reading() as session:
        row = recordings.get(session, result.recording_ids[0])
        assert (row.game, row.n_frames, row.max_steps) == ("pong", 360, 90)
        assert (row.end_rule, row.source, row.verification) == ("over", "person", "verified")
        assert row.score == sum(content["rewards"][:360])


def test_a_list_may_name_its_own_length_and_rule() -> None:
    game = game_named("breakout").with_settings(GameSettings(max_steps=90, end_rule="over"))
    content = played("pong") | {"game": "breakout", "end_rule": "life"}
    assert with_defaults(content, game) == content
    assert with_defaults(content | {"max_steps": None}, game) == content | {"max_steps": 90}
    for other in ({"format": "tril-recording", "game": "breakout"}, {"format": "tril-actions"}):
        assert with_defaults(other, game) == other


@pytest.mark.parametrize("rom", ["boxing", "space_invaders"])
def test_a_game_of_another_game_is_refused(workplace: Workplace, rom: str) -> None:
    result = imported(workplace, played(rom))
    assert result.recording_ids == []
    (message,) = result.refusals
    assert re.match("It is a game of .*, but the behaviour is one of Pong. Import", message.reason)


def test_a_list_of_names_of_a_long_game_fits_into_a_line() -> None:
    content = {"format": "tril-actions", "actions": ["DOWNRIGHTFIRE"] * 100_000}
    text = json.dumps(content)
    assert [line.content for line in read_lines(f"{text}\n{text}\n")] == [content, content]


def test_the_documented_example_is_accepted() -> None:
    (example,) = re.findall(r"```json\n(.*?)```", PAGE.read_text(), re.DOTALL)
    loaded = load_recording(json.loads(example), CONSOLES)
    assert (loaded.replay.n_frames, loaded.notices) == (8, ())


# Demonstrations of openai/atari-reset


def demonstration(**members: Any) -> bytes:
    actions, rewards = _played("pong")
    content = {
        "actions": [np.int64(action) for action in actions],
        "rewards": [0.0, *map(float, rewards)],
        "checkpoints": [np.zeros(3, np.uint8)],
        **members,
    }
    return pickle.dumps(content, protocol=3)


@pytest.mark.parametrize("core", [b"numpy._core.", b"numpy.core."])
def test_a_demonstration_is_converted(core: bytes) -> None:
    file = demonstration().replace(b"numpy._core.", core)
    assert core in file
    content = convert(BytesIO(file), "pong")
    loaded = load_recording(content | {"max_steps": FRAMES // 4}, CONSOLES)
    assert loaded.recording == load_recording(played("pong"), CONSOLES).recording


def test_a_demonstration_without_rewards_is_converted_without() -> None:
    assert convert(BytesIO(demonstration(rewards=[])), "pong")["rewards"] is None


def test_a_pickle_of_anything_else_is_refused() -> None:
    with pytest.raises(pickle.UnpicklingError, match="print is not allowed"):
        convert(BytesIO(pickle.dumps({"actions": [print]}, protocol=3)), "pong")
    with pytest.raises(ValueError, match="Expected 900 rewards, got 3"):
        convert(BytesIO(demonstration(rewards=[1.0] * 3)), "pong")
    with pytest.raises(ValueError, match="with its actions"):
        convert(BytesIO(pickle.dumps([1])), "pong")
