import base64
import copy
import json
import math
import re
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from io import BytesIO
from pathlib import Path
from typing import Any

import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st
from jsonschema import Draft202012Validator

from testsupport.space_invaders import evaluation_start
from tril.exchange.formats.jsonl import read_lines
from tril.exchange.formats.recording_file import (
    ImportedRecording,
    dump_recording,
    load_recording,
    ranking_of,
)
from tril.exchange.formats.recording_object import Source, parse_recording, recording_schema
from tril.games.atari.catalogue import rom_md5
from tril.games.atari.starts import AtariStart
from tril.games.base import Console, Start
from tril.games.space_invaders import SPACE_INVADERS
from tril.games.space_invaders.ends import EndReason
from tril.games.space_invaders.memory import Action
from tril.play.consoles import Consoles
from tril.play.episode import Episode
from tril.recording import Recorder, Recording, RecordingRefused
from tril.store import models
from tril.text import shown_lines

DOCS = Path(__file__).parents[3] / "docs"
SCHEMA_FILE = DOCS / "exchange-format.schema.json"
DEMONSTRATIONS = Path(__file__).parents[2] / "data" / "column-1.jsonl"


@pytest.fixture(scope="module")
def console() -> Console:
    return SPACE_INVADERS.make_console()


@pytest.fixture(scope="module")
def played(console: Console) -> Recorder:
    """Two aliens shot from where the player stands at the start, until the player is hit."""
    recorder = Recorder(Episode(console, AtariStart(20)))
    while recorder.episode.end is None:
        recorder.advance(Action.FIRE)
    assert recorder.episode.end == EndReason.HIT
    assert len(recorder.episode.taken) >= 2
    return recorder


@pytest.fixture(scope="module")
def full(played: Recorder) -> dict[str, Any]:
    """An object with all members."""
    return dump_recording(
        played.recording(),
        taken=played.episode.taken,
        end=played.episode.end,
        tier=3,
        perfect=True,
        source="person",
        conditions={"keyboard": "a", "delay_s": 1.0},
        parent={"frame": 60},
        notes="slow at first",
    )


@pytest.fixture
def content(full: dict[str, Any]) -> dict[str, Any]:
    return copy.deepcopy(full)


def _refusal(content: object, console: Console) -> str:
    # Not pytest.raises, whose traceback would keep the console alive until the very end.
    try:
        load_recording(content, Consoles(console))
    except RecordingRefused as refusal:
        return str(refusal)
    pytest.fail("It was accepted.")


# Form: the schema and the code


def test_the_published_schema_is_current() -> None:
    assert json.loads(SCHEMA_FILE.read_text()) == recording_schema(), (
        "Regenerate it: python -m scripts.schemas > docs/exchange-format.schema.json"
    )
    Draft202012Validator.check_schema(recording_schema())


MINIMAL: dict[str, Any] = {
    "format": "tril-recording",
    "version": 2,
    "game": "space_invaders",
    "game_version": "0" * 32,
    "start": {"idle_frames": 5, "mode": 0, "difficulty": 0},
    "actions": base64.b64encode(bytes(range(6))).decode(),
}
MEMBERS = [*json.loads(SCHEMA_FILE.read_text())["properties"], "unknown"]
anything = st.one_of(
    st.sampled_from(
        [None, True, False, 0, 1, 1.0, 2, -1, 127, 128, 1.5, 1e9, 2**31 - 1, 2**31, 2**70, "", "A"]
    ),
    st.sampled_from(["person", "robot", "tril-recording", "space_invaders", "0" * 32, "F" * 32]),
    st.sampled_from(["AA==", "AAA=", "AAEC", "AAEG", "AB==", "AAA", "AAEC\n", "A" * 5000, "hit"]),
    st.sampled_from([[], {}, [[0, 5]], [[0, 6]], [[0]], [[0.0, 1]], [0, 0], [[0, 0]] * 37]),
    st.sampled_from([["0" * 16], ["0" * 15], [0], {"idle_frames": 3}, {"mode": 0}, {"a": [1.5]}]),
    st.sampled_from(["a" * 4000, "a" * 4001, "é" * 4000]),
    st.integers(),
    st.text(st.characters(exclude_categories=["Cs", "Cc"]), max_size=40).map(shown_lines),
)


@settings(max_examples=400)
@given(
    st.dictionaries(st.sampled_from(MEMBERS), anything, max_size=3),
    st.dictionaries(st.sampled_from(["idle_frames", "mode", "difficulty", "x"]), anything),
    st.sets(st.sampled_from([*MINIMAL, "idle_frames"]), max_size=1),
)
@example({}, {}, set())
@example({"actions": "AAEC\n"}, {}, set())
@example({"parent": "AAEC\n"}, {}, set())
@example({"version": True}, {}, set())
@example({"version": 2.0}, {"mode": 0.0}, set())
@example({}, {"mode": False}, set())
@example({}, {"difficulty": True}, set())
def test_the_code_accepts_what_the_schema_accepts(
    members: dict[str, Any], start: dict[str, Any], removed: set[str]
) -> None:
    content = {**MINIMAL, "start": {**MINIMAL["start"], **start}, **members}
    for key in removed:
        content.pop(key, None)
        if isinstance(content.get("start"), dict):
            content["start"].pop(key, None)
    # The code reads version 1, too; the schema is today's.
    version = content.get("version")
    assume(isinstance(version, bool) or version != 1)
    # "$" in a schema is the very end, which Python's re reads as "or before a last newline".
    patterned = [k for k, v in recording_schema()["properties"].items() if "pattern" in v]
    strict = not any(str(content.get(key, "")).endswith("\n") for key in patterned)
    valid = Draft202012Validator(recording_schema()).is_valid(content) and strict
    if valid:
        parse_recording(content)
    else:
        with pytest.raises(RecordingRefused):
            parse_recording(content)


@given(st.binary(max_size=12))
def test_the_actions_pattern_accepts_all_bytes_but_none(actions: bytes) -> None:
    pattern = Draft202012Validator(recording_schema()["properties"]["actions"])
    assert pattern.is_valid(base64.b64encode(actions).decode()) == bool(actions)


@given(st.text("ABCDEFQgwIMU=Zz+/", max_size=9))
def test_the_actions_pattern_accepts_only_base64(text: str) -> None:
    if Draft202012Validator(recording_schema()["properties"]["actions"]).is_valid(text):
        assert base64.b64decode(text, validate=True)


def test_the_documented_members_are_the_schemas() -> None:
    page = (DOCS / "exchange-format.md").read_text()
    documented = re.findall(r"^\| `(\w+)` \| (required)?", page, re.MULTILINE)
    assert [member for member, _ in documented] == list(recording_schema()["properties"])
    assert [member for member, required in documented if required] == recording_schema()["required"]
    assert rom_md5("space_invaders") in page


def test_the_documented_example_writes_a_recording_that_is_accepted(console: Console) -> None:
    page = (DOCS / "exchange-format.md").read_text()
    (program,) = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    given = load_recording(json.loads(done.stdout), Consoles(console))
    assert given.replay.end == EndReason.HIT
    assert given.notices == ()


def test_the_sources_are_those_of_the_library() -> None:
    assert set(Source.__args__) == set(models.Source)  # type: ignore[attr-defined]


# Content: replayed


def test_a_recording_survives_the_round_trip(
    console: Console, played: Recorder, content: dict[str, Any]
) -> None:
    through_json = json.loads(json.dumps(content, allow_nan=False))
    assert load_recording(through_json, Consoles(console)) == ImportedRecording(
        recording=played.recording(),
        replay=played.replay(),
        tier=3,
        perfect=True,
        source="person",
        notes="slow at first",
        conditions={"keyboard": "a", "delay_s": 1.0},
        parent={"frame": 60},
        notices=(),
    )


def test_numbers_in_the_conditions_stay_as_they_are(
    console: Console, content: dict[str, Any]
) -> None:
    content["tier"] = 3.0
    given = load_recording(content, Consoles(console))
    assert isinstance(given.tier, int)
    assert isinstance(given.conditions["delay_s"], float)


@settings(max_examples=10)
@given(
    st.builds(AtariStart, st.integers(0, 127), difficulty=st.integers(0, 1)),
    st.lists(st.sampled_from(Action), min_size=1, max_size=20),
)
def test_any_short_game_survives_the_round_trip(
    console: Console, start: Start, steps: list[Action]
) -> None:
    recorder = Recorder(Episode(console, start))
    for action in steps:
        for _ in range(7):
            # Some of these games are lost on the way.
            if recorder.episode.end is None:
                recorder.advance(action)
    content = dump_recording(recorder.recording(), taken=recorder.episode.taken)
    given = load_recording(json.loads(json.dumps(content)), Consoles(console))
    assert given.recording == recorder.recording()
    assert given.taken == recorder.episode.taken
    assert given.notices == ()


def test_only_the_required_members_are_required(console: Console, played: Recorder) -> None:
    content = dump_recording(played.recording())
    del content["hashes"]
    content["start"] = {"idle_frames": 20}
    content["taken"] = None
    given = load_recording(content, Consoles(console))
    assert given.recording == played.recording()
    assert (given.tier, given.perfect, given.source, given.notes) == (None, False, None, "")
    for member in [key for key in content if key != "taken"]:
        left_out = {key: value for key, value in content.items() if key != member}
        assert f"{member} is missing" in _refusal(left_out, console)


def test_an_evaluation_start_is_accepted(console: Console) -> None:
    recording = Recording(SPACE_INVADERS, evaluation_start(0), bytes(30))
    assert load_recording(
        dump_recording(recording), Consoles(console)
    ).recording.start == evaluation_start(0)


def test_actions_after_the_hit_are_cut_with_a_notice(
    console: Console, played: Recorder, content: dict[str, Any]
) -> None:
    content["actions"] = base64.b64encode(played.episode.actions + bytes(130)).decode()
    del content["hashes"]
    given = load_recording(content, Consoles(console))
    assert given.recording == played.recording()
    (notice,) = given.notices
    assert notice == (
        f"Cut at frame {played.episode.frame}, where the player was hit; 130 more actions were"
        " ignored."
    )


def test_actions_after_300_steps_are_cut_with_a_notice(console: Console) -> None:
    content = json.loads(DEMONSTRATIONS.read_text().splitlines()[6])
    actions = base64.b64decode(content["actions"])
    assert len(actions) == 1200
    content["actions"] = base64.b64encode(actions + bytes(10)).decode()
    given = load_recording(content, Consoles(console))
    assert given.recording.n_frames == 1200
    assert given.notices == (
        "Cut at frame 1200, where 300 steps were over; 10 more actions were ignored.",
    )


def test_a_game_that_goes_on_is_accepted_and_its_end_commented(
    console: Console, played: Recorder
) -> None:
    begun = replace(played.recording(), actions=bytes(40), hashes=())
    content = dump_recording(begun, end=EndReason.HIT)
    given = load_recording(content, Consoles(console))
    assert given.replay.end is None
    assert given.notices == ("The given end is 'hit', but the replay does not end.",)
    assert load_recording({**content, "end": None}, Consoles(console)).notices == ()


@pytest.mark.parametrize("end", ["died", "a bomb from above hit the player's cannon", 7, ["hit"]])
def test_an_end_in_other_words_is_compared_and_the_known_ones_named(
    console: Console, played: Recorder, end: object
) -> None:
    content = {**dump_recording(played.recording()), "end": end}
    (notice,) = load_recording(content, Consoles(console)).notices
    assert notice.startswith("The given end is ")
    assert notice.endswith("Known ends: hit, lives, landed, cleared, steps.")


def test_unknown_members_are_left_out_with_a_notice(
    console: Console, content: dict[str, Any]
) -> None:
    (notice,) = load_recording(content | {"tiers": 4}, Consoles(console)).notices
    assert notice == "Unknown members were ignored: tiers."


def test_version_1_is_read_with_its_own_names(console: Console, content: dict[str, Any]) -> None:
    names = {"taken": "hits", "hashes": "ram_hashes", "game_version": "rom_md5"}
    first = {names.get(name, name): value for name, value in content.items()} | {"version": 1}
    then, now = (load_recording(one, Consoles(console)) for one in (first, content))
    assert then == now
    assert "rom_md5: " in _refusal({**first, "rom_md5": ""}, console)
    (notice,) = load_recording(
        first | {"tiers": 4, "start": {**content["start"], "seed": 1}}, Consoles(console)
    ).notices
    assert notice == "Unknown members were ignored: tiers, start.seed."


@pytest.mark.parametrize(
    ("path", "value", "reason"),
    [
        ("format", "trill-recording", "format: expected 'tril-recording', got 'trill-recording'"),
        ("version", 3, "version: expected 2, got 3"),
        ("version", True, "version: expected a number, got True"),
        ("game", "tetris_2", "no game 'tetris_2'"),
        ("game_version", "0" * 32, "another version"),
        ("game_version", "", "game_version"),
        ("start", {"idle_frames": 128}, "0 to 127 idle frames, got 128"),
        ("start", {"idle_frames": -1}, "0 to 127 idle frames, got -1"),
        ("start", {"idle_frames": True}, "start.idle_frames"),
        ("start", {"idle_frames": 3, "mode": 4}, "Expected game mode 0, got 4"),
        ("start", {"idle_frames": 3, "difficulty": 2}, "Expected difficulty 0 or 1"),
        ("start", {}, "A start needs its idle_frames"),
        ("start", 3, "start: "),
        ("actions", "", "at least one frame"),
        ("actions", "AAE", "base64 of one byte per frame"),
        ("actions", "AAEG", "Expected actions 0 to 5, got 6"),
        ("actions", [0, 1], "actions: "),
        ("taken", [[0, 0]], "The replay"),
        ("taken", [[0, 256]], "taken.0.1"),
        ("taken", [[0, 0, 0]], "taken.0"),
        ("tier", -1, "tier: "),
        ("tier", "first", "tier: "),
        ("perfect", "yes", "perfect: "),
        (
            "source",
            "robot",
            "source: expected 'person', 'scripted', 'policy' or 'varied', got 'robot'",
        ),
        ("hashes", ["0" * 16], "Expected 7 hashes"),
        ("hashes", ["md5"], "hashes.0"),
        ("conditions", [], "conditions: "),
        ("notes", "a" * 4001, "notes: "),
        ("notes", "a\0b", "The text 'a\\x00b' can't be accepted. Character 2 is U+0000"),
        ("notes", "a\ud800b", "The text 'a\\ud800b' can't be accepted. Character 2 is U+D800"),
        ("conditions", {"a": [{"b": math.inf}]}, "A number is too large"),
    ],
)
def test_each_refusal_names_its_reason(
    console: Console, content: dict[str, Any], path: str, value: object, reason: str
) -> None:
    assert reason in _refusal({**content, path: value}, console)


def test_a_changed_start_or_action_is_refused_by_the_hashes(
    console: Console, content: dict[str, Any], played: Recorder
) -> None:
    actions = bytearray(played.episode.actions)
    actions[100:104] = bytes([Action.RIGHT] * 4)
    del content["taken"]
    forged = {**content, "actions": base64.b64encode(bytes(actions)).decode()}
    assert "the memory after frame 120" in _refusal(forged, console)
    moved = {**content, "start": {"idle_frames": 21}}
    assert "the memory after frame 60" in _refusal(moved, console)


@pytest.mark.parametrize("content", [None, 3, "tril-recording", [], [{}]])
def test_other_json_is_refused(console: Console, content: object) -> None:
    assert "Expected one JSON object" in _refusal(content, console)


def test_many_wrong_members_give_a_short_refusal(console: Console) -> None:
    reason = _refusal({"taken": [["x" * 60_000, "y"]] * 30}, console)
    assert len(reason) < 600
    assert reason.endswith("more.")


def test_deep_nesting_is_refused(console: Console, content: dict[str, Any]) -> None:
    deep: list[Any] = []
    for _ in range(20_000):
        deep = [deep]
    assert "nested too deeply" in _refusal({**content, "conditions": {"a": deep}}, console)


@pytest.mark.parametrize("member", ["conditions", "parent"])
def test_what_a_recording_carries_along_is_at_most_16_levels_deep(
    member: str, console: Console, content: dict[str, Any]
) -> None:
    carried: dict[str, Any] = {}
    for _ in range(15):
        carried = {"a": carried}
    load_recording({**content, member: carried}, Consoles(console))
    refusal = _refusal({**content, member: {"a": carried}}, console)
    assert f"{member}: expected at most 16 levels of nesting" in refusal


# Files


def _read(file: bytes | str, **limits: int) -> list[tuple[int, object, str | None]]:
    return [(line.number, line.content, line.refusal) for line in read_lines(file, **limits)]


def test_json_lines_are_read_with_their_line_numbers() -> None:
    file = b'\n{"a": 1}\r\n\r\n  {"a": 2}\n{"a": 3}'
    assert _read(file) == [(2, {"a": 1}, None), (4, {"a": 2}, None), (5, {"a": 3}, None)]


@pytest.mark.parametrize(
    "file", ['{"a": 1}', '{"a": 1}\n', '\n\n{\n  "a":\n 1\n}\n', '\ufeff{"a":1}']
)
def test_one_object_is_read_over_one_line_or_several(file: str) -> None:
    ((number, content, refusal),) = _read(file)
    assert content == {"a": 1}
    assert refusal is None
    assert number == (3 if file.startswith("\n\n") else 1)


def test_each_broken_line_is_refused_and_the_others_read() -> None:
    file = b'{"a": 1}\n{"a": \n[1]\n"\xff"\n{"a": NaN}\n{"a": 2}\n3 4'
    lines = _read(file)
    assert [number for number, _, _ in lines] == [1, 2, 3, 4, 5, 6, 7]
    assert [content for _, content, refusal in lines if refusal is None] == [{"a": 1}, {"a": 2}]
    reasons = [refusal or "" for _, _, refusal in lines]
    for reason, expected in zip(
        reasons,
        [
            "",
            "Not JSON: ",
            "one JSON object per line, got [1]",
            "not UTF-8",
            "NaN",
            "",
            "Extra data",
        ],
        strict=True,
    ):
        assert expected in reason


def test_one_broken_object_over_several_lines_is_one_refusal() -> None:
    ((number, _, refusal),) = _read('{\n  "a": 1,\n  "b": oops\n}')
    assert number == 3
    assert refusal is not None
    assert refusal.startswith("Not JSON")


@pytest.mark.parametrize("file", ["", "\n \n"])
def test_an_empty_file_is_refused(file: str) -> None:
    assert _read(file) == [(1, None, "The file has no recordings.")]


def test_lines_that_are_too_long_are_refused_alone() -> None:
    long = json.dumps({"a": "x" * 200})
    file = f'{{"a": 1}}\n{long}\n{{"a": 2}}\n{long}'
    assert _read(file, max_object_bytes=100) == [
        (1, {"a": 1}, None),
        (2, None, "The line is longer than 100 bytes."),
        (3, {"a": 2}, None),
        (4, None, "The line is longer than 100 bytes."),
    ]


def test_more_recordings_than_allowed_are_refused_unread() -> None:
    lines = _read('{"a": 1}\n' * 5, max_objects=3)
    assert lines[:3] == [(n, {"a": 1}, None) for n in (1, 2, 3)]
    assert lines[3:] == [(4, None, "The file has more than 3 recordings. Split it.")]


def test_a_file_without_line_ends_is_not_read_into_memory() -> None:
    class Endless(BytesIO):
        n_read = 0

        def read(self, size: int | None = -1, /) -> bytes:
            assert size is not None
            assert 0 < size < 10_000
            self.n_read += size
            return b"{" * size if self.n_read < 10_000_000 else b""

    (line,) = read_lines(Endless(), max_object_bytes=5000)
    assert line.refusal == "The line is longer than 5000 bytes."


@given(st.lists(st.integers(0, 300), max_size=8), st.integers(20, 120))
def test_lines_are_the_same_whatever_the_pieces_they_are_read_in(
    lengths: list[int], limit: int
) -> None:
    texts = [json.dumps({"a": "x" * length}) for length in lengths]
    expected: list[tuple[int, object, str | None]] = [
        (number, json.loads(text), None)
        if len(text) <= limit
        else (number, None, f"The line is longer than {limit} bytes.")
        for number, text in enumerate(texts, start=1)
    ]
    found = _read("\n".join(texts), max_object_bytes=limit)
    assert found == (expected or [(1, None, "The file has no recordings.")])


@pytest.mark.parametrize("text", ["[" * 30_000, '{"a":' * 9_000, '{"a": ' + "1" * 30_000 + "}"])
def test_hostile_json_is_refused(text: str) -> None:
    ((_, content, refusal),) = _read(text)
    assert content is None
    assert refusal


# Ranking by a file's order


@pytest.fixture(scope="module")
def one(console: Console, full: dict[str, Any]) -> ImportedRecording:
    return load_recording(full, Consoles(console))


def _tiered(one: ImportedRecording, *tiers: int | None) -> Iterator[ImportedRecording]:
    return (replace(one, tier=tier) for tier in tiers)


@pytest.mark.parametrize(
    ("tiers", "expected", "noticed"),
    [
        ((None, None, None), ((0,), (1,), (2,)), False),
        ((1, 2, 2, 7), ((0,), (1, 2), (3,)), False),
        ((7, 2, 2, 1), ((0,), (1, 2), (3,)), False),
        ((5, None, 5, None), ((0, 2), (1,), (3,)), False),
        ((2, 1, 2, 3), ((1,), (0, 2), (3,)), True),
        ((), (), False),
    ],
)
def test_the_lines_order_is_the_ranking_and_equal_tiers_are_ties(
    one: ImportedRecording,
    tiers: tuple[int | None, ...],
    expected: tuple[tuple[int, ...], ...],
    noticed: bool,
) -> None:
    ranking, notices = ranking_of(list(_tiered(one, *tiers)))
    assert ranking.tiers == expected
    assert bool(notices) == noticed
